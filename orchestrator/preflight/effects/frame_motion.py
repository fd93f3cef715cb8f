"""Motion of the panels' clamps with the frames, which matters by the throw intensity."""

from __future__ import annotations

from dataclasses import replace

from orchestrator.preflight.scene.clamp_motion import compare_throw
from orchestrator.preflight.scene.effect import Verdict, exchange_effect
from orchestrator.preflight.scene.scene import Scene


def judge(scene: Scene) -> Verdict | None:
    """Return the verdict on the throw; None without frames or panels."""
    if not scene.panels or not scene.plan.bodies:
        return None
    verdict = compare_throw(
        scene,
        thrown=f"panels' middles are thrown with {scene.panels_throw:.2g} g",
        slow="what slow clamps do to the panels' pull, only a run tells",
        still="nothing shakes the frames: how they yield, only a run tells",
        cost="nothing",
    )
    return replace(verdict, limit=None)


EFFECT = exchange_effect(
    "frames",
    judge,
    "frame_motion",
    off="clamps stay where they are",
    described=lambda case: bool(case.screen.panels) and bool(case.screen.frames),
    checked_by="frames_throw",
)
