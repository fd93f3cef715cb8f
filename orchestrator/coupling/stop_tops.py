"""Tops of beams below a panel, and how deep points of the panel have come through them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchestrator.ports import Array, Indices
from orchestrator.ports.geometry import Rectangle, foot_on_triangle
from orchestrator.ports.plans import Stop


@dataclass(frozen=True)
class Through:
    """Points (n,) seen from their tops: ``depth_m`` (n,) below them, ``normal`` (n, 3) of the tops,
    ``share`` (n, 3) of the top's three corners in the point's foot on it; they add up to one."""

    depth_m: Array
    normal: Array
    share: Array


@dataclass(frozen=True)
class Tops:
    """All stops of a panel.  Of its n points that can meet one: material coordinates (n, 2), the
    number of its stop (n,), and area, stiffness and damping of the layer under it (n,)."""

    coordinates_m: Array
    stop: Indices
    stiffness_N_per_m: Array
    damping_N_s_per_m: Array

    def through(self, corners_m: Array, place_m: Array) -> Through:
        """Points at ``place_m`` (n, 3), tops with ``corners_m`` (stops, 3, 3): the first, one along
        from it, one across from it."""
        foot = foot_on_triangle(corners_m[self.stop], place_m)
        return Through(-foot.height_m, foot.normal, foot.share)

    def onto_corners(self, share: Array, force_N: Array, stops: int) -> Array:
        """(stops, 3, 3) of forces (n, 3) at the points' feet."""
        given = np.zeros((stops, 3, 3))
        np.add.at(given, self.stop, share[:, :, None] * force_N[:, None, :])
        return given


def tops(stops: tuple[Stop, ...], rectangle: Rectangle, spacing_m: Array) -> Tops:
    """Points in the middles of cells of ``spacing_m`` (2,) at most, along and across."""
    coordinates, number, areas = [], [], []
    for place, stop in enumerate(stops):
        sides_m = np.array([stop.to_m - stop.from_m, rectangle.width_m])
        counts = np.ceil(sides_m / spacing_m - 1e-9).astype(int)
        s, y = ((np.arange(n) + 0.5) * side / n for n, side in zip(counts, sides_m, strict=True))
        grid = np.stack(np.meshgrid(stop.from_m + s, y, indexing="ij"), axis=-1).reshape(-1, 2)
        coordinates.append(grid)
        number.append(np.full(len(grid), place))
        areas.append(np.full(len(grid), sides_m.prod() / len(grid)))
    of, area_m2 = np.concatenate(number), np.concatenate(areas)
    stiffness, damping = np.array([(s.stiffness_Pa_per_m, s.damping_Pa_s_per_m) for s in stops])[of].T
    return Tops(np.concatenate(coordinates), of, stiffness * area_m2, damping * area_m2)


def corners_m(stop: Stop, rectangle: Rectangle) -> Array:
    """(3, 3) of the top in the world at t = 0, with the panel straight between its clamps."""
    below_m = rectangle.corner_m - stop.gap_m * rectangle.normal
    ends = np.array([[stop.from_m, 0.0], [stop.to_m, 0.0], [stop.from_m, rectangle.width_m]])
    return np.asarray(rectangle.mounted(ends) - rectangle.corner_m + below_m)
