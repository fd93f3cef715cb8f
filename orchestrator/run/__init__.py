"""A run from its first interval to its last: the loop, the watch over it, its saves, its end."""
