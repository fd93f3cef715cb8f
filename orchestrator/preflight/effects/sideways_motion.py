"""Motion of frames out of the vertical plane, across, in roll and in yaw.

It matters by the motion of a frame's outermost clamp over the frame's translation.
"""

from __future__ import annotations

from dataclasses import replace

from orchestrator.case import solvers
from orchestrator.case.tables.case import Case
from orchestrator.preflight.scene.clamp_motion import (
    compare_outermost,
    has_moved_by_forces,
    motion_out_of_plane,
)
from orchestrator.preflight.scene.effect import Effect, Overlay, Verdict
from orchestrator.preflight.scene.scene import Scene


def judge(scene: Scene) -> Verdict | None:
    """Return the verdict on the motion out of the plane; None without free frames, or if nothing shakes."""
    number = "motion across, by roll and by yaw / translation"
    cost = "0.35 ms per sync interval, 0.2 ms without"
    verdict = compare_outermost(scene, scene.observed.sideways, motion_out_of_plane, number, cost)
    if verdict is None:
        return None
    return replace(verdict, why=f"{verdict.why}; of panels and bushings, not of an uneven bed")


def overlay(case: Case) -> Overlay:
    """Return the key of a solver whose frames stay in the plane; empty if a drive leaves the plane."""
    drives = [frame.drive for frame in case.screen.frames.values() if frame.drive]
    leaves = any(d.amplitude_m[1] or d.rotation_rad[0] or d.rotation_rad[2] for d in drives)
    return {} if leaves else {"frames": {"solver": solvers.name_without("frames", "sideways-motion")}}


EFFECT = Effect(
    part="frames",
    judge=judge,
    described=has_moved_by_forces,
    overlay=overlay,
    needs=("frame-rotation",),
    key="frames.solver",
    checked_by="sideways",
    saves=True,
    about=("particles", "panels"),
)
