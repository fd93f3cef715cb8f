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
        self._drawn_boxes_m = boxes_of(drawn_m[self._triangles])

    def deepest(self, position_m: Array) -> Penetration | None:
        """Return the deepest penetration with the points at ``position_m`` (n, 3); None without any."""
        boxes_m = np.stack([self._drawn_boxes_m, boxes_of(position_m[self._triangles])])
        deepest = (self._deepest_of(panel, position_m, boxes_m) for panel in self._panels)
        return max(filter(None, deepest), key=lambda each: each.thicknesses, default=None)

    def _deepest_of(self, panel: ProbedPanel, position_m: Array, boxes_m: Array) -> Penetration | None:
        """Return the deepest penetration of one panel; None without any."""
        drawn_m, now_m = (points[panel.pairs].mean(axis=1) for points in (self._drawn_m, position_m))
        row, triangle = self._near(panel, drawn_m, now_m, boxes_m)
        was_m, is_m = (
            height_m(points[self._triangles], triangle, place_m[row])
            for points, place_m in ((self._drawn_m, drawn_m), (position_m, now_m))
        )
        crossed = (was_m * is_m < 0.0) & (np.abs(was_m) > IN_PLANE * panel.thickness_m)
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
        self, panel: ProbedPanel, drawn_m: Array, now_m: Array, boxes_m: Array
    ) -> tuple[Indices, Indices]:
        """Return pairs of a point (row) and a triangle (number) that the point may have gone through.

        On no axis is such a point beyond the same side of the triangle's box before and after, since it would
        then be beyond it all the way.  ``boxes_m`` (2, m, 2, 3) has the lowest and highest corners of all
        triangles as drawn and now.
        """
        points_m = np.stack([drawn_m, now_m])  # (2, n, 3)
        others = np.flatnonzero(self._body != panel.body)
        if not len(now_m) or not len(others):
            return np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)
        low_m, high_m = points_m.min(axis=1), points_m.max(axis=1)
        below = high_m[:, None] < boxes_m[:, others, 0]
        above = low_m[:, None] > boxes_m[:, others, 1]
        others = others[~(below.all(axis=0) | above.all(axis=0)).any(axis=1)]
        apart = np.zeros((len(now_m), len(others)), dtype=bool)
        for axis in range(3):
            places_m = points_m[:, :, None, axis]
            box_m = boxes_m[:, others][..., axis]
            apart |= (places_m < box_m[:, None, :, 0]).all(axis=0)
            apart |= (places_m > box_m[:, None, :, 1]).all(axis=0)
        row, column = np.nonzero(~apart)
        return row, others[column]


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
