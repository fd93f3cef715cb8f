"""Solvers of the particles; ``surface`` is what the spheres touch, ``bridge`` is LIGGGHTS's."""
