"""Bounds from particles on a surface that moves between sync points, on accuracy alone.

Where a drive has the surface, its path is known but for what a smooth curve between sync points
leaves out of it; where it is free, particles see it where it would be without speeding up.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from orchestrator.case import solvers
from orchestrator.case.tables.quantities import GROUND
from orchestrator.preflight.scene.scene import Scene
from orchestrator.preflight.stability.bound import Bound
from orchestrator.preflight.stability.touching import touches

INTERVALS_PER_CONTACT = 10
IMPACT = "docs/theory/stability.md, impacts"
MOVING = "docs/theory/stability.md, moving surfaces"
SHARE_OF_OVERLAP = 0.1
"""How far a surface may be off, of the overlap of what lies on it.  The mean over the interval is
off by a third of that."""
STRAIGHT, CHORD = 1 / 2, 1 / 8
"""By how many a H^2 a surface that speeds up by a is off at most in an interval H: of a straight
path that leaves with its velocity, at the end; of the chord, in the middle."""
HERMITE = 1 / 384
"""By how many H^4 times its fourth derivative a cubic Hermite path is off at most."""


@dataclass(frozen=True)
class Met:
    """A surface that particles meet, a panel or a wall.  ``known``: a drive has it, or it stands
    still; ``yields``: its points give way to loads by themselves, as only elastic panels' do;
    ``acceleration_m_per_s2`` is the largest that the scene gives it."""

    name: str
    material: str
    known: bool
    yields: bool
    acceleration_m_per_s2: float


def met(scene: Scene) -> list[Met]:
    """Every panel and every wall.  Rigid panels and walls move as frames do; other panels, as their
    middles or as the frames, whichever is more."""
    case, moves = scene.case, scene.case.exchange.frame_motion
    yields = solvers.panel(case).yields
    panels_throw = scene.throw if solvers.panel(case).deforms else scene.frames_throw
    found = []
    for name, panel in case.screen.panels.items():
        known = not yields and (not moves or _known(scene, *panel.frames))
        acceleration_m_per_s2 = panels_throw * scene.gravity_m_per_s2 if moves else 0.0
        found.append(Met(name, panel.material, known, yields, acceleration_m_per_s2))
    for name, wall in case.screen.surfaces.items():
        known = not moves or _known(scene, wall.frame)
        throw = scene.frames_throw if moves and wall.frame != GROUND else 0.0
        found.append(Met(name, wall.material, known, False, throw * scene.gravity_m_per_s2))
    return found


def _known(scene: Scene, *frames: str) -> bool:
    forces = solvers.frames(scene.case).moved_by_forces
    unmoved = not (forces and scene.case.exchange.panel_reaction)
    known = {drive.body for drive in scene.plan.drives} | {GROUND}
    return unmoved or known.issuperset(frames)


def surface_bounds(scene: Scene) -> Iterator[Bound]:
    """Of all particles on all that they meet."""
    surfaces = met(scene)
    yield from shortest_impact(scene, [one for one in surfaces if not one.known])
    if scene.case.exchange.panel_motion:
        yield from _worst("moving surface", scene, surfaces, _extrapolated_s)
        yield from _worst("driven surface", scene, surfaces, _smoothed_s)


def _extrapolated_s(scene: Scene, surface: Met, off_m: float) -> float:
    """The interval in which a surface that is free is off by ``off_m``."""
    share = _share(scene.case.coupling.scheme, surface.yields)
    if surface.known or surface.acceleration_m_per_s2 == 0.0 or share == 0.0:
        return math.inf
    return math.sqrt(off_m / (share * surface.acceleration_m_per_s2))


def _share(scheme: str, yields: bool) -> float:
    """Of a H^2.  robin drifts on what it does not foresee; serial-staggered shows the particles the
    way that the surface has gone."""
    if scheme == "serial-staggered":
        return 0.0
    return STRAIGHT if scheme == "particles-first" or (scheme == "robin" and not yields) else CHORD


def _smoothed_s(scene: Scene, surface: Met, off_m: float) -> float:
    """The interval in which the smooth path of a driven surface, H^4 a w^2, is off by ``off_m``."""
    if not surface.known or surface.acceleration_m_per_s2 == 0.0:
        return math.inf
    fourth_m_per_s4 = surface.acceleration_m_per_s2 * scene.speed_rad_per_s**2
    return math.pow(off_m / (HERMITE * fourth_m_per_s4), 1 / 4)


def _worst(
    name: str, scene: Scene, surfaces: list[Met], allowed_s: Callable[[Scene, Met, float], float]
) -> Iterator[Bound]:
    """The shortest of all particles and surfaces; none where nothing limits."""
    found = [
        (allowed_s(scene, one, SHARE_OF_OVERLAP * touch.resting_m), one, touch)
        for one in surfaces
        for touch in touches(scene, one.material)
    ]
    interval_s, one, touch = min(found, key=lambda row: row[0], default=(math.inf, None, None))
    if one is not None and touch is not None and math.isfinite(interval_s):
        yield Bound(
            name,
            interval_s,
            MOVING,
            f"{touch} lies {touch.resting_m:.2g} m deep in {one.name}, which speeds up by up to "
            f"{one.acceleration_m_per_s2:.3g} m/s2; off by {SHARE_OF_OVERLAP:g} of that depth",
            "accuracy",
            f"{touch} on {one.name}",
        )


def shortest_impact(scene: Scene, surfaces: list[Met]) -> Iterator[Bound]:
    """At least ten intervals to the shortest impact on a surface that a load moves."""
    materials = {one.material for one in surfaces}
    every = [touch for name in sorted(materials) for touch in touches(scene, name)]
    shortest = min(every, key=lambda touch: touch.impact_s, default=None)
    if shortest is not None and math.isfinite(shortest.impact_s):
        yield Bound(
            "shortest impact",
            shortest.impact_s / INTERVALS_PER_CONTACT,
            IMPACT,
            f"{shortest} at {scene.impact_m_per_s:.3g} m/s for {shortest.impact_s:.3g} s, "
            f"{INTERVALS_PER_CONTACT} intervals",
            "accuracy",
            str(shortest),
        )
