"""Rotation of frames, which matters by the motion of a frame's outermost clamp over its translation."""

from __future__ import annotations

import numpy as np

from orchestrator.case import solvers
from orchestrator.case.tables.case import Case
from orchestrator.preflight.scene.clamp_motion import clamp_arms_m, has_moved_by_forces
from orchestrator.preflight.scene.effect import Effect, Overlay, Verdict, compare
from orchestrator.preflight.scene.scene import Scene
from orchestrator.preflight.scene.shaking import Shaking, free_frames, solve_shakings


def judge(scene: Scene) -> Verdict | None:
    """Return the verdict on the rotation; None without free frames, or if nothing shakes them.

    Its number is the one that a run has shown, or else the estimated one.
    """
    number, cost = "rotation x lever / translation", "0.2 ms per sync interval, 0.1 ms without"
    free, found = free_frames(scene.plan), scene.observed.rotation
    if not free or scene.speed_rad_per_s == 0:
        return None
    if found is None:
        inertia = {body.name: body.inertia_kg_m2 for body in scene.plan.bodies}
        if not all(np.linalg.det(inertia[name]) > 0 for name in free):
            return compare(number, None, "no inertia_kg_m2 is given", cost=cost)
        turning = solve_shakings(scene.plan, scene.springs, None, 6)
        ratio, name = max((_ratio(scene, name, turning), name) for name in free)
        found = ratio, f"at the outermost clamp of {name}"
    return compare(number, *found, cost=cost)


def _ratio(scene: Scene, name: str, turning: tuple[Shaking, ...]) -> float:
    """Return a frame's motion by rotation at its outermost clamp over that of its centre of mass."""
    arms_m, at_clamp_m, moved_m = clamp_arms_m(scene, name), 0.0, 0.0
    for shaking in turning:
        by_rotation_m = np.cross(shaking.angle_rad[name], arms_m)
        at_clamp_m += float(np.linalg.norm(by_rotation_m, axis=1).max())
        moved_m += float(np.linalg.norm(shaking.amplitude_m[name]))
    return at_clamp_m / moved_m if moved_m else 0.0


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
