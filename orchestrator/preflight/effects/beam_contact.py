"""Contact of panels with beams below them, which they touch if they sag by more than the gap."""

from __future__ import annotations

import math

from orchestrator.preflight.scene.effect import Effect, Verdict, compare, overlay_of_panels
from orchestrator.preflight.scene.moved_panel import MovedPanel
from orchestrator.preflight.scene.scene import Scene


def judge(scene: Scene) -> Verdict:
    """Judge the sag of the panels over the gaps above beams; unknown where the case names no beams."""
    shares = [share for panel in scene.panels for share in _sag_over_gaps(panel)]
    share = max(shares, default=None)
    why = f"a panel sags to {share or 0.0:.3g} times the gap above a beam"
    if share is None:
        sag_m = max(panel.sag_m for panel in scene.panels)
        why = f"panels sag by up to {1e3 * sag_m:.3g} mm; the case names no beams below them"
    cost = "a few products per point above a beam and sync interval"
    return compare("sag / gap", share, why, "1 (it touches)", limit=1.0, cost=cost)


def _sag_over_gaps(panel: MovedPanel) -> list[float]:
    """Return the height of the panel's sine arch over each stop's middle, divided by the stop's gap."""
    table = panel.panel.table
    return [
        panel.sag_m * math.sin(math.pi * (stop.from_m + stop.to_m) / 2 / table.length_m) / stop.gap_m
        for stop in table.stops.values()
    ]


EFFECT = Effect(
    part="panels",
    judge=judge,
    described=lambda case: any(row.stops for row in case.screen.panels.values()),
    overlay=lambda case: overlay_of_panels(case, "stops"),
    needs=("panel-deformation",),
    key="stops of panels or decks",
    checked_by="frames_throw",
    about=("panels",),
)
