"""Frames move the panels' clamps: what that throws, over its weight."""

from __future__ import annotations

from orchestrator.case.tables.case import Case
from orchestrator.preflight.scene.effect import TENTH, Effect, Verdict
from orchestrator.preflight.scene.scene import Scene


def judge(scene: Scene) -> Verdict | None:
    """None without frames or panels."""
    if not scene.panels or not scene.plan.bodies:
        return None
    shaken = scene.speed_rad_per_s > 0
    matters = True if scene.throw > TENTH else None
    thrown = f"panels' middles are thrown with {scene.panels_throw:.2g} g"
    if matters is None:
        thrown += "; what slow clamps do to the panels' pull, only a run tells"
    return Verdict(
        number="throw",
        value=scene.throw if shaken else None,
        threshold="0.1 (of the weight)",
        matters=matters if shaken else None,
        why=thrown if shaken else "nothing shakes the frames: how they yield, only a run tells",
        cost="nothing",
    )


def left_out(case: Case) -> str:
    off = "exchange.frame_motion is off: clamps stay where they are"
    return "" if case.exchange.frame_motion else off


EFFECT = Effect(
    part="frames",
    judge=judge,
    described=lambda case: bool(case.screen.panels) and bool(case.screen.frames),
    left_out=left_out,
    overlay=lambda case: {"exchange": {"frame_motion": False}},
    key="exchange.frame_motion",
    checked_by="frames_throw",
)
