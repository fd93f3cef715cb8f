"""Damping in the bushings, which matters if the stroke changes without it."""

from __future__ import annotations

from orchestrator.case.tables.case import Case
from orchestrator.preflight.scene.clamp_motion import change_of_stroke, has_moved_by_forces
from orchestrator.preflight.scene.effect import TENTH, Effect, Overlay, Verdict, overlay_of_rows
from orchestrator.preflight.scene.scene import Scene
from orchestrator.preflight.scene.shaking import free_frames, solve_shakings

RUBBER = 0.1  # loss factor of rubber, assumed if no damping is given (docs/theory/machine.md)


def judge(scene: Scene) -> Verdict | None:
    """Return the verdict on the change of the stroke; None without bushings or free frames."""
    if not scene.plan.bushings or not free_frames(scene.plan):
        return None
    given = any(bushing.damping_N_s_per_m.any() for bushing in scene.plan.bushings)
    what = "without damping" if given else f"with a loss factor of {RUBBER:g}, as rubber has"
    other = solve_shakings(scene.plan, scene.springs, 0.0 if given else RUBBER)
    change, why = change_of_stroke(scene, other, what)
    value = abs(change) if scene.speed_rad_per_s else None
    verdict = Verdict("change of the stroke", value, "0.1", True, why, "nothing")
    if abs(change) > TENTH:
        return verdict
    return verdict.doubted("yet the start's swinging would never die out")


def overlay(case: Case) -> Overlay:
    """Return the overlay that takes the damping out of all bushings."""
    return overlay_of_rows("screen.bushings", case.screen.bushings, {"damping_N_s_per_m": [0.0, 0.0, 0.0]})


def describes_damping(case: Case) -> bool:
    """Return whether a bushing has damping and forces move a frame."""
    damped = any(any(row.damping_N_s_per_m) for row in case.screen.bushings.values())
    return damped and has_moved_by_forces(case)


EFFECT = Effect(
    part="frames",
    judge=judge,
    described=describes_damping,
    overlay=overlay,
    needs=("frame-dynamics",),
    key="screen.bushings.<name>.damping_N_s_per_m",
    checked_by="panels_N_per_m",
)
