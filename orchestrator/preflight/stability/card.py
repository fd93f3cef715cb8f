"""The stability card of a case: every bound of its sync interval, before anything runs.

``card`` needs a case without problems.  It asks the panels' solver for its largest step, which for
a sheet takes about a second.
"""

from __future__ import annotations

from collections.abc import Iterator

from orchestrator.case.bed.contact_times import LARGEST_RAYLEIGH_FRACTION, shortest_rayleigh_s
from orchestrator.case.bed.particle_step import particle_step_s
from orchestrator.case.file.contents import has_particles
from orchestrator.case.tables.case import Case
from orchestrator.preflight.scene.scene import scene
from orchestrator.preflight.stability import frame_bounds, panel_bounds
from orchestrator.preflight.stability.bound import Bound, Card, StepBound
from orchestrator.preflight.stability.facts import facts
from orchestrator.preflight.stability.frame_modes import frame_matrices
from orchestrator.preflight.stability.panel_modes import highest_rad_per_s
from orchestrator.preflight.stability.surface_bounds import surface_bounds

RAYLEIGH = "Li, Xu and Thornton 2005, and the share that is usual"


def card(case: Case) -> Card:
    """All bounds of a case without problems that names its scheme (choice.py: ``settled_card``)."""
    there = scene(case)
    modes_rad_per_s, unknown = highest_rad_per_s(case)
    frames = frame_matrices(there)
    bounds: list[Bound] = []
    if has_particles(case):
        bounds += surface_bounds(there)
    if has_particles(case) and there.panels:
        bounds += panel_bounds.contacts(there, modes_rad_per_s, frames)
    if frames is not None and there.panels:
        bounds += frame_bounds.panels_on_frames(case, frames)
    return Card(
        scheme=case.coupling.scheme,
        interval_s=case.coupling.sync_interval_s,
        bounds=tuple(bounds),
        steps=tuple(particle_steps(case)),
        facts=facts(there, modes_rad_per_s, unknown, frames),
    )


def particle_steps(case: Case) -> Iterator[StepBound]:
    """The particles' step against the Rayleigh time."""
    if not has_particles(case):
        return
    rayleigh_s = shortest_rayleigh_s(case)
    yield StepBound(
        "particles' step",
        particle_step_s(case),
        LARGEST_RAYLEIGH_FRACTION * rayleigh_s,
        RAYLEIGH,
        f"{LARGEST_RAYLEIGH_FRACTION:g} of the smallest one's Rayleigh time {rayleigh_s:.3g} s",
    )
