"""The output of a run: its folder and records, the results computed from them, and the report."""
