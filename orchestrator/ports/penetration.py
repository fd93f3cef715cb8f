"""Search for panels that have gone through a rigid surface or through another panel.

Particles touch panels and surfaces; these do not touch each other, so that nothing holds a panel
that sags, or is thrown, through a plate.  Here it is found, from where everything is drawn (panels
straight between their clamps) and where everything is now.

A point of the panel has gone through a triangle when it was on one side of it as drawn and is on
the other side now, and when the straight way between the two places, as the triangle itself sees
it, leads through the triangle.  So neither joint motion nor motion along a surface counts, and a
panel that is drawn through a surface, or in its plane, is taken as meant.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from orchestrator.ports import Array, Indices
from orchestrator.ports.geometry import foot_on_triangle

IN_PLANE = 1e-3  # of its thickness: a panel drawn nearer to a surface's plane is on neither side
ON_RIM = 1e-9  # share of a corner: rounding on an edge that two triangles share


@dataclass(frozen=True)
class SurfaceBody:
    """A panel or a rigid surface with its ``triangles`` (m, 3) of point numbers."""

    name: str
    triangles: Indices


@dataclass(frozen=True)
class ProbedPanel:
    """What is looked at of a panel: the middles of ``pairs`` (k, 2) of point numbers (a pair of
    equal ones is the point itself) where nothing holds it.  ``body`` is its own number."""

    body: int
    pairs: Indices
    thickness_m: float


@dataclass(frozen=True)
class Penetration:
    """How deep a ``panel`` has gone through a ``surface``, in m and in its own thicknesses."""

    panel: str
    surface: str
    depth_m: float
    thicknesses: float


class Penetrations:
    """A search for panels that have gone through a surface since they were drawn.

    Parameters
    ----------
    drawn_m
        All points (n, 3) as drawn.
    bodies
        Everything that has triangles.
    panels
        The panels with the points to be examined.
    """

    def __init__(self, drawn_m: Array, bodies: Sequence[SurfaceBody], panels: Sequence[ProbedPanel]) -> None:
        self._bodies, self._panels = tuple(bodies), tuple(panels)
        self._drawn_m = drawn_m
        nothing = np.empty((0, 3), dtype=np.int64)
        self._triangles = np.concatenate([nothing, *(body.triangles for body in bodies)])
        counts = [len(body.triangles) for body in bodies]
        self._body = np.repeat(np.arange(len(counts)), counts)
        self._points = [np.unique(body.triangles) for body in bodies]
        self._drawn_boxes_m = self._boxes_of_bodies(drawn_m)
        self._drawn_triangles_m = boxes_of(drawn_m[self._triangles])
        self._drawn_middles_m = [middles_m(panel, drawn_m) for panel in panels]

    def deepest(self, position_m: Array) -> Penetration | None:
        """Return the deepest penetration with the points at ``position_m`` (n, 3); None without any."""
        boxes_m = np.stack([self._drawn_boxes_m, self._boxes_of_bodies(position_m)])
        panels = zip(self._panels, self._drawn_middles_m, strict=True)
        deepest = (self._deepest_of(panel, drawn_m, position_m, boxes_m) for panel, drawn_m in panels)
        return max(filter(None, deepest), key=lambda each: each.thicknesses, default=None)

    def _boxes_of_bodies(self, position_m: Array) -> Array:
        """Return the lowest and highest corners (bodies, 2, 3) of the boxes around all bodies; of NaN
        around a body without triangles."""
        boxes_m = np.full((len(self._bodies), 2, 3), np.nan)
        for box_m, points in zip(boxes_m, self._points, strict=True):
            if len(points):
                box_m[:] = position_m[points].min(axis=0), position_m[points].max(axis=0)
        return boxes_m

    def _deepest_of(
        self, panel: ProbedPanel, drawn_m: Array, position_m: Array, boxes_m: Array
    ) -> Penetration | None:
        """Return the deepest penetration of one panel, whose middles were drawn at ``drawn_m``; None without
        any."""
        now_m = middles_m(panel, position_m)
        row, triangle = self._near(panel, np.stack([drawn_m, now_m]), position_m, boxes_m)
        used, of_row = np.unique(triangle, return_inverse=True)
        was_m, is_m = (
            height_m(points[self._triangles[used]], of_row, place_m[row])
            for points, place_m in ((self._drawn_m, drawn_m), (position_m, now_m))
        )
        crossed = (was_m * is_m < 0.0) & (np.abs(was_m) > IN_PLANE * panel.thickness_m)
        if not crossed.any():
            return None
        row, triangle = row[crossed], triangle[crossed]
        was_m, is_m = was_m[crossed], is_m[crossed]
        corners = self._triangles[triangle]
        before = foot_on_triangle(self._drawn_m[corners], drawn_m[row]).share
        after = foot_on_triangle(position_m[corners], now_m[row]).share
        on_plane = before + (was_m / (was_m - is_m))[:, None] * (after - before)
        through = np.flatnonzero((on_plane >= -ON_RIM).all(axis=1))
        if not len(through):
            return None
        deepest = through[np.argmax(np.abs(is_m[through]))]
        depth_m = float(abs(is_m[deepest]))
        surface = self._bodies[self._body[triangle[deepest]]].name
        name = self._bodies[panel.body].name
        return Penetration(name, surface, depth_m, depth_m / panel.thickness_m)

    def _near(
        self, panel: ProbedPanel, points_m: Array, position_m: Array, boxes_m: Array
    ) -> tuple[Indices, Indices]:
        """Return pairs of a point (row) and a triangle (number) that the point may have gone through.

        ``points_m`` (2, n, 3) are the panel's points as drawn and now, ``boxes_m`` (2, bodies, 2, 3) the
        boxes around all bodies.  What is beyond the same side of a box before and after was beyond it all
        the way: so whole bodies drop out first, then triangles, then single points.
        """
        if not points_m.shape[1]:
            return np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)
        around_m = np.stack([points_m.min(axis=1), points_m.max(axis=1)], axis=1)[:, None]
        bodies = ~are_beyond(around_m, boxes_m)
        bodies[panel.body] = False
        triangles = np.flatnonzero(bodies[self._body])
        corners = self._triangles[triangles]
        boxes_m = np.stack([self._drawn_triangles_m[triangles], boxes_of(position_m[corners])])
        met = ~are_beyond(around_m, boxes_m)
        row, column = pairs_that_meet(points_m, boxes_m[:, met])
        return row, triangles[met][column]


def middles_m(panel: ProbedPanel, position_m: Array) -> Array:
    """Return the middles (k, 3) of a panel's pairs of points; all points are at ``position_m`` (n, 3)."""
    first, second = position_m[panel.pairs[:, 0]], position_m[panel.pairs[:, 1]]
    return np.asarray((first + second) / 2.0)


