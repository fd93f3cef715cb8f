"""Rotation of frames, which matters by the motion of a frame's outermost clamp over its translation."""

from __future__ import annotations

from orchestrator.case import solvers
from orchestrator.case.tables.case import Case
from orchestrator.preflight.scene.clamp_motion import (
    compare_outermost,
    has_moved_by_forces,
    motion_by_rotation,
)
from orchestrator.preflight.scene.effect import Effect, Overlay, Verdict
from orchestrator.preflight.scene.scene import Scene


def judge(scene: Scene) -> Verdict | None:
    """Return the verdict on the motion by rotation; None without free frames, or if nothing shakes."""
    number, cost = "rotation x lever / translation", "0.2 ms per sync interval, 0.1 ms without"
    return compare_outermost(scene, scene.observed.rotation, motion_by_rotation, number, cost)


def overlay(case: Case) -> Overlay:
    """Return the key of a solver whose frames only translate; empty with drives, which it does not know."""
    frames = case.screen.frames.values()
    driven = any(frame.drive or frame.mass_kg is None for frame in frames)
    return {} if driven else {"frames": {"solver": solvers.name_without("frames", "frame-rotation")}}


EFFECT = Effect(
    part="frames",
    judge=judge,
    described=has_moved_by_forces,
    overlay=overlay,
    needs=("frame-dynamics",),
    key="frames.solver",
    checked_by="rotation",
    saves=True,
    about=("particles", "panels"),
)
