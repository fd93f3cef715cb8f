"""Bounds from particles on panels: the worst contact of each formula."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from orchestrator.case import solvers
from orchestrator.case.tables.screen import PanelTable
from orchestrator.preflight.scene.scene import Scene
from orchestrator.preflight.stability.bound import Bound
from orchestrator.preflight.stability.contact_limits import (
    foreseen_mode_s,
    foreseen_sphere_s,
    late_contact_s,
    late_rocking_s,
    light_point_s,
    resting_mode_s,
    rocking_s,
)
from orchestrator.preflight.stability.frame_modes import FrameMatrices
from orchestrator.preflight.stability.panel_masses import areal_kg_per_m2, lightest_point_kg
from orchestrator.preflight.stability.touching import ContactSpring, Touch, touches

SOURCE = "docs/theory/stability.md, "


@dataclass(frozen=True)
class Seat:
    """A contact, and what it rests on: effective mass, highest frequency (0: a free mass)."""

    panel: str
    touch: Touch
    mass_kg: float
    mode_rad_per_s: float


def contacts(
    scene: Scene, modes_rad_per_s: dict[str, float], frames: FrameMatrices | None
) -> Iterator[Bound]:
    """Of all particles on all panels, where their load moves what they touch."""
    wanted = scene.case.exchange
    if not (wanted.particle_load and wanted.panel_motion):
        return
    seats = list(_seats(scene, modes_rad_per_s, frames))
    rules = {"particles-first": _drifting, "robin": _foreseen, "serial-staggered": _late}
    scheme = scene.case.coupling.scheme
    if scheme == "robin" and not solvers.panel(scene.case).yields:
        scheme = "particles-first"  # that is what it does on them
    if seats and scheme in rules:
        yield from rules[scheme](seats)


def _drifting(seats: list[Seat]) -> Iterator[Bound]:
    """particles-first."""
    yield _worst("light points", seats, _deepest, lambda s, k, g: light_point_s(k, g, *_point(s)))
    modes = "lasting contacts, panels' modes"
    yield _worst(modes, seats, _resting, lambda s, k, g: resting_mode_s(k, g, s.mode_rad_per_s))
    pairs = "lasting contacts, light points"
    yield _worst(pairs, seats, _resting, lambda s, k, g: rocking_s(k, g, *_masses(s)))


def _foreseen(seats: list[Seat]) -> Iterator[Bound]:
    """robin."""
    modes = "foreseen contacts, panels' modes"
    yield _worst(modes, seats, _deepest, lambda s, k, g: foreseen_mode_s(k, g, *_point(s)))
    pairs = "foreseen contacts, spheres"
    yield _worst(pairs, seats, _deepest, lambda s, k, g: foreseen_sphere_s(k, g, *_masses(s)))


def _late(seats: list[Seat]) -> Iterator[Bound]:
    """serial-staggered."""
    yield _worst("late contacts", seats, _deepest, lambda s, k, g: late_contact_s(k, g, *_point(s)))
    pairs = "late contacts, light points"
    yield _worst(pairs, seats, _deepest, lambda s, k, g: late_rocking_s(k, g, *_masses(s)))


def _deepest(seat: Seat) -> ContactSpring:
    return seat.touch.deepest


def _resting(seat: Seat) -> ContactSpring:
    return seat.touch.resting


def _point(seat: Seat) -> tuple[float, float]:
    return seat.mass_kg, seat.mode_rad_per_s


def _masses(seat: Seat) -> tuple[float, float]:
    return seat.touch.mass_kg, seat.mass_kg


def _worst(
    name: str,
    seats: list[Seat],
    contact: Callable[[Seat], ContactSpring],
    limit_s: Callable[[Seat, float, float], float],
) -> Bound:
    """Of the seats, the one that allows least."""

    def allows_s(seat: Seat) -> float:
        return limit_s(seat, contact(seat).stiffness_N_per_m, contact(seat).damping_N_s_per_m)

    seat = min(seats, key=allows_s)
    touching = contact(seat)
    why = (
        f"{seat.touch} on {seat.panel}: {touching.stiffness_N_per_m:.3g} N/m and "
        f"{touching.damping_N_s_per_m:.3g} N s/m on {1e3 * seat.mass_kg:.3g} g"
    )
    where = f"{seat.touch} on {seat.panel}"
    return Bound(name, allows_s(seat), SOURCE + name, why, where=where)


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
    if solvers.panel(scene.case).yields:
        alone_kg = lightest_point_kg(scene.case, name)
        crowded_kg = areal_kg_per_m2(scene.case, panel) * touch.area_m2
        return min(alone_kg, max(crowded_kg, alone_kg / touch.most))
    wanted = scene.case.exchange
    if frames is None or not (wanted.panel_reaction and wanted.frame_motion):
        return None
    area_m2 = sum(p.panel.rectangle.span_m * p.panel.rectangle.width_m for p in scene.panels)
    return frames.lightest_kg * touch.area_m2 / area_m2
