"""The intervals of single runs beside the scatter between runs."""
