"""Solvers of the frames: one module or package for each, and ``common`` for the parts that several share."""

SHARED = frozenset({"common"})
