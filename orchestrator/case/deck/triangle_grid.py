"""The triangles that particles touch on each panel, in material coordinates.

gmsh meshes panels with openings (C. Geuzaine, J.-F. Remacle, Int. J. Numer. Meth. Engng 79 (2009)
1309-1331, doi 10.1002/nme.2579).  The openings' outlines are edges of triangles.  gmsh makes a
constrained Delaunay triangulation of the given points and adds no others, because a run with fewer
triangles is faster.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from orchestrator.case.deck.panels import single_panels
from orchestrator.case.tables.case import Case, has_particles
from orchestrator.ports import Array, Indices
from orchestrator.ports.drawn_openings import area_m2, outwards
from orchestrator.ports.geometry import LOWER, UPPER, WALL, AperturePattern, Rectangle
from orchestrator.ports.meshing import closed_line, gmsh_session, made_triangles


@dataclass(frozen=True)
class TriangleGrid:
    """The triangles over a panel, in material coordinates.

    ``coordinates_m`` (n, 2) are the points, or (n, 3) with their offsets along the panel's normal, as
    ``MeshedPanel.interpolation`` takes them.  ``triangles`` (m, 3) have normals towards the bed, or out of
    the panel's material where openings have a depth; ``side`` (m,) then says on which side of the panel each
    one is (``TriangleSurface.side``).  ``centre_line`` has the numbers of the points nearest to the middle of
    the width, in their order along the panel.
    """

    coordinates_m: Array
    triangles: Indices
    centre_line: Indices
    side: Indices | None = None


def grid(rectangle: Rectangle, cells: tuple[int, int]) -> TriangleGrid:
    """Return a regular grid of right triangles over the free length and under both clamps.

    ``cells`` are the numbers of rectangles along the free length and across; each is cut into two
    triangles.  The diagonals alternate, so that the panel has no preferred direction.
    """
    across = cells[1]
    s = _rows_m(rectangle, cells[0])
    y = np.linspace(0.0, rectangle.width_m, across + 1)
    rows = len(y)
    number = np.arange(len(s) * rows).reshape(len(s), rows)
    a, b, c, d = (n.ravel() for n in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]))
    even = (np.add.outer(np.arange(len(s) - 1), np.arange(across)) % 2 == 0).ravel()
    first = np.where(even[:, None], np.column_stack([a, b, c]), np.column_stack([a, b, d]))
    second = np.where(even[:, None], np.column_stack([a, c, d]), np.column_stack([b, c, d]))
    coordinates = np.column_stack([np.repeat(s, rows), np.tile(y, len(s))])
    return TriangleGrid(coordinates, np.vstack([first, second]).astype(np.int64), number[:, rows // 2])


def _rows_m(rectangle: Rectangle, along: int) -> Array:
    """Return the ends of ``along`` equal pieces of the free length, and the ends of clamps with a depth."""
    free = np.linspace(0.0, rectangle.length_m, along + 1)
    clamps = [rectangle.clamp_m] if rectangle.clamp_m > 0 else []
    return np.concatenate([[-c for c in clamps], free, [rectangle.length_m + c for c in clamps]])


REMEMBERED = 32  # shapes of panels: more than a case has
GIVEN_POINTS_ONLY = 3  # This value of gmsh's Mesh.Algorithm means "initial mesh only".
SMALLEST_ANGLE_DEG = 1.0
ON_OUTLINE = 1e-9  # of an opening's half side: rounding of points on its outline


class BadMesh(ValueError):
    """An error for triangles that are too thin, or that do not cover the panel's material."""


@dataclass(frozen=True)
class Quality:
    """The quality of a grid: the smallest angle, the longest edge and the area of its triangles."""

    least_angle_deg: float
    longest_m: float
    covered_m2: float


