"""Bounds on the sync interval of a scene, on stability and on accuracy.

They come from particles on panels, from panels on frames that they push, and from particles on
surfaces that move between sync points: where a drive has the surface, its path is known but for
what a smooth curve between sync points leaves out of it; where it is free, particles see it where
it would be without speeding up.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Literal

from orchestrator.case.tables.case import Case
from orchestrator.case.tables.quantities import GROUND
from orchestrator.case.tables.screen import PanelTable
from orchestrator.preflight.scene.scene import Scene
from orchestrator.preflight.stability.contacts import Touch, touches
from orchestrator.preflight.stability.limits import (
    AHEAD,
    LARGEST_MASS,
    carried_share,
    extrapolated_clamps_s,
    foreseen_mode_s,
    foreseen_sphere_s,
    late_contact_s,
    late_reaction_s,
    late_rocking_s,
    light_point_s,
    resting_mode_s,
    rocking_s,
)
from orchestrator.preflight.stability.modes import FrameMatrices, areal_kg_per_m2, lightest_point_kg

SOURCE = "docs/theory/stability.md, "


@dataclass(frozen=True)
class Bound:
    """The longest sync interval that one effect allows.

    "stability": beyond it something grows without end.  "accuracy": beyond it the answer is
    worse than the project's own rule, but bounded.  ``interval_s`` is infinite where the effect
    sets no limit and 0 where no interval is short enough; ``source`` is where the formula comes
    from, ``why`` the case's own numbers in it, ``where`` the particles and the surface that set it.
    """

    name: str
    interval_s: float
    source: str
    why: str
    kind: Literal["stability", "accuracy"] = "stability"
    where: str = ""


@dataclass(frozen=True)
class Seat:
    """A contact, and what it rests on: effective mass, highest frequency (0: a free mass)."""

    panel: str
    touch: Touch
    mass_kg: float
    mode_rad_per_s: float

    @property
    def point(self) -> tuple[float, float]:
        return self.mass_kg, self.mode_rad_per_s

    @property
    def masses_kg(self) -> tuple[float, float]:
        return self.touch.mass_kg, self.mass_kg


Limit = Callable[[Seat, float, float], float]
"""The longest interval of a seat whose contact has a stiffness k and a damping g."""

CONTACT_LIMITS: dict[str, dict[str, tuple[Literal["deepest", "resting"], Limit]]] = {
    "particles-first": {
        "light points": ("deepest", lambda s, k, g: light_point_s(k, g, *s.point)),
        "lasting contacts, panels' modes": (
            "resting",
            lambda s, k, g: resting_mode_s(k, g, s.mode_rad_per_s),
        ),
        "lasting contacts, light points": ("resting", lambda s, k, g: rocking_s(k, g, *s.masses_kg)),
    },
    "robin": {
        "foreseen contacts, panels' modes": ("deepest", lambda s, k, g: foreseen_mode_s(k, g, *s.point)),
        "foreseen contacts, spheres": ("deepest", lambda s, k, g: foreseen_sphere_s(k, g, *s.masses_kg)),
    },
    "serial-staggered": {
        "late contacts": ("deepest", lambda s, k, g: late_contact_s(k, g, *s.point)),
        "late contacts, light points": ("deepest", lambda s, k, g: late_rocking_s(k, g, *s.masses_kg)),
    },
}
"""Scheme -> name of each bound -> which contact of a seat it takes, and its limit."""


def contact_bounds(
    scene: Scene, modes_rad_per_s: dict[str, float], frames: FrameMatrices | None
) -> Iterator[Bound]:
    """Yields for each limit the worst of all particles on all panels, where their load moves these."""
    exchange, scheme = scene.case.exchange, scene.case.coupling.scheme
    if not (exchange.particle_load and exchange.panel_motion):
        return
    if scheme == "robin" and not scene.case.panel.adapter.yields:
        scheme = "particles-first"  # that is what it does on them
    seats = list(_seats(scene, modes_rad_per_s, frames))
    for name, (kind, limit_s) in CONTACT_LIMITS.get(scheme, {}).items() if seats else ():
        rows = [(seat, getattr(seat.touch, kind)) for seat in seats]
        limits_s = [limit_s(seat, c.stiffness_N_per_m, c.damping_N_s_per_m) for seat, c in rows]
        shortest_s = min(limits_s)
        seat, contact = rows[limits_s.index(shortest_s)]
        where = f"{seat.touch} on {seat.panel}"
        why = (
            f"{where}: {contact.stiffness_N_per_m:.3g} N/m and "
            f"{contact.damping_N_s_per_m:.3g} N s/m on {1e3 * seat.mass_kg:.3g} g"
        )
        yield Bound(name, shortest_s, SOURCE + name, why, where=where)


def _seats(scene: Scene, modes_rad_per_s: dict[str, float], frames: FrameMatrices | None) -> Iterator[Seat]:
    """What carries a sphere: the lightest point where it is alone, of many side by side the area
    that each takes, and of a few that crowd on the lightest point its share."""
    for name, panel in scene.case.screen.panels.items():
        for touch in touches(scene, panel.material):
            mass_kg = _mass_kg(scene, name, panel, touch, frames)
            if mass_kg is not None:
                yield Seat(name, touch, mass_kg, modes_rad_per_s.get(name, 0.0))


def _mass_kg(
    scene: Scene, name: str, panel: PanelTable, touch: Touch, frames: FrameMatrices | None
) -> float | None:
    """None where nothing moves under a load."""
    if scene.case.panel.adapter.yields:
        alone_kg = lightest_point_kg(scene.case, name)
        crowded_kg = areal_kg_per_m2(scene.case, panel) * touch.area_m2
        return min(alone_kg, max(crowded_kg, alone_kg / touch.most))
    wanted = scene.case.exchange
    if frames is None or not (wanted.panel_reaction and wanted.frame_motion):
        return None
    area_m2 = sum(p.panel.rectangle.span_m * p.panel.rectangle.width_m for p in scene.panels)
    return frames.lightest_kg * touch.area_m2 / area_m2


def frame_bounds(case: Case, frames: FrameMatrices) -> Iterator[Bound]:
    """Yields the bounds from panels, as springs and as masses, on frames that they push."""
    scheme = case.coupling.scheme
    if not (case.exchange.panel_reaction and case.exchange.frame_motion):
        return

    def bound(name: str, limit_s: float, why: str) -> Bound:
        return Bound(name, limit_s, SOURCE + name, why)

    if scheme in LARGEST_MASS:
        share, limit = carried_share(frames.mass, frames.carried), LARGEST_MASS[scheme]
        why = f"panels' mass on the frames is up to {share:.2g} of their own; the limit is {limit:.2g}"
        yield bound("carried mass", math.inf if share < limit else 0.0, why)
    if scheme in AHEAD:
        limit_s = extrapolated_clamps_s(frames.mass, frames.panels_N_per_m)
        yield bound("extrapolated clamps", limit_s, "frames alone on the panels as springs")
    if scheme == "serial-staggered":
        _, shapes = frames.modes()
        limit_s = late_reaction_s(shapes, frames.panels_N_per_m, frames.damping_N_s_per_m)
        why = "bushings' damping over panels' stiffness, in the mode where it is least"
        yield bound("late reaction", limit_s, why)


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
    yields = case.panel.adapter.yields
    panels_throw = scene.throw if case.panel.adapter.deforms else scene.frames_throw
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
    forces = scene.case.frames.adapter.moved_by_forces
    unmoved = not (forces and scene.case.exchange.panel_reaction)
    known = {drive.body for drive in scene.plan.drives} | {GROUND}
    return unmoved or known.issuperset(frames)


def surface_bounds(scene: Scene) -> Iterator[Bound]:
    """Of all particles on all that they meet."""
    surfaces = met(scene)
    yield from shortest_impact(scene, [one for one in surfaces if not one.known])
    if scene.case.exchange.panel_motion:
        yield from _worst_surface("moving surface", scene, surfaces, _extrapolated_s)
        yield from _worst_surface("driven surface", scene, surfaces, _smoothed_s)


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


def _worst_surface(
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
