"""Shapes of grains: one module each."""

SHARED: frozenset[str] = frozenset()
