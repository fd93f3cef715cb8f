"""A bank of scenes that tries out whether the verdicts on effects are right."""
