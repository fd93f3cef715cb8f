"""Frames rotate: displacement of the outermost clamp by rotation over the frame's translation."""

from __future__ import annotations

import numpy as np

from orchestrator.casefile.case import Case
from orchestrator.ports import Array
from orchestrator.scene.effect import TENTH, Effect, Overlay, Verdict
from orchestrator.scene.scene import Scene
from orchestrator.scene.shaking import Shaking, free_frames, shakings
from orchestrator.scene.strokes import moved_by_forces


def judge(scene: Scene) -> Verdict | None:
    """None without free frames."""
    free = free_frames(scene.plan)
    if not free or scene.speed_rad_s == 0:
        return None
    inertia = {body.name: body.inertia_kg_m2 for body in scene.plan.bodies}
    known = all(np.linalg.det(inertia[name]) > 0 for name in free)
    turning = shakings(scene.plan, scene.springs, None, 6) if known else ()
    ratio, name = max((_rotation(scene, one, turning), one) for one in free)
    return Verdict(
        number="rotation x lever / translation",
        value=ratio if known else None,
        threshold="0.1",
        matters=ratio > TENTH if known else None,
        why=f"at the outermost clamp of {name}" if known else "no inertia_kg_m2 is given",
        cost="exudyn 0.4 ms per sync interval, two-mass, which cannot, 0.1 ms",
    )


def _rotation(scene: Scene, name: str, turning: tuple[Shaking, ...]) -> float:
    """Of a frame's outermost clamp, by rotation, over the translation of the centre of mass."""
    body = next(one for one in scene.plan.bodies if one.name == name)
    arms_m = _clamps_m(scene, name) - body.center_of_mass_m
    turned = moved = 0.0
    for one in turning:
        turned += float(np.linalg.norm(np.cross(one.angle_rad[name], arms_m), axis=1).max())
        moved += float(np.linalg.norm(one.amplitude_m[name]))
    return turned / moved if moved else 0.0


def _clamps_m(scene: Scene, name: str) -> Array:
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


def left_out(case: Case) -> str:
    translating = "frames.solver two-mass: frames translate only"
    return translating if case.frames.solver == "two-mass" else ""


def overlay(case: Case) -> Overlay:
    """Frames that only translate have no drives."""
    frames = case.screen.frames.values()
    driven = any(frame.drive or frame.mass_kg is None for frame in frames)
    return {} if driven else {"frames": {"solver": "two-mass"}}


EFFECT = Effect(
    part="frames",
    judge=judge,
    described=lambda case: bool(moved_by_forces(case)),
    left_out=left_out,
    overlay=overlay,
    needs=("frame-dynamics",),
    key="frames.solver",
)
