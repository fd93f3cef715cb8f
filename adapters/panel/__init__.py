"""Solvers of the panels: one module each, but for the parts that several share."""

SHARED = frozenset({"common", "finite_element"})
