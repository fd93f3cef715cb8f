"""The geometry that panel solvers, frames and the particles' surface share."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from orchestrator.ports import Array, Indices
from orchestrator.ports.drawn_openings import DrawnOpenings


@dataclass(frozen=True)
class Rectangle:
    """A flat rectangular panel and where it is mounted.

    Material coordinates (s, y) in m: s runs along the free length, 0 at the inner edge of the
    first clamp and ``length_m`` at the inner edge of the second, and goes ``clamp_m`` further
    under each clamp; y runs across, 0 ... ``width_m``.

    ``corner_m`` is the world position of (s, y) = (0, 0); ``along`` and ``across`` are unit
    vectors; ``along x across`` is the normal that points up, to the bed.  ``length_m`` is the
    stress-free length; the clamps' inner edges are mounted ``span_m`` apart: longer is
    stretched, shorter is slack.  ``clamp_angle_deg`` is the angle by which both clamps are turned about
    their inner edges: positive clamps point down into the panel's sag.
    """

    corner_m: Array
    along: Array
    across: Array
    length_m: float
    span_m: float
    width_m: float
    clamp_m: float
    clamp_angle_deg: float = 0.0

    @property
    def normal(self) -> Array:
        """The unit vector (3,) that points up, to the bed."""
        return np.cross(self.along, self.across)

    def mounted(self, coordinates_m: Array) -> Array:
        """Return the places (n, 3) of points of material coordinates (n, 2), or (n, 3) with an offset along
        the normal, with the panel straight between its clamps.  A slack panel is compressed to ``span_m``
        here; solvers find its sag."""
        s, y = coordinates_m[:, 0], coordinates_m[:, 1]
        free = np.clip(s, 0.0, self.length_m)
        beyond = s - free
        cosine, sine = self._clamp_turn
        x = free * (self.span_m / self.length_m) + cosine * beyond
        places_m = np.asarray(self.corner_m + np.outer(x, self.along) + np.outer(y, self.across))
        if sine:
            places_m = places_m + np.outer(sine * np.abs(beyond), self.normal)
        if coordinates_m.shape[1] == 3:
            places_m = places_m + coordinates_m[:, 2:] * self._normals(np.sign(beyond))
        return np.asarray(places_m)

    def corners_m(self, clamp_m: float = 0.0) -> Array:
        """Return the corners (4, 3), one after the other, of the straight panel and ``clamp_m`` beyond its
        ends."""
        first_m, last_m, across_m = -clamp_m, self.length_m + clamp_m, self.width_m
        around_m = [(first_m, 0.0), (last_m, 0.0), (last_m, across_m), (first_m, across_m)]
        return self.mounted(np.array(around_m))

    def _normals(self, clamp: Array) -> Array:
        """Return the normals (n, 3) of the straight panel: -1 in the first clamp, 0 between them, 1 in the
        second one, as ``clamp`` (n,) says."""
        cosine, sine = self._clamp_turn
        upright = np.where(clamp == 0.0, 1.0, cosine)
        return np.outer(upright, self.normal) - np.outer(sine * clamp, self.along)

    @property
    def clamp_tangents(self) -> Array:
        """The unit vectors (2, 3) along the panel in both clamps, in the direction of s."""
        cosine, sine = self._clamp_turn
        return np.stack([cosine * self.along - sine * self.normal, cosine * self.along + sine * self.normal])

    @property
    def _clamp_turn(self) -> tuple[float, float]:
        """The cosine and the sine of the clamps' angle."""
        angle_rad = math.radians(self.clamp_angle_deg)
        return math.cos(angle_rad), math.sin(angle_rad)

    def end(self, coordinates_m: Array) -> Array:
        """Tell which clamp holds points of material coordinates (n, 2): 0 the first, 1 the second, NaN none.

        The inner edges belong to the clamps.
        """
        s = coordinates_m[:, 0]
        slack = 1e-9 * self.length_m
        return np.where(s <= slack, 0.0, np.where(s >= self.length_m - slack, 1.0, np.nan))


