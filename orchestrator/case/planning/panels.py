"""What the panels' solver needs of a case."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from orchestrator.case.deck.panels import single_panels
from orchestrator.case.deck.stops import planned_stops
from orchestrator.case.planning.materials import hyperelastic
from orchestrator.case.tables.case import Case
from orchestrator.ports.plans import PanelPlan
from orchestrator.ports.recording import Playback


def panel_plans(case: Case, playbacks: Mapping[str, Playback] | None = None) -> tuple[PanelPlan, ...]:
    """One plan per panel, in the order of the case, with the ``playbacks`` by the panels' names."""
    return tuple(
        PanelPlan(
            name=panel.name,
            rectangle=panel.rectangle,
            frames=panel.frames,
            thickness_m=panel.table.thickness_m,
            material=hyperelastic(case.materials[panel.table.material]),
            gravity_m_per_s2=np.array(case.gravity_m_per_s2),
            cells=case.panel.cells,
            step_s=case.panel.step_s,
            integrator=case.panel.integrator,
            sync_interval_s=case.coupling.sync_interval_s,
            apertures=panel.apertures,
            playback=(playbacks or {}).get(panel.name),
            stops=planned_stops(case, panel),
        )
        for panel in single_panels(case)
    )
