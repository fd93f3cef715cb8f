"""Solvers of the frames; ``common`` has what several of them are made of."""
