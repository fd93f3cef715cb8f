"""What each frame solver costs; what is asked and answered: orchestrator/ports/plans/work.py.

Processor time on one core of a 2-core AMD EPYC machine that was busy with other work.  Measured on
drafts of shipped cases; ``python -m tests.cost_series`` measures predicted over taken.
"""

from __future__ import annotations

from orchestrator.ports.plans import Cost, FramesWork


def prescribed(work: FramesWork) -> Cost:
    return Cost(0.01, work.runs * (3.5e-5 + 1.5e-4 * work.driven))


def two_mass(work: FramesWork) -> Cost:
    return Cost(0.02, work.runs * 2e-4)


def planar(work: FramesWork) -> Cost:
    """A motor is sought within each step."""
    return Cost(0.05, work.runs * (6e-4 + 8e-4 * work.motors))


def exudyn(work: FramesWork) -> Cost:
    """A call, and steps of some 1e-4 s."""
    return Cost(0.4, work.runs * (5e-4 + 1.6 * work.interval_s))
