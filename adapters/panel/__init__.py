"""Solvers of the panels; ``common`` has what several of them are made of."""