def perforated_grid(rectangle: Rectangle, apertures: AperturePattern, cells: tuple[int, int]) -> TriangleGrid:
    """Return the triangles over the material between the openings and under both clamps.

    ``cells``, along the free length and across, determine how large triangles may be where there are
    no openings, and into how many pieces an opening's sides are divided.  The result is the same on
    every call.  The points of ``centre_line`` belong to no triangle, because openings may be there.
    Openings with a depth have an upper and a lower side, and walls between these.
    Raises SolverMissing without gmsh, and BadMesh for triangles of poor quality.
    """
    size_m = min(rectangle.length_m / cells[0], rectangle.width_m / cells[1])
    a, b = rectangle.length_m, rectangle.width_m
    border = _divide_sides(np.array([[0.0, 0.0], [a, 0.0], [a, b], [0.0, b]]), size_m)  # anticlockwise
    holes = _holes(rectangle, apertures, size_m)
    inner = _between_m(rectangle, apertures, size_m)
    points, triangles = _triangulate([border, *holes], inner)
    points, triangles = _add_clamps(rectangle, points, triangles)
    s = _rows_m(rectangle, cells[0])
    line = np.column_stack([s, np.full(len(s), rectangle.width_m / 2)])
    result = TriangleGrid(np.vstack([points, line]), triangles, np.arange(len(line)) + len(points))
    _inspect(result, rectangle, sum(map(area_m2, holes)))
    if apertures.depth_m == 0.0:
        return result
    widening_m = apertures.widening_m(apertures.depth_m)
    ways = _ways(rectangle, apertures, holes)
    lower_m = np.vstack([points + widening_m * _outwards(points, holes, ways), line])
    below = [hole + widening_m * way for hole, way in zip(holes, ways, strict=True)]
    lower = TriangleGrid(lower_m, triangles, result.centre_line)
    _inspect(lower, rectangle, sum(map(area_m2, below)))
    return deepened(result, lower_m, apertures.depth_m)


def deepened(flat: TriangleGrid, lower_m: Array, depth_m: float) -> TriangleGrid:
    """Return the closed surface of a panel, of which a flat grid is the upper side.

    The points of the lower side are at ``lower_m`` (n, 2), in the order of those of the flat grid, and
    ``depth_m`` below them along the normal; the panel's middle surface is half way.  Walls join all edges
    that belong to one triangle alone, those of openings of any outline and the panel's own.  Points of no
    triangle are only observed, and stay in the middle surface.
    """
    count, kept = len(flat.coordinates_m), np.setdiff1d(np.arange(len(lower_m)), flat.centre_line)
    directed = flat.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)  # as the triangles run through them
    key, back = directed @ [count, 1], directed @ [1, count]
    first, second = directed[~np.isin(key, back)].T
    walls = [(first, first + count, second + count), (first, second + count, second)]
    offset_m = np.zeros((2 * count, 1))
    offset_m[kept], offset_m[kept + count] = depth_m / 2, -depth_m / 2
    coordinates_m = np.hstack([np.vstack([flat.coordinates_m, lower_m]), offset_m])
    lower = flat.triangles[:, ::-1] + count
    parts = [flat.triangles, lower, *(np.column_stack(wall) for wall in walls)]
    side = np.repeat([UPPER, LOWER, WALL, WALL], [len(part) for part in parts])
    used = np.ones(2 * count, dtype=bool)
    used[flat.centre_line + count] = False  # nothing needs them twice
    number = np.cumsum(used) - 1
    return TriangleGrid(coordinates_m[used], number[np.vstack(parts)], flat.centre_line, side)


def _holes(rectangle: Rectangle, apertures: AperturePattern, size_m: float) -> list[Array]:
    """Return the outlines (n, 2) of all openings, whose sides are divided into pieces of about ``size_m``."""
    if apertures.drawn:
        return [_divide_sides(corners, size_m) for corners in apertures.drawn.corners_m]
    outline = _divide_sides(apertures.outline_m(), size_m)
    return [outline + centre for centre in apertures.centres_m(rectangle)]