@dataclass(frozen=True)
class AperturePattern:
    """A pattern of openings in a rectangular panel, in its material coordinates: equal ones, or drawn ones.

    Each opening stands in a cell of ``pitch_along_m`` by ``pitch_across_m``; as many whole cells
    as fit between the margins are centred on the panel.  A row of cells runs across; every second
    row is shifted across by ``stagger`` pitches and keeps the cells that still fit.
    ``shape``: "rectangle", or "slot" with round ends (a circle where both sides are equal).
    ``margin_share``: the share of the width that counts as solid for mass and stiffness although it has
    openings; a slice bears its part of the whole panel's margins in this way.
    ``depth_m``: the length of an opening from the upper to the lower side; 0 for a rim without depth.
    ``relief_deg``: the angle by which each wall leaves the normal, so that an opening widens downwards where
    it is positive.  Lengths and widths are those of the upper side.
    ``drawn``: openings with places and outlines of their own, whose ``shape`` is "polygon".  Lengths, widths
    and pitches are then means, and neither stagger nor margins along and across have a meaning.
    """

    shape: str
    length_m: float
    width_m: float
    pitch_along_m: float
    pitch_across_m: float
    stagger: float = 0.0
    margin_along_m: float = 0.0
    margin_across_m: float = 0.0
    margin_share: float = 0.0
    depth_m: float = 0.0
    relief_deg: float = 0.0
    drawn: DrawnOpenings | None = None

    def widening_m(self, below_m: float) -> float:
        """Return how far a wall has gone outwards so far below the upper side."""
        return below_m * math.tan(math.radians(self.relief_deg))

    def section(self, below_m: float) -> AperturePattern:
        """Return the pattern without depth that the openings have so far below the upper side."""
        if self.depth_m == 0.0:
            return self
        outwards_m = self.widening_m(below_m)
        return replace(
            self,
            length_m=self.length_m + 2 * outwards_m,
            width_m=self.width_m + 2 * outwards_m,
            depth_m=0.0,
            relief_deg=0.0,
            drawn=self.drawn.grown(outwards_m) if self.drawn and outwards_m else self.drawn,
        )

    @property
    def mean_section(self) -> AperturePattern:
        """The section half way down, whose area is the mean one but for a square of the relief."""
        return self.section(self.depth_m / 2)

    @property
    def narrowest_section(self) -> AperturePattern:
        """The section that decides what falls straight through."""
        return self.section(self.depth_m if self.relief_deg < 0 else 0.0)

    @property
    def land_m(self) -> float:
        """The least width of material between neighbours of a row or column, or between drawn openings."""
        if self.drawn:
            return self.drawn.land_m
        return min(self.pitch_along_m - self.length_m, self.pitch_across_m - self.width_m)

    @property
    def opening_m2(self) -> float:
        """The exact area of one opening, the mean one of drawn openings."""
        if self.drawn:
            return float(self.drawn.areas_m2.mean())
        round_m = min(self.length_m, self.width_m) if self.shape == "slot" else 0.0
        return self.length_m * self.width_m - (1 - math.pi / 4) * round_m**2

    @property
    def solid_share(self) -> float:
        """The material's share of a cell's area."""
        if self.drawn:
            return self.drawn.solid_share
        return 1.0 - self.opening_m2 / (self.pitch_along_m * self.pitch_across_m)

    def material_share(self, rectangle: Rectangle) -> float:
        """Return the material's share of the whole free panel's area."""
        region_m2 = (1.0 - self.margin_share) * float(np.ptp(self.region_m(rectangle), axis=0).prod())
        return 1.0 - (1.0 - self.solid_share) * region_m2 / (rectangle.length_m * rectangle.width_m)

    def counts(self, rectangle: Rectangle) -> tuple[int, int]:
        """Return the numbers of cells along and across; 0 where the margins leave no room."""
        along_m = rectangle.length_m - 2 * self.margin_along_m
        across_m = rectangle.width_m - 2 * self.margin_across_m
        whole = (along_m / self.pitch_along_m + 1e-6, across_m / self.pitch_across_m + 1e-6)
        return max(int(whole[0]), 0), max(int(whole[1]), 0)

    def region_m(self, rectangle: Rectangle) -> Array:
        """Return the lowest and highest (s, y) of the perforated region, (2, 2), which consists of whole
        cells."""
        if self.drawn:
            return self.drawn.region_m
        middle = np.array([rectangle.length_m, rectangle.width_m]) / 2
        half = np.multiply(self.counts(rectangle), (self.pitch_along_m, self.pitch_across_m)) / 2
        return np.stack([middle - half, middle + half])

    def centres_m(self, rectangle: Rectangle) -> Array:
        """Return the material coordinates (openings, 2) of the openings' centers, row by row or as drawn."""
        if self.drawn:
            return self.drawn.centres_m
        rows, columns = self.counts(rectangle)
        low, high = self.region_m(rectangle)
        row, column = (n.ravel() for n in np.mgrid[:rows, :columns])
        s = low[0] + (row + 0.5) * self.pitch_along_m
        y = low[1] + (column + 0.5 + self.stagger * (row % 2)) * self.pitch_across_m
        fits = y + 0.5 * self.pitch_across_m <= high[1] * (1 + 1e-9)
        return np.asarray(np.column_stack([s, y])[fits])

    @property
    def spheres_m(self) -> tuple[float, float]:
        """The diameters of the largest spheres that pass the narrowest and the widest opening."""
        if self.drawn:
            return self.drawn.spheres_m
        smaller_m = min(self.length_m, self.width_m)
        return smaller_m, smaller_m

    def half_sides_m(self) -> Array:
        """Return half the length and width (openings or 1, 2) of the boxes around the openings."""
        if self.drawn:
            return np.asarray(np.ptp(self.drawn.boxes_m, axis=1) / 2)
        return np.array([[self.length_m, self.width_m]]) / 2

    def outlines_m(self, rectangle: Rectangle) -> list[Array]:
        """Return all openings as polygons (corners, 2), anticlockwise, in the order of their centers."""
        if self.drawn:
            return [*self.drawn.corners_m]
        return [*(self.centres_m(rectangle)[:, None] + self.outline_m())]

    def outline_m(self) -> Array:
        """Return one opening as a polygon (corners, 2) about its center, anticlockwise.

        Round ends are inscribed polygons with the fewest corners that keep 98 % of the area.
        """
        a, b = self.length_m / 2, self.width_m / 2
        if self.shape == "rectangle":
            return np.array([[-a, -b], [a, -b], [a, b], [-a, b]])
        radius = min(a, b)
        pieces = 3  # of a half circle
        while _lost_m2(radius, pieces) > 0.02 * self.opening_m2:
            pieces += 1
        turn = np.linspace(-0.5, 0.5, pieces + 1) * np.pi + (0.0 if a >= b else np.pi / 2)
        end = radius * np.column_stack([np.cos(turn), np.sin(turn)])
        end += (a - radius, 0.0) if a >= b else (0.0, b - radius)
        both = np.vstack([end, -end])
        distinct = np.linalg.norm(both - np.roll(both, 1, axis=0), axis=1) > 1e-9 * radius
        return np.asarray(both[distinct])


