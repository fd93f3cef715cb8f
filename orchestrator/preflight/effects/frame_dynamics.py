"""Motion of frames by forces.

Forces move free frames, and drives prescribe the motion of the others, so nothing is estimated.
"""

from __future__ import annotations

from orchestrator.case import solvers
from orchestrator.preflight.scene.clamp_motion import has_moved_by_forces
from orchestrator.preflight.scene.effect import Effect, Verdict
from orchestrator.preflight.scene.scene import Scene
from orchestrator.preflight.scene.shaking import free_frames


def judge(scene: Scene) -> Verdict:
    """Judge the number of frames that forces move."""
    free = free_frames(scene.plan)
    why = f"moved by forces: {', '.join(free)}" if free else "all frames move as prescribed"
    if not scene.plan.bodies:
        why = "there are no frames but the ground"
    return Verdict(
        number="frames that forces move",
        value=float(len(free)),
        threshold="1 (what the case describes)",
        matters=bool(free),
        why=why,
        cost="hardly anything",
    )


EFFECT = Effect(
    part="frames",
    judge=judge,
    described=has_moved_by_forces,
    overlay=lambda case: {"frames": {"solver": solvers.name_without("frames", "frame-dynamics")}},
    key="frames.solver",
)