def are_beyond(one_m: Array, other_m: Array) -> npt.NDArray[np.bool_]:
    """Return where boxes (2, ..., 2, 3), as drawn and now, are beyond the same side of others both times.

    The last two axes have the lowest and the highest corner.  A box of NaN is beyond nothing, and nothing is
    beyond it.
    """
    below = one_m[..., 1, :] < other_m[..., 0, :]
    above = one_m[..., 0, :] > other_m[..., 1, :]
    return np.asarray((below.all(axis=0) | above.all(axis=0)).any(axis=-1))


def pairs_that_meet(points_m: Array, boxes_m: Array) -> tuple[Indices, Indices]:
    """Return the numbers of points (2, n, 3) and boxes (2, m, 2, 3), where no side parts the two both times.

    The pairs are in the order of points, then of boxes.  Along the axis on which the points lie widest apart,
    places in order give the pairs that may meet; then all axes are compared.
    """
    first_m, last_m = points_m.min(axis=0), points_m.max(axis=0)
    axis = int(np.argmax(np.ptp(first_m, axis=0)))
    order = np.argsort(first_m[:, axis], kind="stable")
    in_order_m, farthest_m = first_m[order, axis], (last_m - first_m)[:, axis].max()
    low = np.searchsorted(in_order_m, boxes_m[:, :, 0, axis].min(axis=0) - farthest_m)
    high = np.searchsorted(in_order_m, boxes_m[:, :, 1, axis].max(axis=0), side="right")
    counts = high - low
    column = np.repeat(np.arange(len(counts)), counts)
    row = order[np.arange(counts.sum()) + np.repeat(low - np.cumsum(counts) + counts, counts)]
    for axis in range(3):
        at_m, low_m, high_m = points_m[:, row, axis], boxes_m[:, column, 0, axis], boxes_m[:, column, 1, axis]
        met = ~((at_m < low_m).all(axis=0) | (at_m > high_m).all(axis=0))
        row, column = row[met], column[met]
    in_turn = np.lexsort((column, row))
    return row[in_turn], column[in_turn]


def boxes_of(corners_m: Array) -> Array:
    """Return the lowest and highest corners (m, 2, 3) of the boxes around triangles (m, 3, 3)."""
    return np.stack([corners_m.min(axis=1), corners_m.max(axis=1)], axis=1)


def height_m(corners_m: Array, triangle: Indices, place_m: Array) -> Array:
    """Return the heights (n,) of places (n, 3) over the planes of their own triangles; below is negative.

    ``triangle`` (n,) has the numbers of these triangles in ``corners_m`` (m, 3, 3).
    """
    first, second, third = (corners_m[:, k] for k in range(3))
    normal = np.cross(second - first, third - first)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    return np.asarray(np.einsum("nk,nk->n", normal[triangle], place_m - first[triangle]))
