"""The time step of the particles."""

from __future__ import annotations

from orchestrator.case.bed.adhesion import adhesive_step_s
from orchestrator.case.bed.contact_times import shortest_rayleigh_s
from orchestrator.case.tables.case import Case


def particle_step_s(case: Case) -> float:
    """The largest step that the case allows its particles."""
    if case.particles.step_s > 0:
        return case.particles.step_s
    return min(
        case.particles.rayleigh_fraction * shortest_rayleigh_s(case),
        adhesive_step_s(case),
        case.coupling.sync_interval_s,
    )
