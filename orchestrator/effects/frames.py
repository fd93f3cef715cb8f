"""Effects in the frames and between frames and panels."""

from __future__ import annotations

import math

import numpy as np

from orchestrator.effects.scene import Scene, stroke_m
from orchestrator.effects.shaking import (
    Shaking,
    bushing_N_m,
    free_frames,
    shakings,
)
from orchestrator.effects.verdict import TENTH, Verdict
from orchestrator.ports import Array

RUBBER = 0.1  # loss factor taken where no damping is given (docs/theory/machine.md)
CYCLES = 5.0


def frame_dynamics(scene: Scene) -> Verdict:
    """Free frames move as forces make them, driven ones as told: there is nothing to estimate."""
    free = free_frames(scene.plan)
    why = f"moved by forces: {', '.join(free)}" if free else "all frames move as prescribed"
    return Verdict(
        effect="frame-dynamics",
        present=bool(free) and "frame-dynamics" not in scene.left_out,
        number="frames that forces move",
        value=float(len(free)),
        threshold="1 (what the case describes)",
        matters=bool(free),
        why=why,
        key="frames.solver",
        cost="hardly anything",
    )


def panel_reaction(scene: Scene) -> Verdict:
    """Panels' stiffness along the deck over that of the bushings between the same frames."""
    free = bool(free_frames(scene.plan))
    ratio = _panels_share(scene)
    change, why = _without(scene, shakings(scene.plan), "without the panels")
    if not free:
        why = "all frames move as prescribed: panels cannot change that"
    if not scene.panels:
        why = "there are no panels"
    off = {"panel-reaction", "frame-dynamics"} & set(scene.left_out)
    return Verdict(
        effect="panel-reaction",
        present=free and bool(scene.panels) and not off,
        number="panels / bushings, stiffness along the deck",
        value=ratio if free else None,
        threshold="0.1, or the stroke by a tenth",
        matters=free and (ratio > TENTH or abs(change) > TENTH),
        why=why,
        key="hand_over.panel_reaction",
        cost="hardly anything",
    )


def bushing_damping(scene: Scene) -> Verdict | None:
    """Change of the stroke without damping; None without bushings on free frames."""
    if not scene.plan.bushings or not free_frames(scene.plan):
        return None
    given = any(bushing.damping_N_s_m.any() for bushing in scene.plan.bushings)
    what = "without damping" if given else f"with a loss factor of {RUBBER:g}, as rubber has"
    other = shakings(scene.plan, scene.springs, 0.0 if given else RUBBER)
    change, why = _without(scene, other, what)
    matters = True if abs(change) > TENTH else None
    swings = "" if matters else "; yet the start's swinging would never die out"
    return Verdict(
        effect="bushing-damping",
        present=given,
        number="change of the stroke",
        value=abs(change) if scene.speed_rad_s else None,
        threshold="0.1",
        matters=matters,
        why=why + swings,
        key="screen.bushings.<name>.damping_N_s_m",
        cost="nothing",
    )


def frame_rotation(scene: Scene) -> Verdict | None:
    """Displacement of the outermost clamp by rotation over the frame's translation; None without
    free frames."""
    free = free_frames(scene.plan)
    if not free or scene.speed_rad_s == 0:
        return None
    inertia = {body.name: body.inertia_kg_m2 for body in scene.plan.bodies}
    known = all(np.linalg.det(inertia[name]) > 0 for name in free)
    turning = shakings(scene.plan, scene.springs, None, 6) if known else ()
    ratio, name = max((_rotation(scene, one, turning), one) for one in free)
    return Verdict(
        effect="frame-rotation",
        present="frame-rotation" not in scene.left_out and "frame-dynamics" not in scene.left_out,
        number="rotation x lever / translation",
        value=ratio if known else None,
        threshold="0.1",
        matters=ratio > TENTH if known else None,
        why=f"at the outermost clamp of {name}" if known else "no inertia_kg_m2 is given",
        key="frames.solver",
        cost="exudyn 0.4 ms per sync interval, two-mass, which cannot, 0.1 ms",
    )


def run_up(scene: Scene) -> Verdict | None:
    """A run-up of N cycles adds up to 1/(2 N) of the acceleration; None where nothing shakes."""
    rows = [(one.run_up_s, one.speed_rad_s) for one in scene.plan.drives]
    rows += [(one.run_up_s, one.speed_rad_s) for one in scene.plan.exciters]
    if not rows:
        return None
    cycles = min(run_up_s * speed / (2 * math.pi) for run_up_s, speed in rows)
    matters, why = _start(cycles)
    return Verdict(
        effect="run-up",
        present=cycles > 0,
        number="cycles of the run-up",
        value=cycles,
        threshold=f"{CYCLES:g} (a tenth more acceleration)",
        matters=matters,
        why=why,
        key="run_up_s of exciters and drives",
        cost="that much machine time",
    )


def _start(cycles: float) -> tuple[bool | None, str]:
    if cycles == 0:
        return True, "the machine starts with a jump"
    over = f"at the start accelerations are up to {1 / (2 * cycles):.0%} higher"
    if cycles >= CYCLES:
        return True, f"{over}: smooth"
    return None, f"{over}: matters if the start is looked at"


def _panels_share(scene: Scene) -> float:
    """Largest over the pairs of frames that panels join; infinite where nothing else does."""
    found = [0.0]
    pairs = {frozenset(spring.frames) for spring in scene.springs}
    for pair in (one for one in pairs if len(one) == 2):
        springs = [one for one in scene.springs if frozenset(one.frames) == pair]
        along = springs[0].along
        joints = [one for one in scene.plan.bushings if frozenset(one.bodies) == pair]
        bushings_N_m = sum(along @ bushing_N_m(one, 0.0, None).real @ along for one in joints)
        panels_N_m = sum(spring.stiffness_N_m for spring in springs)
        found.append(float(panels_N_m / bushings_N_m) if bushings_N_m else math.inf)
    return max(found)


def _without(scene: Scene, other: tuple[Shaking, ...], what: str) -> tuple[float, str]:
    """Relative change of the largest stroke in another motion, and words about it."""
    now_m, then_m = largest_stroke_m(scene, scene.shaken), largest_stroke_m(scene, other)
    if now_m == 0.0:
        return 0.0, "nothing shakes the frames"
    words = f"{what} the stroke would be {then_m * 1e3:.3g} instead of {now_m * 1e3:.3g} mm"
    return then_m / now_m - 1, words


def largest_stroke_m(scene: Scene, shaken: tuple[Shaking, ...]) -> float:
    """Of all panels; without panels, of the frame that moves most."""
    if scene.springs:
        return max(stroke_m(shaken, spring) for spring in scene.springs)
    names = [body.name for body in scene.plan.bodies]
    found = [sum(np.linalg.norm(one.amplitude_m[name]) for one in shaken) for name in names]
    return float(max(found, default=0.0))


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
