"""Frames rotate: displacement of the outermost clamp by rotation over the frame's translation."""

from __future__ import annotations

from orchestrator.case import solvers
from orchestrator.case.tables.case import Case
from orchestrator.preflight.scene.clamp_motion import at_outermost_clamps, motion_by_rotation, moved_by_forces
from orchestrator.preflight.scene.effect import TENTH, Effect, Overlay, Verdict
from orchestrator.preflight.scene.scene import Scene
from orchestrator.preflight.scene.shaking import free_frames


def judge(scene: Scene) -> Verdict | None:
    """None without free frames."""
    if not free_frames(scene.plan) or scene.speed_rad_per_s == 0:
        return None
    ratio, why = scene.observed.rotation or at_outermost_clamps(scene, motion_by_rotation)
    return Verdict(
        number="rotation x lever / translation",
        value=ratio,
        threshold="0.1",
        matters=ratio > TENTH if ratio is not None else None,
        limit=TENTH,
        why=why,
        cost="0.2 ms per sync interval, 0.1 ms without",
    )


def overlay(case: Case) -> Overlay:
    """Frames that only translate have no drives."""
    frames = case.screen.frames.values()
    driven = any(frame.drive or frame.mass_kg is None for frame in frames)
    return {} if driven else {"frames": {"solver": solvers.without("frames", "frame-rotation")}}


EFFECT = Effect(
    part="frames",
    judge=judge,
    described=lambda case: bool(moved_by_forces(case)),
    overlay=overlay,
    needs=("frame-dynamics",),
    key="frames.solver",
    checked_by="rotation",
    saves=True,
    about=("particles", "panels"),
)
