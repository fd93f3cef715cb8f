"""The motion of the panels' clamps by the frames' steady motion: strokes, and the share of rotations."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from orchestrator.case.tables.case import Case
from orchestrator.ports import Array
from orchestrator.preflight.scene.effect import Verdict, compare
from orchestrator.preflight.scene.scene import Scene, stroke_m
from orchestrator.preflight.scene.shaking import Shaking, free_frames, solve_shakings


def has_moved_by_forces(case: Case) -> bool:
    """Return whether a frame has a mass and no drive, so that forces move it."""
    return any(frame.drive is None and frame.mass_kg for frame in case.screen.frames.values())


def largest_stroke_m(scene: Scene, shaken: tuple[Shaking, ...]) -> float:
    """Return the largest stroke of all panels or, without panels, the largest amplitude of all frames."""
    if scene.springs:
        return max(stroke_m(shaken, spring) for spring in scene.springs)
    names = [body.name for body in scene.plan.bodies]
    strokes_m = [sum(np.linalg.norm(shaking.amplitude_m[name]) for shaking in shaken) for name in names]
    return float(max(strokes_m, default=0.0))


def change_of_stroke(scene: Scene, other: tuple[Shaking, ...], what: str) -> tuple[float, str]:
    """Return the relative change of the largest stroke in another motion, and a text about it."""
    now_m, then_m = largest_stroke_m(scene, scene.shaken), largest_stroke_m(scene, other)
    if now_m == 0.0:
        return 0.0, "nothing shakes the frames"
    words = f"{what} the stroke would be {then_m * 1e3:.3g} instead of {now_m * 1e3:.3g} mm"
    return then_m / now_m - 1, words


MotionPart = Callable[[Array, Array, Array], Array]
"""Function that returns a part of the displacement (n, 3) at ``arms_m`` (n, 3) from a centre of mass, which
moves by ``amplitude_m`` (3,) and turns by ``angle_rad`` (3,), both complex."""


def motion_by_rotation(amplitude_m: Array, angle_rad: Array, arms_m: Array) -> Array:
    """Return the part of the displacement by rotation."""
    return np.cross(angle_rad, arms_m)


def motion_out_of_plane(amplitude_m: Array, angle_rad: Array, arms_m: Array) -> Array:
    """Return the part of the displacement by motion across, by roll and by yaw."""
    return np.asarray(amplitude_m * [0, 1, 0] + np.cross(angle_rad * [1, 0, 1], arms_m))


def compare_outermost(
    scene: Scene, observed: tuple[float, str] | None, part: MotionPart, number: str, cost: str
) -> Verdict | None:
    """Return the verdict on a part of the motion at a frame's outermost clamp.

    The number is its ratio to the translation of the frame's centre of mass, as a run has shown it
    (``observed``) or as estimated.  Return None without free frames, or if nothing shakes them.
    """
    free = free_frames(scene.plan)
    if not free or scene.speed_rad_per_s == 0:
        return None
    if observed is None:
        inertia = {body.name: body.inertia_kg_m2 for body in scene.plan.bodies}
        if not all(np.linalg.det(inertia[name]) > 0 for name in free):
            return compare(number, None, "no inertia_kg_m2 is given", cost=cost)
        turning = solve_shakings(scene.plan, scene.springs, None, 6)
        ratio, name = max((_ratio(scene, name, turning, part), name) for name in free)
        observed = ratio, f"at the outermost clamp of {name}"
    return compare(number, *observed, cost=cost)


def compare_throw(scene: Scene, thrown: str, slow: str, still: str, cost: str) -> Verdict:
    """Return the verdict on the force that throws particles and panels, over their weight.

    ``thrown`` is the text about the throw, ``slow`` the doubt about a small one, and ``still`` the text
    of a scene in which nothing shakes.
    """
    number, threshold = "throw", "0.1 (of the weight)"
    if not scene.speed_rad_per_s > 0:
        return compare(number, None, still, threshold, cost=cost)
    verdict = compare(number, scene.throw, thrown, threshold, cost=cost)
    return verdict if verdict.matters else verdict.doubted(slow)


def _ratio(scene: Scene, name: str, turning: tuple[Shaking, ...], part: MotionPart) -> float:
    arms_m, at_clamp_m, moved_m = clamp_arms_m(scene, name), 0.0, 0.0
    for shaking in turning:
        displacement_m = part(shaking.amplitude_m[name], shaking.angle_rad[name], arms_m)
        at_clamp_m += float(np.linalg.norm(displacement_m, axis=1).max())
        moved_m += float(np.linalg.norm(shaking.amplitude_m[name]))
    return at_clamp_m / moved_m if moved_m else 0.0


def clamp_arms_m(scene: Scene, name: str) -> Array:
    """Return the arms (n, 3) from a frame's centre of mass to the middles of its clamps.

    Return the arms to its bushings if it has no clamps.
    """
    places_m = [
        place_m
        for spring in scene.springs
        for end, place_m in zip(spring.frames, spring.ends_m, strict=True)
        if end == name
    ]
    places_m += [b.position_m for b in scene.plan.bushings if name in b.bodies and not places_m]
    center_m = next(body.center_of_mass_m for body in scene.plan.bodies if body.name == name)
    return np.array(places_m or [center_m]) - center_m
