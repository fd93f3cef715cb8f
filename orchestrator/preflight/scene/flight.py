"""The free flight of material between the solid surfaces of a case: what a thrown particle meets first.

Everything is in deck axes.  Panels are flat between their clamps and have no openings here, so that
openings hide no gaps.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from orchestrator.case.deck.panels import axes, single_panels, walls
from orchestrator.case.deck.triangle_grid import grid
from orchestrator.case.tables.case import Case
from orchestrator.ports import Array, Indices

PATH_STEP_M = 0.03  # Longest piece of a path that is taken as straight; it sags by less than 1 mm.
LONGEST_S = 3.0  # Flights are followed for this time; they fall 44 m.
PARALLEL = 1e-12  # Determinant below which a ray counts as parallel to a triangle.
RIM_M = 1e-6  # Rounding of the ends of steps and of triangles, with room.
AT_ONCE = 2_000_000  # Pairs of rays and triangles that are intersected at once.


@dataclass(frozen=True)
class Solids:
    """The panels and rigid surfaces of a case in deck axes, as triangles (m, 3, 3).

    ``panel`` (m,) has the number of the panel to which a triangle belongs, and -1 for rigid surfaces.
    """

    corners_m: Array
    panel: Indices

    @cached_property
    def rigid(self) -> Solids:
        """The rigid surfaces alone."""
        return Solids(self.corners_m[self.panel < 0], self.panel[self.panel < 0])

    @cached_property
    def _boxes_m(self) -> tuple[Array, Array]:
        """The lowest and the highest corners (3, m) of the boxes around the triangles, axis by axis."""
        low_m, high_m = self.corners_m.min(axis=1), self.corners_m.max(axis=1)
        return np.ascontiguousarray(low_m.T), np.ascontiguousarray(high_m.T)

    def first_hits(self, start_m: Array, step_m: Array) -> tuple[Array, Indices]:
        """Return where straight steps meet triangles first.

        ``start_m`` and ``step_m`` (n, 3) are the beginnings and the whole steps.  The result is the share of
        each step before the hit (n,), infinite without one, and the triangle's number (n,), -1 without one.
        """
        share, number = np.full(len(start_m), np.inf), np.full(len(start_m), -1)
        near = self._near(np.concatenate([start_m, start_m + step_m]))
        if not len(near):
            return share, number
        chunk = max(1, AT_ONCE // len(near))
        for first in range(0, len(start_m), chunk):
            part = slice(first, first + chunk)
            shares = intersect(start_m[part], step_m[part], self.corners_m[near])
            nearest = shares.argmin(axis=1)
            share[part] = shares[np.arange(len(shares)), nearest]
            number[part] = np.where(np.isfinite(share[part]), near[nearest], -1)
        return share, number

    def _near(self, points_m: Array) -> Indices:
        """Return the numbers of the triangles whose boxes meet the box around points (n, 3)."""
        if not len(points_m):
            return np.empty(0, dtype=np.int64)
        near = np.ones(len(self.corners_m), dtype=np.bool_)
        for low_m, high_m, along_m in zip(*self._boxes_m, points_m.T, strict=True):
            near &= (low_m <= along_m.max() + RIM_M) & (high_m >= along_m.min() - RIM_M)
        return np.flatnonzero(near)


def solids(case: Case, folder: Path) -> Solids:
    """Return the panels and rigid surfaces of a case.  Raises stl.UnreadableSurface."""
    turn = axes(case)
    corners_m, numbers = [np.empty((0, 3, 3))], [np.empty(0, dtype=np.int64)]
    for number, panel in enumerate(single_panels(case)):
        flat = grid(panel.rectangle, (1, 1))
        corners_m.append(panel.rectangle.mounted(flat.coordinates_m)[flat.triangles] @ turn)
        numbers.append(np.full(len(flat.triangles), number))
    for wall in walls(case, folder):
        corners_m.append(wall.position_m[wall.triangles] @ turn)
        numbers.append(np.full(len(wall.triangles), -1))
    return Solids(np.concatenate(corners_m), np.concatenate(numbers))


def intersect(start_m: Array, step_m: Array, corners_m: Array) -> Array:
    """Return the share (n, m) of each step (n, 3) at which it meets triangles (m, 3, 3); infinite if never.

    Moeller, T. and Trumbore, B., Journal of Graphics Tools 2, 1997, 21-28,
    doi 10.1080/10867651.1997.10487468.
    """
    a = corners_m[:, 0]
    one, two = corners_m[:, 1] - a, corners_m[:, 2] - a
    across = np.cross(step_m[:, None], two)
    determinant = np.einsum("mk,nmk->nm", one, across)
    size = np.linalg.norm(one, axis=1) * np.linalg.norm(two, axis=1)
    scale = size * np.linalg.norm(step_m, axis=1)[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        inverse = np.where(np.abs(determinant) > PARALLEL * scale, 1.0 / determinant, np.nan)
        from_a = start_m[:, None] - a
        u = np.einsum("nmk,nmk->nm", from_a, across) * inverse
        turned = np.cross(from_a, one)
        v = np.einsum("nk,nmk->nm", step_m, turned) * inverse
        share = np.einsum("mk,nmk->nm", two, turned) * inverse
        rim = 1e-9
        hit = (u >= -rim) & (v >= -rim) & (u + v <= 1 + rim) & (share >= 0) & (share <= 1)
    return np.where(hit, share, np.inf)


@dataclass(frozen=True)
class Landing:
    """What a flight meets first: "panel", "wall", "exit", "outside" of the domain, or "nothing" in 3 s.

    ``name`` is the exit's or the panel's, and "" for the others; ``place_m`` (3,) is in deck axes.
    """

    what: str
    name: str
    place_m: Array


class Flights:
    """The parabolas of particles without drag among the solids, exits and the domain of a case."""

    def __init__(self, case: Case, parts: Solids) -> None:
        self._solids = parts
        self._turn = axes(case)
        self._gravity_m_per_s2 = np.asarray(case.gravity_m_per_s2) @ self._turn
        self._domain_m = np.array(case.domain_m)
        self._exits_m = {name: np.array(row.box_m) for name, row in case.screen.exits.items()}
        self._panels = [panel.name for panel in single_panels(case)]
        self._open_sides = case.slice is not None and case.slice.sides == "periodic"

    def land(self, start_m: Array, velocity_m_per_s: Array) -> Landing:
        """Return what a particle that starts at a place (3,) with a velocity (3,) meets first."""
        times_s = self._times_s(velocity_m_per_s)[:, None]
        path_m = start_m + velocity_m_per_s * times_s + self._gravity_m_per_s2 / 2 * times_s**2
        in_world_m = path_m @ self._turn.T
        beyond = (in_world_m < self._domain_m[0]) | (in_world_m > self._domain_m[1])
        beyond[:, 1] &= not self._open_sides  # periodic sides leave y out
        outside = beyond.any(axis=1)
        events: list[tuple[float, str, str]] = [(len(path_m) - 1.0, "nothing", "")]
        if outside.any():
            events.append((float(np.argmax(outside)), "outside", ""))
        for name, box_m in self._exits_m.items():
            if np.isfinite(when := _first_inside(path_m, box_m, self._open_sides)):
                events.append((when, "exit", name))
        path_m = path_m[: int(np.ceil(min(events)[0])) + 1]  # Later pieces cannot be met first.
        share, triangle = self._solids.first_hits(path_m[:-1], np.diff(path_m, axis=0))
        met = np.flatnonzero(triangle >= 0)
        if len(met):
            number = int(self._solids.panel[triangle[met[0]]])
            name = self._panels[number] if number >= 0 else ""
            events.append((met[0] + float(share[met[0]]), "panel" if name else "wall", name))
        when, what, name = min(events)
        return Landing(what, name, path_m[min(int(when), len(path_m) - 1)])

    def _times_s(self, velocity_m_per_s: Array) -> Array:
        """Return times (n,) at which the path has advanced by some ``PATH_STEP_M``."""
        longest_m = float(np.linalg.norm(np.diff(self._domain_m, axis=0)))
        gravity = float(np.linalg.norm(self._gravity_m_per_s2))
        speed = float(np.linalg.norm(velocity_m_per_s))
        if gravity == 0 and speed == 0:
            return np.array([0.0, LONGEST_S])
        lengths_m = np.arange(0.0, longest_m + PATH_STEP_M, PATH_STEP_M)
        # s = v t + g t^2 / 2 bounds the length of the path from above
        times_s = (
            (np.sqrt(speed**2 + 2 * gravity * lengths_m) - speed) / gravity if gravity else lengths_m / speed
        )
        return np.asarray(times_s[times_s <= LONGEST_S])


def _first_inside(path_m: Array, box_m: Array, open_sides: bool) -> float:
    """Return the first place of a path (n, 3), as number of its piece and share, in a box; else infinity.

    A piece is inside from its latest entry between two sides to its earliest departure.  ``open_sides``
    leaves y out, as periodic sides do.
    """
    start_m, step_m = path_m[:-1], np.diff(path_m, axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        sides = (box_m[:, None] - start_m) / step_m
    still = step_m == 0
    between = (start_m >= box_m[0]) & (start_m <= box_m[1])
    enter = np.where(still, np.where(between, -np.inf, np.inf), sides.min(axis=0))
    leave = np.where(still, np.inf, sides.max(axis=0))
    if open_sides:
        enter[:, 1], leave[:, 1] = -np.inf, np.inf
    first, last = np.maximum(enter.max(axis=1), 0.0), np.minimum(leave.min(axis=1), 1.0)
    inside = np.flatnonzero(first <= last)
    return float(inside[0] + first[inside[0]]) if len(inside) else float("inf")
