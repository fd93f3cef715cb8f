"""A few to some hundred spheres in NumPy: for tests and for the draft level.

Equations, limits and what was measured: docs/theory/spheres.md.
"""

from __future__ import annotations

from adapters.particles.spheres.particles import SpheresSolver
from orchestrator.ports.plans import ParticlesPlan


def build(plan: ParticlesPlan) -> SpheresSolver:
    """Open the spheres of a plan.

    Raises ValueError for periodic sides, which this solver lacks, or a bad restitution.
    """
    if plan.periodic_y:
        raise ValueError(
            "particles solver 'spheres' has no periodic sides: give the slice walls or use 'liggghts'"
        )
    return SpheresSolver(plan)