def _lost_m2(radius_m: float, pieces: int) -> float:
    """Return the area of a circle less that of its inscribed polygon of 2 ``pieces`` sides."""
    return radius_m**2 * (math.pi - pieces * math.sin(math.pi / pieces))


@dataclass(frozen=True)
class RigidVertices:
    """The vertices of rigid surfaces: each moves as a fixed mean of the four points that carry its surface.

    The four are the corners of a tetrahedron around the surface, as ``tetrahedron_m`` makes it.  They move as
    the body does, and so the vertices do; what acts on a vertex acts, by the same shares, on the four points,
    with the same force, moment and power.  So a surface of any number of triangles crosses a port as four
    points.

    Parameters
    ----------
    first
        (v,) the number of the first of the four points, which follow one another.
    share
        (v, 3) the shares of the other three; the first has the rest.  None is negative.
    """

    first: Indices
    share: Array

    @staticmethod
    def none() -> RigidVertices:
        """Return the record of a surface without rigid parts."""
        return RigidVertices(np.empty(0, dtype=np.int64), np.empty((0, 3)))

    def at(self, points: Array, vertices: Indices | None = None) -> Array:
        """Return the values (..., 3) at vertices by their numbers (...), from those at the points (n, 3).

        The points are the first n vertices, and the rigid ones follow; by default all are returned.
        """
        if vertices is None:
            vertices = np.arange(len(points) + len(self.first))
        elif not len(self.first):
            return points[vertices]
        rigid = vertices >= len(points)
        values = np.empty((*vertices.shape, 3))
        values[~rigid] = points[vertices[~rigid]]
        own = vertices[rigid] - len(points)
        first, share = self.first[own], self.share[own]
        values[rigid] = (1.0 - share.sum(axis=1))[:, None] * points[first]
        for k in range(3):
            values[rigid] += share[:, k, None] * points[first + 1 + k]
        return values


