"""What each particle solver costs; what is asked and answered: orchestrator/ports/plans/work.py.

Processor time on one core of a 2-core AMD EPYC machine that was busy with other work.  Measured on
drafts of shipped cases; ``python -m tests.cost_series`` measures predicted over taken.
"""

from __future__ import annotations

from orchestrator.ports.plans import Cost, ParticlesWork


def none(work: ParticlesWork) -> Cost:
    return Cost(0.0, 0.0)


def spheres(work: ParticlesWork) -> Cost:
    """NumPy's calls, which do not ask how many there are, and the neighbours of each."""
    stepping_s = 6e-4 * work.runs + 6.5e-4 * work.steps + 2.7e-6 * work.particle_steps
    return Cost(0.05, stepping_s)


def liggghts(work: ParticlesWork) -> Cost:
    """A wet bed: 50 000 particles at rest on the deck of cases/ffs0827-slice; else its level dry,
    single particles that are thrown; an interval and a step: a few balls."""
    a_particle_s = 6e-7 if work.sticky else 2.8e-7
    step_s = 1.5e-5 + 4e-9 * work.triangles
    stepping_s = 1.4e-4 * work.runs + step_s * work.steps + a_particle_s * work.particle_steps
    return Cost(0.1 + 1e-5 * work.triangles, stepping_s)
