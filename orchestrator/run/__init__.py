"""A run: the loop over the sync intervals, its monitor, its checkpoints and its end."""