def tetrahedron_m(position_m: Array) -> Array:
    """Return the corners (4, 3) of a tetrahedron around points (n, 3).

    Three equal edges leave the first corner along the axes.
    """
    low_m = position_m.min(axis=0)
    return np.asarray(low_m + (position_m.max(axis=0) - low_m).sum() * np.vstack([np.zeros(3), np.eye(3)]))


def shares_in(corners_m: Array, place_m: Array) -> Array:
    """Return the shares (n, 3) of a tetrahedron's other corners (4, 3) in places (n, 3), as ``RigidVertices``
    has them; outside some are negative."""
    edges_m = (corners_m[1:] - corners_m[0]).T
    return np.asarray(np.linalg.solve(edges_m, (place_m - corners_m[0]).T).T)


UPPER, WALL, LOWER = 1, 0, -1


@dataclass(frozen=True)
class TriangleSurface:
    """The surface that particles touch; its triangles are two-sided.

    Parameters
    ----------
    position_m
        (n, 3) of the points that move, at t = 0; points that no triangle uses (probes) are allowed.
    triangles
        (m, 3) numbers of vertices: the points, then the vertices of rigid surfaces.  The corners of a
        triangle are of one kind.
    material
        (m,) the index of each triangle's material.
    panel
        (m,) the number of each triangle's panel, -1 for walls; None without panels.  The normals of a panel's
        triangles point to its upper side, or out of its material where openings have a depth.
    rigid
        The vertices of rigid surfaces.
    side
        (m,) the side of its panel that each triangle is on: ``UPPER``, ``WALL`` (of an opening, or the
        panel's edge) or ``LOWER``; None where all are upper ones, because no panel has a depth.
    """

    position_m: Array
    triangles: Indices
    material: Indices
    panel: Indices | None = None
    rigid: RigidVertices = field(default_factory=RigidVertices.none)
    side: Indices | None = None

    @property
    def on_deck(self) -> npt.NDArray[np.bool_]:
        """Tell which triangles (m,) are a panel's upper side or a wall: who touches the others is below."""
        if self.panel is None:
            return np.zeros(len(self.triangles), dtype=bool)
        above = self.panel >= 0
        return above if self.side is None else np.asarray(above & (self.side != LOWER))

    @property
    def floor(self) -> Indices:
        """The triangles (k, 3), with normals that point up, below which a particle has left the panels.

        They are those of panels without depth, and the lower sides of the others, turned over: who is in an
        opening has not left it.
        """
        if self.panel is None:
            return self.triangles[:0]
        if self.side is None:
            return self.triangles[self.panel >= 0]
        deep = np.unique(self.panel[self.side == LOWER])
        thin = (self.panel >= 0) & ~np.isin(self.panel, deep)
        return np.concatenate([self.triangles[thin], self.triangles[self.side == LOWER][:, ::-1]])

    @cached_property
    def vertices_m(self) -> Array:
        """The places (vertices, 3) of all vertices at t = 0."""
        return self.rigid.at(self.position_m)

    @property
    def corners_m(self) -> Array:
        """The corners (m, 3, 3) of all triangles at t = 0."""
        return np.asarray(self.vertices_m[self.triangles])


def area_vectors_m2(corners_m: Array) -> Array:
    """Return the area vectors (m, 3) of triangles (m, 3, 3), along their normals."""
    first_m, second_m, third_m = (corners_m[:, k] for k in range(3))
    return np.asarray(np.cross(second_m - first_m, third_m - first_m) / 2)


@dataclass(frozen=True)
class Foot:
    """The feet of perpendiculars from points onto the planes of triangles.

    Parameters
    ----------
    height_m
        (n,) of the points, positive on the side of the triangles' normals.
    normal
        (n, 3) the triangles' unit normals.
    share
        (n, 3) of the three corners in the foot; they add up to one, and none is negative inside.
    """

    height_m: Array
    normal: Array
    share: Array


