"""Friction on the deck against its slope."""

from __future__ import annotations

import math

from orchestrator.case.bed.adhesion import surface_materials
from orchestrator.case.bed.contact_times import smallest_diameters_m
from orchestrator.case.tables.case import Case, Contact
from orchestrator.preflight.scene.scene import Scene


def on_deck(case: Case) -> list[Contact]:
    """Contacts of particles with panels or, without any, with other surfaces."""
    grains = set(smallest_diameters_m(case))
    panels = {panel.material for panel in case.screen.panels.values()} or surface_materials(case)
    return [
        row
        for row in case.contacts
        for grain, panel in (row.between, row.between[::-1])
        if grain in grains and panel in panels
    ]


def of_slope(friction: float, slope: float) -> float:
    """Share of a slope's acceleration that friction takes; infinite on the level."""
    if slope < 1e-9:
        return math.inf if friction else 0.0
    return friction / slope


def of_weight(scene: Scene, friction: float) -> float:
    """Of a coefficient, or as a run has it carried: share of what pulls the bed down the deck."""
    bearing = scene.seen.bearing
    return of_slope(friction, scene.slope) * (1.0 if bearing is None else bearing.carried)


def takes(ratio: float, how: str) -> str:
    """That share in words."""
    if math.isinf(ratio):
        return "on the level, friction holds what lies"
    if ratio >= 1:
        return f"what is {how} stops on the flattest panel"
    return f"takes {ratio:.0%} of the acceleration of what is {how} down the flattest panel"
