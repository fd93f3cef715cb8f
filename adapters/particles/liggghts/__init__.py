"""Particles by LIGGGHTS 3.8.0 (DEM: C. Kloss et al., Prog. Comput. Fluid Dyn. 12 (2012) 140-152,
doi 10.1504/PCFD.2012.047457), in this process and without files."""

from __future__ import annotations

from orchestrator.ports import Particles
from orchestrator.ports.adapters import ParticlesAdapter
from orchestrator.ports.plans import Cost, ParticlesPlan, ParticlesWork

BODY, BODY_THROWN = 1.8, 3.3
"""The cost of a body of one sphere over that of a sphere of LIGGGHTS's own, in a bed and thrown."""
AIR_S = 2.3e-8
"""Time of the drag of air on a particle in a step (docs/theory/air.md)."""


def build(plan: ParticlesPlan) -> Particles:
    """Start LIGGGHTS with the plan's particles on the surface at t = 0.

    Raises SolverFailed if LIGGGHTS refuses the input, SolverMissing without the bridge.  In a
    parallel run an error can stop a single rank; the caller must then abort the communicator.
    """
    from adapters.particles.liggghts.particles import Liggghts

    return Liggghts(plan)


def cost(work: ParticlesWork) -> Cost:
    """Return the measured cost.

    It comes from 50 000 sticky particles at rest on the deck of cases/ffs0827-slice, from the same without
    adhesion, and from the thrown layers of its level dry and of cases/ffs0827-effects; the interval and the
    step come from a few balls.  Clumps cost ``BODY`` times as much, and the more the more spheres they have
    (docs/theory/clumps.md).
    """
    a_particle_s = 3e-7 if work.sticky else 2e-8 if work.thrown else 1.3e-7
    if work.spheres_each > 1.0:
        a_particle_s *= (BODY_THROWN if work.thrown else BODY) * work.spheres_each**0.9
    a_particle_s += AIR_S if work.in_air else 0.0
    step_s = 6e-6 + 1.6e-9 * work.triangles
    stepping_s = 4e-5 * work.runs + step_s * work.steps + a_particle_s * work.particle_steps
    return Cost(0.05 + 5e-6 * work.triangles, stepping_s)


ADAPTER = ParticlesAdapter(
    about="discrete elements, any number of them (LIGGGHTS)",
    build=build,
    cost=cost,
    needs=("adapters.particles.liggghts.particles",),
    fidelity=2,
)
