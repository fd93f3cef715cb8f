"""The stability card of a case: every bound of its sync interval, before anything runs.

``card`` needs a case without mistakes.  It asks the panels' solver for its largest step, which for
a sheet takes about a second.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from orchestrator.bed.contact_times import LARGEST_RAYLEIGH_FRACTION, shortest_rayleigh_s
from orchestrator.bed.particle_step import particle_step_s
from orchestrator.casefile.case import Case
from orchestrator.casefile.contents import has_particles
from orchestrator.scene.scene import Scene, scene
from orchestrator.stability import frame_bounds, panel_bounds
from orchestrator.stability.bound import Bound, Card, StepBound
from orchestrator.stability.facts import facts
from orchestrator.stability.frame_modes import frame_matrices
from orchestrator.stability.panel_modes import highest_rad_s
from orchestrator.stability.touching import touches

INTERVALS_PER_CONTACT = 10
RAYLEIGH = "Li, Xu and Thornton 2005, and the share that is usual"
IMPACT = "docs/theory/stability.md, impacts"


def card(case: Case) -> Card:
    """All bounds of a case without mistakes that names its scheme (choice.py: ``settled_card``)."""
    there = scene(case)
    modes_rad_s, unknown = highest_rad_s(case)
    frames = frame_matrices(there)
    bounds: list[Bound] = []
    if has_particles(case) and there.panels:
        bounds += shortest_impact(there)
        bounds += panel_bounds.contacts(there, modes_rad_s, frames)
    if frames is not None and there.panels:
        bounds += frame_bounds.panels_on_frames(case, frames)
    return Card(
        scheme=case.coupling.scheme,
        interval_s=case.coupling.sync_interval_s,
        bounds=tuple(bounds),
        steps=tuple(particle_steps(case)),
        facts=facts(there, modes_rad_s, unknown, frames),
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


def shortest_impact(there: Scene) -> Iterator[Bound]:
    """At least ten intervals to the shortest impact that loads a panel."""
    materials = {panel.material for panel in there.case.screen.panels.values()}
    every = [touch for name in materials for touch in touches(there, name)]
    shortest = min(every, key=lambda touch: touch.impact_s)
    if math.isfinite(shortest.impact_s):
        yield Bound(
            "shortest impact",
            shortest.impact_s / INTERVALS_PER_CONTACT,
            IMPACT,
            f"{shortest} at {there.impact_m_s:.3g} m/s for {shortest.impact_s:.3g} s, "
            f"{INTERVALS_PER_CONTACT} intervals",
            "accuracy",
        )
