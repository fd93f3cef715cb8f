"""What the monitor observes: one item in each module, found by its being here."""
