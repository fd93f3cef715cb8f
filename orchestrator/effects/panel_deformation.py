"""Panels deform: what their middles move, against the frames."""

from __future__ import annotations

import math

from orchestrator.casefile.case import Case
from orchestrator.scene.effect import TENTH, Effect, Verdict
from orchestrator.scene.scene import NOTHING_MOVES, Scene


def judge(scene: Scene) -> Verdict:
    throw, rigid = scene.panels_throw, scene.frames_throw
    ratio = throw / rigid if rigid else math.inf
    shaken = scene.speed_rad_s > 0
    matters, why = _deform(scene, ratio) if shaken else (None, NOTHING_MOVES)
    return Verdict(
        number="throw of panel / of frame",
        value=ratio if shaken else None,
        threshold="0.1",
        matters=matters,
        why=why,
        cost="a strip little, a sheet a tenth to a half of the particles' time",
    )


def _deform(scene: Scene, ratio: float) -> tuple[bool | None, str]:
    """A bed of more than a tenth of the panels' own mass may bend what shaking does not."""
    throw, rigid = scene.panels_throw, scene.frames_throw
    why = f"panels' middles are thrown with {throw:.2g} g, frames with {rigid:.2g} g"
    if ratio > TENTH:
        return True, why
    if scene.bed_kg_m2 > TENTH * min(panel.mass_kg_m2 for panel in scene.panels):
        return None, f"{why}; what the bed does to them, only a run tells"
    return False, why


def left_out(case: Case) -> str:
    return "panel.solver rigid: panels stay flat" if case.panel.solver == "rigid" else ""


EFFECT = Effect(
    part="panels",
    judge=judge,
    described=lambda case: bool(case.screen.panels),
    left_out=left_out,
    overlay=lambda case: {"panel": {"solver": "rigid"}},
    key="panel.solver",
    checked_by="frames_throw",
)