def _ways(rectangle: Rectangle, apertures: AperturePattern, holes: list[Array]) -> list[Array]:
    """Return the way (n, 2) of each point of the outlines while all sides move outwards by one."""
    if apertures.drawn:
        return [*map(outwards, holes)]
    centres = apertures.centres_m(rectangle)
    return [_from_outline(hole - centre, apertures) for hole, centre in zip(holes, centres, strict=True)]


def _outwards(points: Array, holes: list[Array], ways: list[Array]) -> Array:
    """Return the ways (n, 2) of points (n, 2), which are those of outlines; other points have none."""
    from scipy.spatial import cKDTree  # takes long to import, and few commands need it

    far_m, nearest = cKDTree(np.vstack(holes)).query(points)
    direction = np.vstack(ways)[nearest]
    direction[far_m > ON_OUTLINE * np.ptp(holes[0], axis=0).max()] = 0.0
    return np.asarray(direction)


def _from_outline(places_m: Array, apertures: AperturePattern) -> Array:
    """Return the ways (n, 2) of places (n, 2) on an outline about its centre."""
    half = np.array([apertures.length_m, apertures.width_m]) / 2
    if apertures.shape == "rectangle":
        on_side = np.abs(np.abs(places_m) / half - 1.0) < ON_OUTLINE
        return np.where(on_side, np.sign(places_m), 0.0)
    radius_m = half.min()
    return np.asarray((places_m - np.clip(places_m, radius_m - half, half - radius_m)) / radius_m)


def quality(grid: TriangleGrid) -> Quality:
    """Return the quality of a grid; the area of a triangle that is turned over counts as negative."""
    corners = grid.coordinates_m[grid.triangles]
    sides = np.roll(corners, -1, axis=1) - corners  # (m, 3, 2)
    length_m = np.linalg.norm(sides, axis=2)
    before = -np.roll(sides, 1, axis=1)
    cross = sides[..., 0] * before[..., 1] - sides[..., 1] * before[..., 0]
    angle = np.arctan2(cross, np.einsum("mij,mij->mi", sides, before))
    return Quality(float(np.degrees(angle.min())), float(length_m.max()), float(cross[:, 0].sum() / 2))


def _inspect(grid: TriangleGrid, rectangle: Rectangle, open_m2: float) -> None:
    """Check the quality of a grid over a panel with openings of this total area.  Raises BadMesh."""
    measured = quality(grid)
    if not measured.least_angle_deg >= SMALLEST_ANGLE_DEG:
        raise BadMesh(
            f"a triangle between the openings has an angle of {measured.least_angle_deg:.2g} deg "
            f"(at least {SMALLEST_ANGLE_DEG:g} wanted): wider lands or more surface_cells"
        )
    whole_m2 = (rectangle.length_m + 2 * rectangle.clamp_m) * rectangle.width_m
    if abs(measured.covered_m2 - (whole_m2 - open_m2)) > 1e-9 * whole_m2:
        raise BadMesh(
            f"the triangles cover {measured.covered_m2:.9g} m2, the material between the openings "
            f"{whole_m2 - open_m2:.9g} m2"
        )


def _divide_sides(polygon: Array, size_m: float) -> Array:
    """Return the polygon (n, 2) with each side divided into equal pieces of about ``size_m``."""
    pieces = []
    for start, end in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        count = max(round(math.dist(start, end) / size_m), 1)
        pieces.append(start + np.arange(count)[:, None] / count * (end - start))
    return np.vstack(pieces)


