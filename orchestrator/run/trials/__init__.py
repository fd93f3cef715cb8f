"""Short runs beside a run, in folders that are removed: without an effect, and at half the interval."""