def foot_on_triangle(corners_m: Array, place_m: Array) -> Foot:
    """Return the foot of each point (n, 3) on the plane of its own triangle (n, 3, 3)."""
    first, second, third = (corners_m[:, k] for k in range(3))
    edges_m = np.stack([second - first, third - first], axis=1)
    normal = np.cross(edges_m[:, 0], edges_m[:, 1])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    from_first_m = place_m - first
    squares_m2 = np.einsum("nek,nfk->nef", edges_m, edges_m)
    along_edges_m2 = np.einsum("nek,nk->ne", edges_m, from_first_m)
    moved = np.linalg.solve(squares_m2, along_edges_m2[:, :, None])[:, :, 0]
    share = np.column_stack([1.0 - moved.sum(axis=1), moved])
    return Foot(np.einsum("nk,nk->n", normal, from_first_m), normal, share)


def closest_on_triangle(point_m: Array, corners_m: Array) -> Array:
    """Return barycentric weights (n, 3) of the point of triangle i closest to ``point_m`` i.

    ``point_m`` (n, 3), ``corners_m`` (n, 3, 3).  Ericson, C., Real-Time Collision Detection,
    Morgan Kaufmann 2005, section 5.1.5: the seven regions of a triangle, all points at once.
    """
    a = corners_m[:, 0]
    ab, ac, ap = corners_m[:, 1] - a, corners_m[:, 2] - a, point_m - a
    abab, abac, acac = _products(ab, ab), _products(ab, ac), _products(ac, ac)
    d1, d2 = _products(ab, ap), _products(ac, ap)
    d3, d4, d5, d6 = d1 - abab, d2 - abac, d1 - abac, d2 - acac
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    inside = va + vb + vc  # four times the squared area
    on_ab, on_ac = d1 / abab, d2 / acac
    on_bc = (d4 - d3) / (abab - 2.0 * abac + acac)
    regions = [
        (d1 <= 0) & (d2 <= 0),  # corner a
        (d3 >= 0) & (d4 <= d3),  # corner b
        (d6 >= 0) & (d5 <= d6),  # corner c
        (vc <= 0) & (d1 >= 0) & (d3 <= 0),  # edge ab
        (vb <= 0) & (d2 >= 0) & (d6 <= 0),  # edge ac
        (va <= 0) & (d4 >= d3) & (d5 >= d6),  # edge bc
    ]
    weights = np.stack([va, vb, vc]) / inside
    places = [
        (1.0, 0.0, 0.0),
        (0.0, 1.0, 0.0),
        (0.0, 0.0, 1.0),
        (1.0 - on_ab, on_ab, 0.0),
        (1.0 - on_ac, 0.0, on_ac),
        (0.0, 1.0 - on_bc, on_bc),
    ]
    for region, place in zip(reversed(regions), reversed(places), strict=True):
        for weight, value in zip(weights, place, strict=True):
            np.copyto(weight, value, where=region)
    return np.asarray(weights.T)


def _products(a: Array, b: Array) -> Array:
    return np.asarray(np.einsum("ij,ij->i", a, b))


@dataclass(frozen=True)
class Edges:
    """Edges of a triangulation: pairs of points (n, 2), and their lengths (n,)."""

    points: Indices
    length_m: Array

    @staticmethod
    def of(coordinates_m: Array, triangles: Indices) -> Edges:
        """Return the edges of triangles (m, 3), each once."""
        all_of_them = triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
        points = np.unique(np.sort(all_of_them, axis=1), axis=0)
        ends_m = coordinates_m[points]
        return Edges(points, np.linalg.norm(ends_m[:, 1] - ends_m[:, 0], axis=1))


TOUCHING = 1e-9  # of a box's size: rounding where a triangle stands against its side


def overlap_m(position_m: Array, radius_m: Array, corners_m: Array) -> Array:
    """Return the overlaps (n,) of spheres, (n, 3) and (n,), with the nearest of the triangles (m, 3, 3); zero
    for spheres that overlap none."""
    deepest_m = np.zeros(len(position_m))
    sphere, from_surface_m = contact_points(position_m, radius_m, corners_m)
    depth_m = radius_m[sphere] - np.linalg.norm(from_surface_m, axis=1)
    np.maximum.at(deepest_m, sphere, depth_m)
    return deepest_m


