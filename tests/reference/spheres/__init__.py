"""A few to some hundred spheres in NumPy, alone or as grains of several, with which LIGGGHTS is compared.

Equations, limits and what was measured: docs/theory/spheres.md.
"""

from __future__ import annotations

from orchestrator.ports.adapters import ParticlesAdapter
from orchestrator.ports.plans import Cost, ParticlesPlan, ParticlesWork
from tests.reference.spheres.particles import SpheresSolver


def build(plan: ParticlesPlan) -> SpheresSolver:
    """Open the spheres of a plan.

    Raises ValueError for periodic sides, which this solver lacks, or a bad restitution.
    """
    if plan.periodic_y:
        raise ValueError(
            "particles solver 'spheres' has no periodic sides: give the slice walls or use 'liggghts'"
        )
    return SpheresSolver(plan)


def cost(work: ParticlesWork) -> Cost:
    """Return the time of NumPy's calls, however many spheres there are, and of the neighbours of each."""
    stepping_s = 6e-4 * work.runs + 6.5e-4 * work.steps + 2.7e-6 * work.particle_steps
    return Cost(0.05, stepping_s)


ADAPTER = ParticlesAdapter(
    about="a few spheres, in NumPy", build=build, cost=cost, periodic=False, fidelity=1
)
