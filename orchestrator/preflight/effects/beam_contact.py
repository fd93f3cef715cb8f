"""Panels come to lie on beams below them: sag over the gap, where the beam is."""

from __future__ import annotations

import math
from typing import Any

from orchestrator.case.tables.case import Case
from orchestrator.preflight.scene.effect import Effect, Overlay, Verdict
from orchestrator.preflight.scene.moved_panel import MovedPanel
from orchestrator.preflight.scene.scene import Scene


def judge(scene: Scene) -> Verdict | None:
    """None without panels."""
    if not scene.panels:
        return None
    shares = [share for panel in scene.panels for share in _sag_over_gaps(panel)]
    sag_m = max(panel.sag_m for panel in scene.panels)
    unknown = f"panels sag by up to {1e3 * sag_m:.3g} mm; the case names no beams below them"
    known = f"a panel sags to {max(shares, default=0.0):.3g} times the gap above a beam"
    return Verdict(
        number="sag / gap",
        value=max(shares) if shares else None,
        threshold="1 (it touches)",
        matters=max(shares) > 1 if shares else None,
        limit=1.0,
        why=known if shares else unknown,
        cost="a few products per point above a beam and sync interval",
    )


def _sag_over_gaps(panel: MovedPanel) -> list[float]:
    """A sine arch over the middle of each stop."""
    table = panel.panel.table
    return [
        panel.sag_m * math.sin(math.pi * (stop.from_m + stop.to_m) / 2 / table.length_m) / stop.gap_m
        for stop in table.stops.values()
    ]


def overlay(case: Case) -> Overlay:
    found: dict[str, Any] = {}
    for kind, rows in (("panels", case.screen.panels), ("decks", case.screen.decks)):
        for name, row in rows.items():
            if row.stops:
                found.setdefault(kind, {})[name] = {"stops": None}
    return {"screen": found} if found else {}


EFFECT = Effect(
    part="panels",
    judge=judge,
    described=lambda case: any(row.stops for row in case.screen.panels.values()),
    overlay=overlay,
    needs=("panel-deformation",),
    key="stops of panels or decks",
    checked_by="frames_throw",
    about=("panels",),
)
