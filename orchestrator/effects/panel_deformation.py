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
    why = f"panels' middles are thrown with {throw:.2g} g, frames with {rigid:.2g} g"
    return Verdict(
        number="throw of panel / of frame",
        value=ratio if shaken else None,
        threshold="0.1",
        matters=ratio > TENTH if shaken else None,
        why=why if shaken else NOTHING_MOVES,
        cost="a strip little, a sheet up to the particles' time",
    )


def left_out(case: Case) -> str:
    return "panel.solver rigid: panels stay flat" if case.panel.solver == "rigid" else ""


EFFECT = Effect(
    part="panels",
    judge=judge,
    described=lambda case: bool(case.screen.panels),
    left_out=left_out,
    overlay=lambda case: {"panel": {"solver": "rigid"}},
    key="panel.solver",
)
