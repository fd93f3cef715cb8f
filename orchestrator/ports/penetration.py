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
from itertools import chain
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from orchestrator.ports import Array, Indices
from orchestrator.ports.geometry import RigidVertices, area_vectors_m2, foot_on_triangle, shares_in

IN_PLANE = 1e-3  # of its thickness: a panel drawn nearer to a surface's plane is on neither side
FAR = 20  # thicknesses: pairs are not listed for longer motions, since they would be too many
NEARLY = 0.999  # of a distance: more is rounding
NO_RIGID = RigidVertices.none()
ROUNDING_M = 1e-9  # of places of some metres
ON_RIM = 1e-9  # share of a corner: rounding on an edge that two triangles share


@dataclass(frozen=True)
class SurfaceBody:
    """A panel or a rigid surface with its ``triangles`` (m, 3) of vertex numbers."""

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


class Pairs(NamedTuple):
    """Pairs (k,) of a point of a panel and a triangle.

    ``panel``, ``ends`` (k, 2: the points whose middles are looked at) and ``triangle`` are numbers.  Over the
    triangle's plane the point was drawn at the height ``was_m``.
    """

    panel: Indices
    ends: Indices
    triangle: Indices
    was_m: Array

    def part(self, pairs: Indices | npt.NDArray[np.bool_]) -> Pairs:
        """Return some of the pairs."""
        return Pairs(self.panel[pairs], self.ends[pairs], self.triangle[pairs], self.was_m[pairs])


class MovingPairs:
    """Listed pairs whose triangles have points of their own, with the ``corners`` (k, 3) of these."""

    def __init__(self, pairs: Pairs, corners: Indices) -> None:
        self._pairs = pairs
        _, first, self._of_pair = np.unique(pairs.triangle, return_index=True, return_inverse=True)
        self._corners = corners[first]

    def crossed(self, position_m: Array) -> Pairs:
        """Return the pairs whose point is on the other side of the plane with all points at (n, 3)."""
        place_m = middles_m(self._pairs.ends, position_m)
        is_m = height_m(position_m[self._corners], self._of_pair, place_m)
        return self._pairs.part(np.flatnonzero(self._pairs.was_m * is_m < 0.0))


