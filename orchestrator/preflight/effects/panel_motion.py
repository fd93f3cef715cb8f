"""Motion of the surface under the particles, which matters by the throw intensity."""

from __future__ import annotations

from orchestrator.preflight.scene.clamp_motion import compare_throw
from orchestrator.preflight.scene.effect import Verdict, exchange_effect
from orchestrator.preflight.scene.scene import Scene


def judge(scene: Scene) -> Verdict:
    """Judge the throw intensity of the surface under the particles."""
    return compare_throw(
        scene,
        thrown=f"particles are thrown with {scene.throw:.2g} g",
        slow="how far a slow surface carries them, only a run tells",
        still="nothing shakes the surface: what bends it, only a run tells",
        cost="the particles' surface is placed at every step",
    )


EFFECT = exchange_effect(
    "particles",
    judge,
    "panel_motion",
    off="particles see the surface as it was at t = 0",
    checked_by="frames_throw",
    about=("particles",),
)