def _between_m(rectangle: Rectangle, apertures: AperturePattern, size_m: float) -> Array:
    """Return points (n, 2) inside the free length, ``size_m`` apart.

    Points that are nearer than half this distance to an opening are left out.
    """
    along, across = (max(round(x / size_m), 1) for x in (rectangle.length_m, rectangle.width_m))
    s = np.linspace(0.0, rectangle.length_m, along + 1)[1:-1]
    y = np.linspace(0.0, rectangle.width_m, across + 1)[1:-1]
    centres = apertures.centres_m(rectangle)
    reaches = apertures.half_sides_m() + size_m / 2
    reaches += max(apertures.widening_m(apertures.depth_m), 0.0)
    free = np.ones((len(s), len(y)), dtype=bool)
    for centre, reach in zip(centres, np.broadcast_to(reaches, centres.shape), strict=True):
        near = np.abs(s - centre[0])[:, None] < reach[0]
        free &= ~(near & (np.abs(y - centre[1])[None, :] < reach[1]))
    i, j = np.nonzero(free)
    return np.column_stack([s[i], y[j]])


def _triangulate(loops: list[Array], inner: Array) -> tuple[Array, Indices]:
    """Return points (n, 2) and triangles (m, 3) of the area inside the first loop and outside the others.

    The ``inner`` points (k, 2) are corners of triangles, too.
    """
    with gmsh_session() as gmsh:
        gmsh.option.setNumber("Mesh.Algorithm", GIVEN_POINTS_ONLY)
        model, mesh = gmsh.model.geo, gmsh.model.mesh
        area = model.addPlaneSurface([closed_line(model, loop) for loop in loops])
        free = [model.addPoint(s, y, 0.0) for s, y in inner]
        model.synchronize()
        if free:
            mesh.embed(0, free, 2, area)
        for _, line in gmsh.model.getEntities(1):
            mesh.setTransfiniteCurve(line, 2)
        mesh.generate(2)
        return made_triangles(gmsh)


def _add_clamps(rectangle: Rectangle, points: Array, triangles: Indices) -> tuple[Array, Indices]:
    """Add the strip under each clamp: two triangles for each piece of the clamp's edge."""
    if rectangle.clamp_m == 0.0:
        return points, triangles
    slack = 1e-9 * rectangle.length_m
    for edge, beyond in ((0.0, -1.0), (rectangle.length_m, 1.0)):
        on_edge = np.flatnonzero(np.abs(points[:, 0] - edge) < slack)
        near = on_edge[np.argsort(points[on_edge, 1])]
        far = np.arange(len(near)) + len(points)
        outer_edge = points[near] + (beyond * rectangle.clamp_m, 0.0)
        points = np.vstack([points, outer_edge])
        left, right = (far, near) if beyond < 0 else (near, far)
        first = np.column_stack([left[:-1], right[:-1], right[1:]])
        second = np.column_stack([left[:-1], right[1:], left[1:]])
        triangles = np.vstack([triangles, first, second])
    return points, triangles


def surface_grids(case: Case) -> dict[str, TriangleGrid]:
    """Return the grid of each panel, by the panel's name.

    The grids resolve openings only if the case has particles; otherwise the surface only serves for
    pictures.  Equal panels share one grid.  Raises SolverMissing (without gmsh) and BadMesh for panels with
    openings.
    """
    grids = {}
    for panel in single_panels(case):
        r = panel.rectangle
        apertures = panel.apertures if has_particles(case) else None
        grids[panel.name] = _grid_of(r.length_m, r.width_m, r.clamp_m, apertures, case.panel.surface_cells)
    return grids


@lru_cache(REMEMBERED)
def _grid_of(
    length_m: float, width_m: float, clamp_m: float, apertures: AperturePattern | None, cells: tuple[int, int]
) -> TriangleGrid:
    """Return the grid of all panels of one shape, which takes seconds for a thousand openings."""
    x, y, _ = np.eye(3)
    shape = Rectangle(np.zeros(3), x, y, length_m, length_m, width_m, clamp_m)
    made = perforated_grid(shape, apertures, cells) if apertures else grid(shape, cells)
    for values in (made.coordinates_m, made.triangles, made.centre_line, made.side):
        if values is not None:
            values.setflags(write=False)
    return made
