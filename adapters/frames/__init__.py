"""Solvers of the frames: one module each, but for the parts that several share."""

SHARED = frozenset({"common"})
