"""Solvers of the particles: one module each.

``bridge`` is the C++ between LIGGGHTS and its adapter.
"""

SHARED: frozenset[str] = frozenset()