class RigidPairs:
    """Listed pairs whose triangles belong to one rigid surface, in whose own axes their planes stand still.

    There a point crosses no plane before it has moved by its least height over them, so that the heights of
    few points are computed anew.  ``first`` is the number of the four points that carry the surface, whose
    edges are ``edge_m`` long, and ``shares`` (k, 3, 3) are those of the triangles' corners.
    """

    def __init__(self, pairs: Pairs, first: int, edge_m: float, shares: Array) -> None:
        key = pairs.ends @ [1 + pairs.ends.max(), 1]  # ten times faster than by rows
        _, which, row = np.unique(key, return_index=True, return_inverse=True)
        order = np.argsort(row, kind="stable")
        self._ends, self._pairs, self._row = pairs.ends[which], pairs.part(order), row[order]
        corners_m = edge_m * shares[order]
        self._carriers, self._edge_m = slice(first, first + 4), edge_m
        normal = area_vectors_m2(corners_m)
        self._normal = normal / np.linalg.norm(normal, axis=1)[:, None]
        self._at_m = np.einsum("nk,nk->n", self._normal, corners_m[:, 0])
        self._crossed = np.zeros(len(row), dtype=np.bool_)
        self._seen_m, self._free_m = np.zeros((len(self._ends), 3)), np.full(len(self._ends), -1.0)

    def crossed(self, position_m: Array) -> Pairs:
        """Return the pairs whose point is on the other side of the plane with all points at (n, 3)."""
        place_m = middles_m(self._ends, position_m)
        own_m = self._edge_m * shares_in(position_m[self._carriers], place_m)
        due = np.linalg.norm(own_m - self._seen_m, axis=1) > self._free_m
        if due.any():
            pairs = np.flatnonzero(due[self._row])
            row = self._row[pairs]
            is_m = np.einsum("nk,nk->n", self._normal[pairs], own_m[row]) - self._at_m[pairs]
            self._crossed[pairs] = self._pairs.was_m[pairs] * is_m < 0.0
            starts = np.flatnonzero(np.diff(row, prepend=-1))
            self._free_m[due] = NEARLY * np.minimum.reduceat(np.abs(is_m), starts)
            self._seen_m[due] = own_m[due]
        return self._pairs.part(np.flatnonzero(self._crossed))


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
    rigid
        The vertices of rigid surfaces, whose numbers follow those of the points.
    """

    def __init__(
        self,
        drawn_m: Array,
        bodies: Sequence[SurfaceBody],
        panels: Sequence[ProbedPanel],
        rigid: RigidVertices = NO_RIGID,
    ) -> None:
        self._bodies, self._panels = tuple(bodies), tuple(panels)
        self._drawn_m, self._rigid = drawn_m, rigid
        nothing = np.empty((0, 3), dtype=np.int64)
        self._triangles = np.concatenate([nothing, *(body.triangles for body in bodies)])
        counts = [len(body.triangles) for body in bodies]
        self._body = np.repeat(np.arange(len(counts)), counts)
        self._points = [np.unique(body.triangles) for body in bodies]
        vertices_m = rigid.at(drawn_m)
        carriers = np.concatenate([np.full(len(drawn_m), -1), rigid.first])
        self._carrier = carriers[self._triangles[:, 0]]  # of each triangle: its first of four points, or -1
        self._drawn_boxes_m = self._boxes_of_bodies(vertices_m)
        self._drawn_triangles_m = boxes_of(vertices_m[self._triangles])
        self._thickness_m = np.array([panel.thickness_m for panel in panels])
        self._pairs: list[MovingPairs | RigidPairs] = []
        self._listed_m, self._skin_m = drawn_m, np.full(3, -1.0)  # so that the first search makes a list

    def deepest(self, position_m: Array) -> Penetration | None:
        """Return the deepest penetration with the points at ``position_m`` (n, 3); None without any.

        The pairs of points and triangles that may have met are listed with a skin, and listed anew when a
        point has moved along an axis by more than the skin since (Verlet's lists).
        """
        moved_m = np.abs(position_m - self._listed_m).max(axis=0, initial=0.0)
        if (moved_m > self._skin_m).any():
            is_first = self._skin_m < 0.0  # then it is no motion: the panels sag since they were drawn
            self._list_pairs(position_m, np.where(is_first, 0.0, moved_m))
        crossed = _joined([pairs.crossed(position_m) for pairs in self._pairs])
        if not len(crossed.panel):
            return None
        panel, triangle, was_m = crossed.panel, crossed.triangle, crossed.was_m
        corners = self._triangles[triangle]
        points_m = [middles_m(crossed.ends, at_m) for at_m in (self._drawn_m, position_m)]
        corners_m = [self._rigid.at(at_m, corners) for at_m in (self._drawn_m, position_m)]
        beyond = are_beyond(
            np.stack([points_m] * 2, axis=2), np.stack([boxes_of(each) for each in corners_m])
        )
        feet = [foot_on_triangle(*each) for each in zip(corners_m, points_m, strict=True)]
        (before, after), is_m = (foot.share for foot in feet), feet[1].height_m
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
        vertices_m = self._rigid.at(position_m)
        boxes_m = np.stack([self._drawn_boxes_m, self._boxes_of_bodies(vertices_m) + around_m])
        none = np.empty((0, 2), dtype=np.int64), np.empty(0, dtype=np.int64)
        near = [self._near(panel, vertices_m, boxes_m, around_m) for panel in self._panels]
        number = np.repeat(np.arange(len(near)), [len(triangle) for _, triangle in near])
        ends, triangle = (np.concatenate(each) for each in zip(none, *near, strict=True))
        triangles, of_pair = np.unique(triangle, return_inverse=True)
        drawn_m = self._rigid.at(self._drawn_m, self._triangles[triangles])
        was_m = height_m(drawn_m, of_pair, middles_m(ends, self._drawn_m))
        beside = np.abs(was_m) > IN_PLANE * self._thickness_m[number]
        listed = Pairs(number, ends, triangle, was_m).part(beside)
        carrier = self._carrier[listed.triangle]
        moving = listed.part(carrier < 0)
        self._pairs = [MovingPairs(moving, self._triangles[moving.triangle])]
        self._pairs += [
            self._on_rigid(listed.part(carrier == first), first) for first in np.unique(carrier[carrier >= 0])
        ]

    def _on_rigid(self, pairs: Pairs, first: int) -> RigidPairs:
        edge_m = float(np.linalg.norm(self._drawn_m[first + 1] - self._drawn_m[first]))
        vertices = self._triangles[pairs.triangle] - len(self._drawn_m)
        return RigidPairs(pairs, first, edge_m, self._rigid.share[vertices])

    def _boxes_of_bodies(self, vertices_m: Array) -> Array:
        """Return the lowest and highest corners (bodies, 2, 3) of the boxes around all bodies; of NaN
        around a body without triangles."""
        boxes_m = np.full((len(self._bodies), 2, 3), np.nan)
        for box_m, points in zip(boxes_m, self._points, strict=True):
            if len(points):
                box_m[:] = vertices_m[points].min(axis=0), vertices_m[points].max(axis=0)
        return boxes_m

    def _near(
        self, panel: ProbedPanel, vertices_m: Array, boxes_m: Array, around_m: Array
    ) -> tuple[Indices, Indices]:
        """Return the ends (k, 2) of a panel's points and the triangles (k,) through which they may go.

        ``boxes_m`` (2, bodies, 2, 3) are the boxes around all bodies, as drawn and now; ``around_m`` (2, 3)
        is added to the boxes around the triangles now.  What is beyond the same side of a box before and
        after was beyond it all the way: so whole bodies drop out first, then triangles, then single points.
        """
        if not len(panel.pairs):
            return panel.pairs, np.empty(0, dtype=np.int64)
        points_m = np.stack([middles_m(panel.pairs, at_m) for at_m in (self._drawn_m, vertices_m)])
        panel_m = np.stack([points_m.min(axis=1), points_m.max(axis=1)], axis=1)[:, None]
        bodies = ~are_beyond(panel_m, boxes_m)
        bodies[panel.body] = False
        triangles = np.flatnonzero(bodies[self._body])
        corners = self._triangles[triangles]
        boxes_m = np.stack([self._drawn_triangles_m[triangles], boxes_of(vertices_m[corners]) + around_m])
        met = ~are_beyond(panel_m, boxes_m)
        row, column = pairs_that_meet(points_m, boxes_m[:, met])
        return panel.pairs[row], triangles[met][column]


def _joined(parts: Sequence[Pairs]) -> Pairs:
    """Return all pairs."""
    return Pairs(*(np.concatenate(each) for each in zip(*parts, strict=True)))


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

    The pairs are in the order of points, then of boxes.  Cubes around the ways of both give those that may
    meet; then all axes are compared.
    """
    from scipy.spatial import cKDTree

    box_m = np.stack([boxes_m[:, :, 0].min(axis=0), boxes_m[:, :, 1].max(axis=0)])
    if not boxes_m.shape[1]:
        return np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)
    half_m = (np.ptp(box_m, axis=0) + np.abs(points_m[0] - points_m[1]).max(axis=0)) / 2
    unit_m = np.median(half_m, axis=0) + ROUNDING_M  # by which most boxes are cubes
    tree = cKDTree(points_m.mean(axis=0) / unit_m)
    reach = (half_m / unit_m).max(axis=1) + ON_RIM
    near = tree.query_ball_point(box_m.mean(axis=0) / unit_m, reach, p=np.inf, return_sorted=False)
    column = np.repeat(np.arange(len(near)), np.fromiter(map(len, near), np.int64, len(near)))
    row = np.fromiter(chain.from_iterable(near), np.int64, len(column))
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
    normal = area_vectors_m2(corners_m)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    return np.asarray(np.einsum("nk,nk->n", normal[triangle], place_m - corners_m[triangle, 0]))
