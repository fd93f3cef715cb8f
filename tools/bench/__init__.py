"""Benchmarks of the program itself: the cost of the coupling, and of each effect of a case.

``python -m tools.bench CASE`` runs them in a clone of the repository.
"""
