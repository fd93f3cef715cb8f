"""A panel's recorded motion: its shape between the clamps over whole cycles of the machine.

The panel's points stand on a rectangular grid of rows (constant s) and columns (constant y) in
material coordinates.  Carried by its clamps alone, the panel would be flat: bilinear between the
eight corners of the two clamps' rectangles (four where they have no depth).  The *shape* is what
is left: actual place less carried place, in the panel's axes (along, across, normal) at t = 0.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchestrator.ports import Array
from orchestrator.ports.geometry import Rectangle


@dataclass(frozen=True)
class RecordedGrid:
    """A grid of ``rows_m`` (a,) and ``columns_m`` (b,), both increasing.

    It reaches from clamp's outer edge to clamp's outer edge and from side to side; points are numbered with y
    running fastest.
    """

    rows_m: Array
    columns_m: Array

    @staticmethod
    def of(rectangle: Rectangle, cells: tuple[int, int]) -> RecordedGrid:
        """Return the grid of ``cells`` equal cells along and across, and one row under each clamp."""
        free = np.linspace(0.0, rectangle.length_m, cells[0] + 1)
        under = [rectangle.clamp_m] if rectangle.clamp_m > 0 else []
        rows = [*(-c for c in under), *free, *(rectangle.length_m + c for c in under)]
        return RecordedGrid(np.array(rows), np.linspace(0.0, rectangle.width_m, cells[1] + 1))

    @property
    def points_m(self) -> Array:
        """The material coordinates (points, 2)."""
        s, y = np.meshgrid(self.rows_m, self.columns_m, indexing="ij")
        return np.column_stack([s.ravel(), y.ravel()])

    def corners_m(self, rectangle: Rectangle) -> Array:
        """Return the material coordinates (corners, 2) of the clamps' corners, row by row."""
        return np.array([(s, y) for s in _edges_m(rectangle) for y in (0.0, rectangle.width_m)])

    def carried(self, rectangle: Rectangle) -> Array:
        """Return the matrix N (points, corners) for which the clamps alone carry  points = N @ corners."""
        s, y = self.points_m.T
        along = hats(s, _edges_m(rectangle))
        across = hats(y, np.array([0.0, rectangle.width_m]))
        return both_ways(along, across)

    def mass_kg(self, rectangle: Rectangle, per_area_kg_per_m2: float, share: float) -> Array:
        """Return the lumped masses (points,): every cell gives a quarter to each of its corners.

        ``share`` is the share of the free length's material that openings leave.
        """
        middle = (self.rows_m[1:] + self.rows_m[:-1]) / 2
        free = (middle > 0) & (middle < rectangle.length_m)
        along = _halves(np.diff(self.rows_m) * np.where(free, share, 1.0))
        return per_area_kg_per_m2 * np.outer(along, _halves(np.diff(self.columns_m))).ravel()


@dataclass(frozen=True)
class Recording:
    """Whole ``cycles`` of one panel, sampled at equal steps of the machine's angle from 0.

    ``shape_m`` and ``rate_m`` (samples, points, 3): the shape, and its derivative with respect to
    the angle in rad.  ``rest_m`` (points, 3): the shape at rest.  ``pull_N`` (samples, 3) and
    ``rest_pull_N`` (3,): the panel's force on its first clamp, and against it on the second,
    beyond what weight and inertia give by the lever rule.  All in the panel's axes.
    """

    grid: RecordedGrid
    cycles: int
    shape_m: Array
    rate_m: Array
    rest_m: Array
    pull_N: Array
    rest_pull_N: Array

    def __post_init__(self) -> None:
        samples, points = len(self.shape_m), len(self.grid.points_m)
        for name, shape in (
            ("shape_m", (samples, points, 3)),
            ("rate_m", (samples, points, 3)),
            ("rest_m", (points, 3)),
            ("pull_N", (samples, 3)),
            ("rest_pull_N", (3,)),
        ):
            value = getattr(self, name)
            if value.shape != shape or not np.isfinite(value).all():
                raise ValueError(f"{name}: shape {value.shape} or not finite, {shape} is wanted")


@dataclass(frozen=True)
class Playback:
    """A recording and the machine's angle that it follows, ``speed_rad_per_s`` (t - ``zero_s``).

    The motion grows from rest from ``start_s`` on, within ``run_up_s``.
    """

    recording: Recording
    speed_rad_per_s: float
    zero_s: float
    start_s: float
    run_up_s: float


def hats(places: Array, nodes: Array) -> Array:
    """Return linear interpolation between increasing nodes as a matrix (places, nodes)."""
    return np.column_stack([np.interp(places, nodes, unit) for unit in np.eye(len(nodes))])


def both_ways(along: Array, across: Array) -> Array:
    """Return, row by row, all products of (n, a) and (n, b): (n, a b)."""
    return np.asarray((along[:, :, None] * across[:, None, :]).reshape(len(along), -1))


def _edges_m(rectangle: Rectangle) -> Array:
    c, length = rectangle.clamp_m, rectangle.length_m
    return np.array([-c, 0.0, length, length + c] if c > 0 else [0.0, length])


def _halves(lengths: Array) -> Array:
    """Return each node's part of the lengths between nodes: half of the length on either side."""
    shares = np.zeros(len(lengths) + 1)
    shares[:-1] += lengths / 2
    shares[1:] += lengths / 2
    return shares
