"""Search for panels that have gone through a rigid surface or through another panel.

Particles touch panels and surfaces; these do not touch each other, so that nothing holds a panel
that sags, or is thrown, through a plate.  Here it is found, from where everything is drawn (panels
straight between their clamps) and where everything is now.

A point of the panel has gone through a triangle when it was on one side of it as drawn and is on
the other side now, and when the straight way between the two places, as the triangle itself sees
it, leads through the triangle.  So neither joint motion nor motion along a surface counts, and a
panel that is drawn through a surface, or in its plane, is taken as meant; the preflight refuses
plates in the plane of a panel.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from orchestrator.ports import Array, Indices
from orchestrator.ports.geometry import foot_on_triangle

IN_PLANE = 1e-3  # of its thickness: a panel drawn nearer to a surface's plane is on neither side
FAR = 20  # thicknesses: pairs are not listed for longer motions, since they would be too many
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


class ListedPairs(NamedTuple):
    """Pairs (k,) of a point of a panel and a triangle that may meet before the next list.

    ``panel`` has the panels' numbers, and ``ends`` (k, 2) the points whose middles are looked at.
    ``triangles`` (m,) has the numbers of all triangles, and ``of_pair`` the place of each pair's own one
    among these; over its plane the point was drawn at the height ``was_m``.
    """

    panel: Indices
    ends: Indices
    triangles: Indices
    of_pair: Indices
    was_m: Array


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
        self._thickness_m = np.array([panel.thickness_m for panel in panels])
        self._listed_m, self._skin_m = drawn_m, np.full(3, -1.0)  # so that the first search makes a list

    def deepest(self, position_m: Array) -> Penetration | None:
        """Return the deepest penetration with the points at ``position_m`` (n, 3); None without any.

        The pairs of points and triangles that may have met are listed with a skin, and listed anew when a
        point has moved along an axis by more than the skin since (Verlet's lists).
        """
        moved_m = np.abs(position_m - self._listed_m).max(axis=0, initial=0.0)
        if (moved_m > self._skin_m).any():
            self._list_pairs(position_m, moved_m)
        pairs = self._pairs
        corners = self._triangles[pairs.triangles]
        is_m = height_m(position_m[corners], pairs.of_pair, middles_m(pairs.ends, position_m))
        crossed = np.flatnonzero(pairs.was_m * is_m < 0.0)
        if not len(crossed):
            return None
        was_m, is_m, panel = pairs.was_m[crossed], is_m[crossed], pairs.panel[crossed]
        triangle, corners = pairs.triangles[pairs.of_pair[crossed]], corners[pairs.of_pair[crossed]]
        points_m = [middles_m(pairs.ends[crossed], at_m) for at_m in (self._drawn_m, position_m)]
        corners_m = [at_m[corners] for at_m in (self._drawn_m, position_m)]
        beyond = are_beyond(
            np.stack([points_m] * 2, axis=2), np.stack([boxes_of(each) for each in corners_m])
        )
        before, after = (foot_on_triangle(*each).share for each in zip(corners_m, points_m, strict=True))
        on_plane = before + (was_m / (was_m - is_m))[:, None] * (after - before)
        through = np.flatnonzero(~beyond & (on_plane >= -ON_RIM).all(axis=1))
        if not len(through):
            return None
        thicknesses = np.abs(is_m) / self._thickness_m[panel]
        deepest = through[np.argmax(thicknesses[through])]
        name = self._bodies[self._panels[panel[deepest]].body].name
        surface = self._bodies[self._body[triangle[deepest]]].name
        return Penetration(name, surface, float(abs(is_m[deepest])), float(thicknesses[deepest]))

    def _list_pairs(self, position_m: Array, moved_m: Array) -> None:
        """List the pairs that may meet before a point has moved by more than a new skin.

        The skin is twice the motion ``moved_m`` (3,) since the last list and the smallest thickness of a
        panel, or nothing along an axis on which that would be far.
        """
        least_m = self._thickness_m.min(initial=np.inf)
        skin_m = 2 * moved_m + least_m
        self._listed_m, self._skin_m = position_m.copy(), np.where(skin_m > FAR * least_m, 0.0, skin_m)
        around_m = 2.001 * np.outer([-1, 1], self._skin_m)  # both move; more than twice, for rounding
        boxes_m = np.stack([self._drawn_boxes_m, self._boxes_of_bodies(position_m) + around_m])
        none = np.empty((0, 2), dtype=np.int64), np.empty(0, dtype=np.int64)
        near = [self._near(panel, position_m, boxes_m, around_m) for panel in self._panels]
        number = np.repeat(np.arange(len(near)), [len(triangle) for _, triangle in near])
        ends, triangle = (np.concatenate(each) for each in zip(none, *near, strict=True))
        triangles, of_pair = np.unique(triangle, return_inverse=True)
        was_m = height_m(self._drawn_m[self._triangles[triangles]], of_pair, middles_m(ends, self._drawn_m))
        beside = np.abs(was_m) > IN_PLANE * self._thickness_m[number]
        self._pairs = ListedPairs(number[beside], ends[beside], triangles, of_pair[beside], was_m[beside])

    def _boxes_of_bodies(self, position_m: Array) -> Array:
        """Return the lowest and highest corners (bodies, 2, 3) of the boxes around all bodies; of NaN
        around a body without triangles."""
        boxes_m = np.full((len(self._bodies), 2, 3), np.nan)
        for box_m, points in zip(boxes_m, self._points, strict=True):
            if len(points):
                box_m[:] = position_m[points].min(axis=0), position_m[points].max(axis=0)
        return boxes_m

    def _near(
        self, panel: ProbedPanel, position_m: Array, boxes_m: Array, around_m: Array
    ) -> tuple[Indices, Indices]:
        """Return the ends (k, 2) of a panel's points and the triangles (k,) through which they may go.

        ``boxes_m`` (2, bodies, 2, 3) are the boxes around all bodies, as drawn and now; ``around_m`` (2, 3)
        is added to the boxes around the triangles now.  What is beyond the same side of a box before and
        after was beyond it all the way: so whole bodies drop out first, then triangles, then single points.
        """
        if not len(panel.pairs):
            return panel.pairs, np.empty(0, dtype=np.int64)
        points_m = np.stack([middles_m(panel.pairs, at_m) for at_m in (self._drawn_m, position_m)])
        panel_m = np.stack([points_m.min(axis=1), points_m.max(axis=1)], axis=1)[:, None]
        bodies = ~are_beyond(panel_m, boxes_m)
        bodies[panel.body] = False
        triangles = np.flatnonzero(bodies[self._body])
        corners = self._triangles[triangles]
        boxes_m = np.stack([self._drawn_triangles_m[triangles], boxes_of(position_m[corners]) + around_m])
        met = ~are_beyond(panel_m, boxes_m)
        row, column = pairs_that_meet(points_m, boxes_m[:, met])
        return panel.pairs[row], triangles[met][column]


def middles_m(pairs: Indices, position_m: Array) -> Array:
    """Return the middles (k, 3) of pairs (k, 2) of points; all points are at ``position_m`` (n, 3)."""
    first, second = position_m[pairs[:, 0]], position_m[pairs[:, 1]]
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
