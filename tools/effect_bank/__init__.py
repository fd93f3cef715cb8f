"""A bank of scenes that tests the verdicts on effects by runs with and without each effect."""
