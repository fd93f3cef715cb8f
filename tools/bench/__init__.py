"""Benchmarks of the program itself: what the coupling costs, and each effect of a case.

``python -m tools.bench CASE`` in a clone of the repository.
"""
