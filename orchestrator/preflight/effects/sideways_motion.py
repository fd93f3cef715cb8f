"""Frames leave the vertical plane: motion across, roll and yaw at the outermost clamp over the
frame's translation."""

from __future__ import annotations

from orchestrator.case import solvers
from orchestrator.case.tables.case import Case
from orchestrator.preflight.scene.clamp_motion import (
    at_outermost_clamps,
    motion_out_of_plane,
    moved_by_forces,
)
from orchestrator.preflight.scene.effect import TENTH, Effect, Overlay, Verdict
from orchestrator.preflight.scene.scene import Scene
from orchestrator.preflight.scene.shaking import free_frames


def judge(scene: Scene) -> Verdict | None:
    """None without free frames."""
    if not free_frames(scene.plan) or scene.speed_rad_per_s == 0:
        return None
    ratio, why = scene.observed.sideways or at_outermost_clamps(scene, motion_out_of_plane)
    return Verdict(
        number="motion across, by roll and by yaw / translation",
        value=ratio,
        threshold="0.1",
        matters=ratio > TENTH if ratio is not None else None,
        limit=TENTH,
        why=f"{why}; of panels and bushings, not of an uneven bed",
        cost="0.35 ms per sync interval, 0.2 ms without",
    )


def overlay(case: Case) -> Overlay:
    """Frames that stay in the plane have no drives that leave it."""
    drives = [frame.drive for frame in case.screen.frames.values() if frame.drive]
    leaves = any(d.amplitude_m[1] or d.rotation_rad[0] or d.rotation_rad[2] for d in drives)
    return {} if leaves else {"frames": {"solver": solvers.without("frames", "sideways-motion")}}


EFFECT = Effect(
    part="frames",
    judge=judge,
    described=lambda case: bool(moved_by_forces(case)),
    overlay=overlay,
    needs=("frame-rotation",),
    key="frames.solver",
    checked_by="sideways",
    saves=True,
    about=("particles", "panels"),
)