def contact_points(position_m: Array, radius_m: Array, corners_m: Array) -> tuple[Indices, Array]:
    """Return the contacts of spheres, (n, 3) and (n,), with triangles (m, 3, 3).

    Each contact has the number of its sphere, (contacts,), and the vector from the nearest point of the
    triangle to the sphere's centre, (contacts, 3).
    """
    from scipy.spatial import cKDTree

    nothing = np.empty(0, dtype=np.int64), np.empty((0, 3))
    if not len(position_m) or not len(corners_m):
        return nothing
    largest_m = radius_m.max()
    low_m, high_m = corners_m.min(axis=(0, 1)) - largest_m, corners_m.max(axis=(0, 1)) + largest_m
    close = np.flatnonzero(((position_m >= low_m) & (position_m <= high_m)).all(axis=1))
    if not len(close):
        return nothing
    low_m, high_m = position_m[close].min(axis=0) - largest_m, position_m[close].max(axis=0) + largest_m
    beside = (corners_m.max(axis=1) < low_m) | (corners_m.min(axis=1) > high_m)
    corners_m = corners_m[~beside.any(axis=1)]
    if not len(corners_m):
        return nothing
    center_m = corners_m.mean(axis=1)
    reach_m = np.linalg.norm(corners_m - center_m[:, None], axis=2).max(axis=1) + largest_m
    near = cKDTree(position_m[close]).query_ball_point(center_m, reach_m)
    triangle = np.repeat(np.arange(len(corners_m)), [len(some) for some in near])
    sphere = close[np.concatenate([np.array(some, dtype=np.int64) for some in near])]
    place_m, corners_m = position_m[sphere], corners_m[triangle]
    nearest_m = np.einsum("ij,ijk->ik", closest_on_triangle(place_m, corners_m), corners_m)
    from_surface_m = place_m - nearest_m
    touching = np.linalg.norm(from_surface_m, axis=1) < radius_m[sphere]
    return sphere[touching], from_surface_m[touching]


def distinct_edges(triangles: Indices) -> tuple[Indices, Indices, Indices]:
    """Return the edges (edges, 2) of triangles (m, 3), each once with the lower number first, and in order.

    Return also the numbers (3 m,) of the edges of all triangles, from the first corner to the second on, and
    how many triangles share each edge (edges,).
    """
    ends = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    size = int(triangles.max(initial=0)) + 1
    key, number, sharing = np.unique(ends @ [size, 1], return_inverse=True, return_counts=True)
    return np.column_stack(np.divmod(key, size)), number.reshape(-1), sharing


def reach_into(corners_m: Array, box_m: Array) -> npt.NDArray[np.bool_]:
    """Tell which (m,) of the triangles (m, 3, 3) reach into a box (2, 3: lowest and highest corner).

    Two convex bodies are apart if one of these directions parts them: the normals of both and the
    products of their edges (Akenine-Moeller, T., Journal of Graphics Tools 6, 2001, 29-33,
    doi:10.1080/10867651.2001.10487535).
    """
    half_m = (box_m[1] - box_m[0]) / 2
    corners_m = (corners_m - box_m.mean(axis=0)) / half_m.max()  # sizes about one
    half = half_m / half_m.max()
    edges = np.roll(corners_m, -1, axis=1) - corners_m
    sides = np.broadcast_to(np.eye(3), (len(corners_m), 3, 3))
    normal = np.cross(edges[:, 0], edges[:, 1])[:, None]
    products = np.cross(edges[:, :, None], np.eye(3)).reshape(-1, 9, 3)
    directions = np.concatenate([sides, normal, products], axis=1)
    length = np.linalg.norm(directions, axis=2)
    reached = np.einsum("mdk,mck->mdc", directions, corners_m)
    box = np.abs(directions) @ half - TOUCHING * length
    apart = (reached.min(axis=2) > box) | (reached.max(axis=2) < -box)
    return np.asarray(~(apart & (length > 0.0)).any(axis=1))
