"""The bounds on the sync interval of a scene, for stability and for accuracy.

They come from particles on panels, from panels on frames that they push, and from particles on
surfaces that move between sync points.  The path of a driven surface is known, except for its
deviation from a smooth curve between sync points.  Particles see a free surface where it would be
without acceleration.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache, partial
from typing import Literal, NamedTuple

from orchestrator.case.bed.contact_times import (
    hertz_overlap_m,
    hertz_s,
    hertz_static_overlap_m,
    pair_modulus_Pa,
)
from orchestrator.case.bed.grains import largest_grains, smallest_grains
from orchestrator.case.tables.quantities import GROUND
from orchestrator.ports.grains import Grain
from orchestrator.preflight.scene.moved_panel import loss_factor
from orchestrator.preflight.scene.scene import Scene, bed_kg, deck_m2
from orchestrator.preflight.stability import limits
from orchestrator.preflight.stability.modes import FrameMatrices, areal_kg_per_m2, lightest_point_kg

SECTIONS = {"whole impacts": "what is sure"}
"""Sections of docs/theory/stability.md by the name of the bound, if the two names differ."""


@dataclass(frozen=True)
class Bound:
    """The longest sync interval that one effect allows.

    Within a bound on "stability" 99 of 100 random scenes create less than 1 % of the energy exchanged
    (``tools.promise_bank``, docs/measured/stability.md).  Beyond a bound on "accuracy" the answer is worse
    than the project's own rule, but bounded.  ``interval_s`` is infinite if the effect sets no limit, and 0
    if no interval is short enough.  ``why`` has the case's own numbers, and ``where`` names the particles and
    the surface that set the bound.  ``interval_s`` is the share ``sure`` of the interval beyond which
    something grows without end.
    """

    name: str
    interval_s: float
    why: str
    kind: Literal["stability", "accuracy"] = "stability"
    where: str = ""
    sure: float = 1.0

    @property
    def source(self) -> str:
        """The document and section that derive the formula."""
        return f"docs/theory/stability.md, {SECTIONS.get(self.name, self.name)}"


class ContactSpring(NamedTuple):
    """The spring and the damper of a contact that is linear about some depth."""

    stiffness_N_per_m: float
    damping_N_s_per_m: float


@dataclass(frozen=True)
class Touch:
    """Particles of one size on a surface.

    ``deepest`` is the contact in an impact or under the bed, whichever goes deeper.  ``resting`` is the
    contact under the thrown bed.  ``resting_m`` is the depth of a sphere under the larger of the bed's
    weight and its own.  ``impact_s`` is the duration of an impact, and ``area_m2`` the area of the
    surface for each sphere if they lie side by side.
    """

    material: str
    size_m: float
    mass_kg: float
    deepest: ContactSpring
    resting: ContactSpring
    resting_m: float
    impact_s: float
    area_m2: float

    def __str__(self) -> str:
        return f"{self.material} of {1e3 * self.size_m:.3g} mm"


def touches(scene: Scene, surface_material: str) -> list[Touch]:
    """Return the smallest and the largest particles of each material on surfaces of one material."""
    smallest, largest = smallest_grains(scene.case), largest_grains(scene.case)
    return [
        _touch(scene, name, grain, surface_material)
        for name in smallest
        for grain in {each.sieve_size_m: each for each in (smallest[name], largest[name])}.values()
    ]


def _touch(scene: Scene, name: str, grain: Grain[float], surface_material: str) -> Touch:
    case, speed_m_per_s = scene.case, scene.impact_m_per_s
    reduced_Pa = pair_modulus_Pa(case, (name, surface_material))
    mass_kg, radius_m = grain.mass_kg, grain.contact_radius_m
    area_m2 = math.sqrt(3) / 2 * (2 * grain.bounding_radius_m) ** 2  # side by side, in hexagons
    bed_Pa = scene.bed_kg_per_m2 * scene.gravity_m_per_s2
    thrown_N = bed_Pa * (1 + scene.panels_throw) * area_m2
    lying_N = max(bed_Pa * area_m2, mass_kg * scene.gravity_m_per_s2)
    pressed_m = hertz_static_overlap_m(thrown_N, radius_m, reduced_Pa)
    deepest_m = max(pressed_m, hertz_overlap_m(mass_kg, radius_m, reduced_Pa, speed_m_per_s))
    pairs = {frozenset(row.between): row.restitution_at(speed_m_per_s) for row in case.contacts}
    log_e = math.log(pairs[frozenset((name, surface_material))])

    def spring(depth_m: float) -> ContactSpring:
        """Return Hertz's contact, linear about a depth.

        The stiffness is 2 E* sqrt(R depth) and the damping 2 sqrt(5/6) beta sqrt(stiffness m) with
        beta = -ln e / sqrt(ln^2 e + pi^2) (Tsuji, Tanaka and Ishida, Powder Technology 71, 1992,
        239-250, doi 10.1016/0032-5910(92)88030-L, in the form of LIGGGHTS's model hertz).
        """
        stiffness_N_per_m = 2 * reduced_Pa * math.sqrt(radius_m * depth_m)
        beta = -log_e / math.hypot(log_e, math.pi)
        damping_N_s_per_m = 2 * math.sqrt(5 / 6) * beta * math.sqrt(stiffness_N_per_m * mass_kg)
        return ContactSpring(stiffness_N_per_m, damping_N_s_per_m)

    return Touch(
        material=name,
        size_m=grain.sieve_size_m,
        mass_kg=mass_kg,
        deepest=spring(deepest_m),
        resting=spring(pressed_m),
        resting_m=hertz_static_overlap_m(lying_N, radius_m, reduced_Pa),
        impact_s=hertz_s(mass_kg, radius_m, reduced_Pa, speed_m_per_s),
        area_m2=area_m2,
    )


class Seat(NamedTuple):
    """A sphere in contact with a panel, and the effective mass and highest frequency of its support.

    The frequency is 0 for a free mass.
    """

    panel: str
    touch: Touch
    sphere_kg: float
    mass_kg: float
    mode_rad_per_s: float


MODE, POINT, PAIR = ("mode_rad_per_s",), ("mass_kg", "mode_rad_per_s"), ("sphere_kg", "mass_kg")
CONTACT_LIMITS: dict[str, dict[str, tuple[str, Callable[..., float], tuple[str, ...]]]] = {
    "particles-first": {
        "light points": ("deepest", limits.light_point_s, POINT),
        "lasting contacts, panels' modes": ("resting", limits.resting_mode_s, MODE),
        "lasting contacts, light points": ("resting", limits.rocking_s, PAIR),
    },
    "robin": {
        "foreseen contacts, panels' modes": ("deepest", limits.foreseen_mode_s, POINT),
        "foreseen contacts, spheres": ("deepest", limits.foreseen_sphere_s, PAIR),
    },
    "serial-staggered": {
        "late contacts": ("deepest", limits.late_contact_s, POINT),
        "late contacts, light points": ("deepest", limits.late_rocking_s, PAIR),
    },
}
"""The limits of growth of each scheme by name: the contact of a seat, the function of the limit, and the
fields of the seat that the function takes besides the contact's stiffness and damping."""

CONTACT_LIMITS |= dict.fromkeys(("aitken", "quasi-newton"), CONTACT_LIMITS["particles-first"])

SURE = {"particles-first": 0.8, "robin": 0.2, "serial-staggered": 1 / 16, "aitken": 5.0, "quasi-newton": 5.0}
"""Shares of these limits up to which a scheme is sure to be sound (docs/measured/stability.md).

A contact that begins within an interval is not foreseen, and a load that comes late adds energy in every
impact, long before anything grows without end.  Repeated intervals are stable far beyond the limits of
particles-first, until a try throws a light point so far that its panel breaks down."""
SURE_OF_CLAMPS = 0.5
"""The same for extrapolated clamps."""
INTERVALS_PER_SURE_IMPACT = {"aitken": 10, "quasi-newton": 40, "serial-staggered": 800}
"""The fewest intervals to the shortest impact with which a scheme is sure to be sound."""


def contact_bounds(
    scene: Scene, modes_rad_per_s: Mapping[str, float], frames: FrameMatrices | None
) -> Iterator[Bound]:
    """Yield for each limit the bound of the worst seat, if the particles' load moves the panels."""
    exchange, scheme = scene.case.exchange, scene.case.coupling.scheme
    if not (exchange.particle_load and exchange.panel_motion):
        return
    if scheme == "robin" and not scene.case.panel.adapter.yields:
        scheme = "particles-first"  # robin does the same as that scheme on panels that do not yield
    seats = list(_seats(scene, modes_rad_per_s, frames))
    for name, (contact, limit_s, wanted) in CONTACT_LIMITS.get(scheme, {}).items() if seats else ():
        rows = [
            (limit_s(*getattr(seat.touch, contact), *(getattr(seat, each) for each in wanted)), seat)
            for seat in seats
        ]
        shortest_s, seat = min(rows, key=lambda row: row[0])
        k, g = getattr(seat.touch, contact)
        where = f"{seat.touch} on {seat.panel}"
        why = f"{where}: {k:.3g} N/m and {g:.3g} N s/m on {1e3 * seat.mass_kg:.3g} g"
        sure = SURE.get(scheme, 1.0)
        yield Bound(name, sure * shortest_s, why, where=where, sure=sure)


def _seats(
    scene: Scene, modes_rad_per_s: Mapping[str, float], frames: FrameMatrices | None
) -> Iterator[Seat]:
    """Yield the seats of all spheres on all panels.

    A single sphere rests on the lightest point of a panel.  One of many side by side rests on its own
    area, and one of a few that crowd on the lightest point on its share of that.  Panels that do not
    yield carry spheres with the lightest frame; if nothing moves that, they have no seats.
    """
    case, exchange = scene.case, scene.case.exchange
    yields = case.panel.adapter.yields
    all_kg, area_m2, touches_of = bed_kg(case), deck_m2(case), cache(partial(touches, scene))
    for name, panel in case.screen.panels.items():
        touching = touches_of(panel.material)
        alone_kg = lightest_point_kg(case, name) if yields and touching else 0.0
        for touch in touching:
            if yields:
                crowd = max(1.0, all_kg / touch.mass_kg)
                mass_kg = min(alone_kg, max(areal_kg_per_m2(case, panel) * touch.area_m2, alone_kg / crowd))
            elif frames is not None and exchange.panel_reaction and exchange.frame_motion:
                mass_kg = frames.lightest_kg * touch.area_m2 / area_m2
            else:
                continue
            yield Seat(name, touch, touch.mass_kg, mass_kg, modes_rad_per_s.get(name, 0.0))


def frame_bounds(
    scene: Scene, modes_rad_per_s: Mapping[str, float], frames: FrameMatrices
) -> Iterator[Bound]:
    """Yield the bounds that panels, as springs, as masses and as bars, set on frames that they push."""
    scheme, exchange = scene.case.coupling.scheme, scene.case.exchange
    if not (exchange.panel_reaction and exchange.frame_motion):
        return
    if scheme in limits.LARGEST_MASS:
        share, limit = limits.carried_share(frames.mass, frames.carried), limits.LARGEST_MASS[scheme]
        why = f"panels' mass on the frames is up to {share:.2g} of their own; the limit is {limit:.2g}"
        yield Bound("carried mass", math.inf if share < limit else 0.0, why)
    if scheme in limits.EXTRAPOLATING:
        limit_s = limits.extrapolated_clamps_s(frames.mass, frames.panels_N_per_m)
        why = "frames alone on the panels as springs"
        yield Bound("extrapolated clamps", SURE_OF_CLAMPS * limit_s, why, sure=SURE_OF_CLAMPS)
        if math.isfinite(limit_s) and modes_rad_per_s:  # implicit steps damp what they do not resolve
            yield _vibrating_panels(scene, max(modes_rad_per_s.values()), 1 / limit_s)
    if scheme == "serial-staggered":
        _, shapes = frames.modes()
        limit_s = limits.late_reaction_s(shapes, frames.panels_N_per_m, frames.damping_N_s_per_m)
        why = "bushings' damping over panels' stiffness, in the mode where it is least"
        yield Bound("late reaction", limit_s, why)


def _vibrating_panels(scene: Scene, highest_rad_per_s: float, swing_rad_per_s: float) -> Bound:
    """Return the bound for the vibrations of panels along themselves, which frames answer late."""

    def least_loss(speed_rad_per_s: float) -> float:
        return min(loss_factor(panel.material, speed_rad_per_s) for panel in scene.panels)

    limit_s = limits.vibrating_panels_s(swing_rad_per_s, highest_rad_per_s, least_loss)
    least = least_loss(limits.GROWING[0] / limit_s)
    highest_Hz = highest_rad_per_s / (2 * math.pi)
    why = f"panels' highest frequency, {highest_Hz:.3g} Hz; loss factor {least:.2g} at the limit"
    return Bound("vibrating panels", limit_s, why)


INTERVALS_PER_CONTACT = 10
SHARE_OF_OVERLAP = 0.1
"""Allowed error of a surface's place over the overlap of the particles on it.  The mean error over the
interval is a third of that."""
STRAIGHT, CHORD = 1 / 2, 1 / 8
"""Largest distances, over a H^2, of a surface with acceleration a in an interval H: from a straight path
that starts with its velocity, at the end of the interval, and from the chord, in the middle."""
HERMITE = 1 / 384
"""Largest error of a cubic Hermite path over H^4 times the fourth derivative of the true path."""


@dataclass(frozen=True)
class MetSurface:
    """A panel or a wall that particles meet.

    ``known`` says that a drive moves it or that it stands still.  ``yields`` says that its points give
    way to loads by themselves, as only the points of elastic panels do.  ``acceleration_m_per_s2`` is
    its largest acceleration in the scene.
    """

    name: str
    material: str
    known: bool
    yields: bool
    acceleration_m_per_s2: float


def met_surfaces(scene: Scene) -> list[MetSurface]:
    """Return every panel and every wall.

    Rigid panels and walls accelerate as the frames do.  Other panels accelerate as their middles or as
    the frames, whichever is more.
    """
    case, moves = scene.case, scene.case.exchange.frame_motion
    panel_solver, gravity_m_per_s2 = case.panel.adapter, scene.gravity_m_per_s2
    pushed = case.frames.adapter.moved_by_forces and case.exchange.panel_reaction
    driven = {drive.body for drive in scene.plan.drives} | {GROUND}

    def known(*frames: str) -> bool:
        return not (moves and pushed) or driven.issuperset(frames)

    throw = (scene.throw if panel_solver.deforms else scene.frames_throw) if moves else 0.0
    surfaces = [
        MetSurface(
            name,
            panel.material,
            known=not panel_solver.yields and known(*panel.frames),
            yields=panel_solver.yields,
            acceleration_m_per_s2=throw * gravity_m_per_s2,
        )
        for name, panel in case.screen.panels.items()
    ]
    for name, wall in case.screen.surfaces.items():
        throw = scene.frames_throw if moves and wall.frame != GROUND else 0.0
        surfaces.append(MetSurface(name, wall.material, known(wall.frame), False, throw * gravity_m_per_s2))
    return surfaces


def surface_bounds(scene: Scene) -> Iterator[Bound]:
    """Yield the bounds from all particles on all surfaces that they meet.

    For accuracy, the shortest impact on a surface that loads move must last ten intervals, and the places of
    surfaces must be exact to a share of the particles' overlaps.  Some schemes are sure to be sound only with
    so many intervals to the shortest impact.
    """
    touches_of = cache(partial(touches, scene))
    meetings = [(surface, touch) for surface in met_surfaces(scene) for touch in touches_of(surface.material)]
    free = [touch for surface, touch in meetings if not surface.known]
    shortest = min(free, key=lambda touch: touch.impact_s, default=None)
    if shortest is not None and math.isfinite(shortest.impact_s):
        why = (
            f"{shortest} at {scene.impact_m_per_s:.3g} m/s for {shortest.impact_s:.3g} s, "
            f"{INTERVALS_PER_CONTACT} intervals"
        )
        interval_s = shortest.impact_s / INTERVALS_PER_CONTACT
        yield Bound("shortest impact", interval_s, why, "accuracy", str(shortest))
        intervals = INTERVALS_PER_SURE_IMPACT.get(scene.case.coupling.scheme)
        if intervals and scene.case.exchange.particle_load and scene.case.exchange.panel_motion:
            why = f"{shortest.impact_s:.3g} s of {shortest}, {intervals} intervals"
            yield Bound("whole impacts", shortest.impact_s / intervals, why, where=str(shortest))
    if not scene.case.exchange.panel_motion:
        return
    for name, allowed_s in (("moving surface", _extrapolated_s), ("driven surface", _smoothed_s)):
        rows = [(allowed_s(scene, surface, touch), surface, touch) for surface, touch in meetings]
        rows = [row for row in rows if math.isfinite(row[0])]
        if rows:
            interval_s, surface, touch = min(rows, key=lambda row: row[0])
            why = (
                f"{touch} lies {touch.resting_m:.2g} m deep in {surface.name}, which speeds up by up to "
                f"{surface.acceleration_m_per_s2:.3g} m/s2; off by {SHARE_OF_OVERLAP:g} of that depth"
            )
            yield Bound(name, interval_s, why, "accuracy", f"{touch} on {surface.name}")


def _extrapolated_s(scene: Scene, surface: MetSurface, touch: Touch) -> float:
    """Return the interval in which the place of a free surface is wrong by ``SHARE_OF_OVERLAP``.

    robin extrapolates surfaces whose motion it does not predict.  serial-staggered sets no limit,
    because it shows the particles the path that the surface has gone.
    """
    scheme = scene.case.coupling.scheme
    if surface.known or surface.acceleration_m_per_s2 == 0.0 or scheme == "serial-staggered":
        return math.inf
    drifts = scheme == "particles-first" or (scheme == "robin" and not surface.yields)
    share = STRAIGHT if drifts else CHORD
    return math.sqrt(SHARE_OF_OVERLAP * touch.resting_m / (share * surface.acceleration_m_per_s2))


def _smoothed_s(scene: Scene, surface: MetSurface, touch: Touch) -> float:
    """Return the interval in which the smooth path of a driven surface is wrong by ``SHARE_OF_OVERLAP``.

    The error of the path goes with H^4 a w^2.
    """
    if not surface.known or surface.acceleration_m_per_s2 == 0.0:
        return math.inf
    fourth_m_per_s4 = surface.acceleration_m_per_s2 * scene.speed_rad_per_s**2
    return math.pow(SHARE_OF_OVERLAP * touch.resting_m / (HERMITE * fourth_m_per_s4), 1 / 4)
