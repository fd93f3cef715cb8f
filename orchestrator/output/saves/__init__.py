"""Saves on disk: the files of a run's state, and the names of what is in them."""
