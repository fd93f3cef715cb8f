"""How the frames' steady motion moves the panels' clamps: strokes, and the share of rotations."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from orchestrator.case.tables.case import Case
from orchestrator.ports import Array
from orchestrator.preflight.scene.scene import Scene, stroke_m
from orchestrator.preflight.scene.shaking import Shaking, free_frames, solve_shakings


def moved_by_forces(case: Case) -> list[str]:
    """Frames with a mass that no drive moves."""
    frames = case.screen.frames.items()
    return [name for name, frame in frames if frame.drive is None and frame.mass_kg]


def largest_stroke_m(scene: Scene, shaken: tuple[Shaking, ...]) -> float:
    """Of all panels; without panels, of the frame that moves most."""
    if scene.springs:
        return max(stroke_m(shaken, spring) for spring in scene.springs)
    names = [body.name for body in scene.plan.bodies]
    found = [sum(np.linalg.norm(one.amplitude_m[name]) for one in shaken) for name in names]
    return float(max(found, default=0.0))


def change_of_stroke(scene: Scene, other: tuple[Shaking, ...], what: str) -> tuple[float, str]:
    """Relative change of the largest stroke in another motion, and words about it."""
    now_m, then_m = largest_stroke_m(scene, scene.shaken), largest_stroke_m(scene, other)
    if now_m == 0.0:
        return 0.0, "nothing shakes the frames"
    words = f"{what} the stroke would be {then_m * 1e3:.3g} instead of {now_m * 1e3:.3g} mm"
    return then_m / now_m - 1, words


MotionPart = Callable[[Array, Array, Array], Array]
"""Part of the displacement (n, 3) at ``arms_m`` (n, 3) from a centre of mass that moves by
``amplitude_m`` and turns by ``angle_rad``, (3,) and complex each."""


def motion_by_rotation(amplitude_m: Array, angle_rad: Array, arms_m: Array) -> Array:
    """By rotation alone."""
    return np.cross(angle_rad, arms_m)


def motion_out_of_plane(amplitude_m: Array, angle_rad: Array, arms_m: Array) -> Array:
    """Across, by roll and by yaw."""
    return np.asarray(amplitude_m * [0, 1, 0] + np.cross(angle_rad * [1, 0, 1], arms_m))


def at_outermost_clamps(scene: Scene, part: MotionPart) -> tuple[float | None, str]:
    """The part at a frame's outermost clamp over the translation of the frame's centre of mass:
    the largest over the free frames, of which there must be one, and words about it; None if
    moments of inertia are missing."""
    free = free_frames(scene.plan)
    inertia = {body.name: body.inertia_kg_m2 for body in scene.plan.bodies}
    if not all(np.linalg.det(inertia[name]) > 0 for name in free):
        return None, "no inertia_kg_m2 is given"
    turning = solve_shakings(scene.plan, scene.springs, None, 6)
    ratio, name = max((_ratio(scene, one, turning, part), one) for one in free)
    return ratio, f"at the outermost clamp of {name}"


def _ratio(scene: Scene, name: str, turning: tuple[Shaking, ...], part: MotionPart) -> float:
    body = next(one for one in scene.plan.bodies if one.name == name)
    arms_m = clamps_m(scene, name) - body.center_of_mass_m
    at_clamp_m = moved_m = 0.0
    for one in turning:
        displacement_m = part(one.amplitude_m[name], one.angle_rad[name], arms_m)
        at_clamp_m += float(np.linalg.norm(displacement_m, axis=1).max())
        moved_m += float(np.linalg.norm(one.amplitude_m[name]))
    return at_clamp_m / moved_m if moved_m else 0.0


def clamps_m(scene: Scene, name: str) -> Array:
    """(n, 3) middles of the clamps that a frame holds; without any, its bushings."""
    places_m = [
        place_m
        for spring in scene.springs
        for end, place_m in zip(spring.frames, spring.ends_m, strict=True)
        if end == name
    ]
    places_m += [b.position_m for b in scene.plan.bushings if name in b.bodies and not places_m]
    body = next(one for one in scene.plan.bodies if one.name == name)
    return np.array(places_m or [body.center_of_mass_m])
