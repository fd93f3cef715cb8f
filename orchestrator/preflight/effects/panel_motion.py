"""The surface moves under the particles: what throws them, over their weight."""

from __future__ import annotations

from orchestrator.case.tables.case import Case, has_particles
from orchestrator.preflight.scene.effect import TENTH, Effect, Verdict
from orchestrator.preflight.scene.scene import Scene


def judge(scene: Scene) -> Verdict:
    shaken = scene.speed_rad_per_s > 0
    matters = True if scene.throw > TENTH else None
    thrown = f"particles are thrown with {scene.throw:.2g} g"
    if matters is None:
        thrown += "; how far a slow surface carries them, only a run tells"
    return Verdict(
        number="throw",
        value=scene.throw if shaken else None,
        threshold="0.1 (of the weight)",
        matters=matters if shaken else None,
        limit=TENTH,
        why=thrown if shaken else "nothing shakes the surface: what bends it, only a run tells",
        cost="the particles' surface is placed at every step",
    )


def left_out(case: Case) -> str:
    off = "exchange.panel_motion is off: particles see the surface as it was at t = 0"
    return "" if case.exchange.panel_motion else off


EFFECT = Effect(
    part="particles",
    judge=judge,
    described=has_particles,
    left_out=left_out,
    overlay=lambda case: {"exchange": {"panel_motion": False}},
    key="exchange.panel_motion",
    checked_by="frames_throw",
    about=("particles",),
)
