"""Solvers of the particles: one module each, but for the parts that several share.

``bridge`` is the C++ between LIGGGHTS and its adapter.
"""

SHARED = frozenset({"solid_spheres"})
