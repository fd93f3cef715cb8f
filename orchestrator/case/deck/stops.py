"""Beams below panels, with the layer on them that the sync interval allows."""

from __future__ import annotations

import math

from orchestrator.case.deck.panels import SinglePanel
from orchestrator.case.tables import stop as tables
from orchestrator.case.tables.case import Case
from orchestrator.ports.plans import StopPlan

USUAL, MOST = 0.1, 1.0
"""k dt^2 / m of a layer of stiffness k under a mass m per area; beyond 4 it is unstable."""


def planned_stops(case: Case, panel: SinglePanel) -> tuple[StopPlan, ...]:
    """Of one panel, in the order of the case."""
    return tuple(_stop(case, panel, name, row) for name, row in panel.table.stops.items())


def stiffest_Pa_per_m(case: Case, panel: SinglePanel) -> float:
    """What the sync interval allows."""
    return MOST * areal_mass_kg_per_m2(case, panel) / case.coupling.sync_interval_s**2


def areal_mass_kg_per_m2(case: Case, panel: SinglePanel) -> float:
    """Mass of the panel per area, openings and all."""
    solid = 1.0 if panel.apertures is None else panel.apertures.material_share(panel.rectangle)
    density_kg_per_m3 = case.materials[panel.table.material].density_kg_per_m3
    return density_kg_per_m3 * panel.table.thickness_m * solid


def _stop(case: Case, panel: SinglePanel, name: str, row: tables.Stop) -> StopPlan:
    mass_kg_per_m2 = areal_mass_kg_per_m2(case, panel)
    stiffness_Pa_per_m = row.stiffness_Pa_per_m or USUAL / MOST * stiffest_Pa_per_m(case, panel)
    nearer = (row.from_m + row.to_m) / 2 > panel.table.length_m / 2
    return StopPlan(
        name=name,
        frame=row.frame or panel.frames[nearer],
        from_m=row.from_m,
        to_m=row.to_m,
        gap_m=row.gap_m,
        stiffness_Pa_per_m=stiffness_Pa_per_m,
        damping_Pa_s_per_m=2 * row.damping_ratio * math.sqrt(stiffness_Pa_per_m * mass_kg_per_m2),
    )
