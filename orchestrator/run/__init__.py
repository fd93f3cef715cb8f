"""A run from its first interval to its last: the loop, its monitor, its checkpoints, its end."""
