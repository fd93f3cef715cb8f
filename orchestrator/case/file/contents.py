"""What a case has at all."""

from __future__ import annotations

from orchestrator.case.solvers import NONE
from orchestrator.case.tables.case import Case


def has_particles(case: Case) -> bool:
    """Whether there are or will be any."""
    described = case.bed.particles or case.bed.blocks or case.bed.feeds
    return bool(described) and case.particles.solver != NONE


def damped_contacts(case: Case) -> bool:
    """Whether particles lose energy where they touch something."""
    return has_particles(case) and any(row.restitution < 1 for row in case.contacts)


def absent(case: Case) -> dict[str, str]:
    """What this case does not have at all, and another might: name -> why."""
    screen = case.screen
    there = {
        "particles": (has_particles(case), "the bed is empty, or particles.solver none"),
        "exciters": (bool(screen.exciters), "there are none"),
        "bushings": (bool(screen.bushings), "there are none"),
        "surfaces": (bool(screen.surfaces), "there are none"),
        "gravity": (any(case.gravity_m_per_s2), "gravity_m_per_s2 is zero"),
    }
    return {name: why for name, (is_there, why) in there.items() if not is_there}
