"""What a run leaves behind: its folder and records, the results computed from them, the report."""
