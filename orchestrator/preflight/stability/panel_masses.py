"""The least mass that a contact finds at a point of the surface."""

from __future__ import annotations

import math

from orchestrator.case import solvers
from orchestrator.case.deck.panels import single_panels
from orchestrator.case.planning import panel_plans
from orchestrator.case.tables.case import Case
from orchestrator.case.tables.screen import PanelTable
from orchestrator.ports.geometry import AperturePattern


def areal_kg_per_m2(case: Case, panel: PanelTable) -> float:
    """Mass of the perforated part per area."""
    solid = AperturePattern(**dict(panel.apertures)).solid_share if panel.apertures else 1.0
    return solid * case.materials[panel.material].density_kg_per_m3 * panel.thickness_m


def lightest_point_kg(case: Case, name: str) -> float:
    """Effective mass of the lightest point of the surface of the panels ``name``, as their solver
    tells; else the mass under one of the surface's cells."""
    panel, lightest_kg = case.screen.panels[name], solvers.panel(case).lightest_kg
    if lightest_kg is None:
        cell_m2 = panel.width_m * panel.length_m / math.prod(case.panel.surface_cells)
        return areal_kg_per_m2(case, panel) * cell_m2
    plans = zip(single_panels(case), panel_plans(case), strict=True)
    return min(lightest_kg(p, case.panel.surface_cells) for one, p in plans if one.table_name == name)
