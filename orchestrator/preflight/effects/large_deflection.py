"""Stretching of panels by large deflections, which matters if they sag by a share of their thickness."""

from __future__ import annotations

from orchestrator.preflight.scene.effect import Effect, Verdict, compare
from orchestrator.preflight.scene.scene import NOTHING_MOVES, Scene, elastic_solvers


def judge(scene: Scene) -> Verdict:
    """Judge the sag of the slackest panel over its thickness; unknown where nothing moves."""
    ratio = max(panel.sag_m / panel.panel.table.thickness_m for panel in scene.panels)
    sag_m = max(panel.sag_m for panel in scene.panels)
    moves = scene.speed_rad_per_s > 0 or ratio > 0
    return compare(
        "sag / thickness",
        ratio if moves else None,
        f"the slackest panel sags by {sag_m * 1e3:.3g} mm" if moves else NOTHING_MOVES,
        threshold="0.2 (Ventsel, Krauthammer 2001)",
        limit=0.2,
        cost=elastic_solvers(),
    )


EFFECT = Effect(part="panels", judge=judge, needs=("panel-deformation",), checked_by="frames_throw")
