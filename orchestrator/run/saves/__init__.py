"""Saves: a run stopped at any sync point goes on, bit for bit, as if it had not stopped."""
