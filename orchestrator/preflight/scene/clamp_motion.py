"""The motion of the panels' clamps by the frames' steady motion: strokes, and the arms of rotations."""

from __future__ import annotations

import numpy as np

from orchestrator.case.tables.case import Case
from orchestrator.ports import Array
from orchestrator.preflight.scene.effect import Verdict, compare
from orchestrator.preflight.scene.scene import Scene, stroke_m
from orchestrator.preflight.scene.shaking import Shaking


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
