"""How far frames move each other's panels, and what other machines would do."""

from __future__ import annotations

import numpy as np

from orchestrator.case.tables.case import Case
from orchestrator.preflight.scene.scene import Scene, stroke_m
from orchestrator.preflight.scene.shaking import Shaking


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
