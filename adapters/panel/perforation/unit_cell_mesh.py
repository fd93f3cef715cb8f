"""Triangles of one period of a pattern of openings, by gmsh; opposite sides match.

Openings that cross the cell's border appear on both sides of it.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from orchestrator.ports import Array, Indices
from orchestrator.ports.geometry import Apertures
from orchestrator.ports.meshing import gmsh_session

TRIANGLES_PER_LAND = 6
MOST_TRIANGLES = 6_000


def cell_m(apertures: Apertures) -> tuple[float, float]:
    """The period along and across: two rows if they are staggered."""
    rows = 2 if apertures.stagger else 1
    return rows * apertures.pitch_along_m, apertures.pitch_across_m


def cell_triangles(apertures: Apertures) -> tuple[Array, Indices]:
    """Points (n, 2) and triangles (m, 3) of the material in one period."""
    with gmsh_session() as gmsh:
        return _meshed(gmsh, apertures)


def _meshed(gmsh: Any, apertures: Apertures) -> tuple[Array, Indices]:
    model, (along_m, across_m) = gmsh.model.occ, cell_m(apertures)
    box = model.addRectangle(0.0, 0.0, 0.0, along_m, across_m)
    holes = [(2, _polygon(model, outline)) for outline in _outlines(apertures)]
    model.cut([(2, box)], holes)
    model.synchronize()
    for axis, period_m in ((0, along_m), (1, across_m)):
        _match(gmsh, axis, period_m)
    narrowest_m = min(apertures.land_m, apertures.length_m, apertures.width_m)
    solid_m2 = apertures.solid_share * along_m * across_m
    size_m = max(narrowest_m / TRIANGLES_PER_LAND, math.sqrt(2.5 * solid_m2 / MOST_TRIANGLES))
    gmsh.option.setNumber("Mesh.MeshSizeMin", size_m)
    gmsh.option.setNumber("Mesh.MeshSizeMax", size_m)
    gmsh.model.mesh.generate(2)
    tags, places, _ = gmsh.model.mesh.getNodes()
    _, _, corners = gmsh.model.mesh.getElements(2)
    order = np.argsort(tags)
    triangles = np.searchsorted(tags[order], corners[0].reshape(-1, 3)).astype(np.int64)
    used, triangles = np.unique(triangles, return_inverse=True)
    return places.reshape(-1, 3)[order][used, :2], triangles.reshape(-1, 3)


def _outlines(apertures: Apertures) -> list[Array]:
    """Of all openings that reach into the cell."""
    along_m, across_m = apertures.pitch_along_m, apertures.pitch_across_m
    rows = (0.0, apertures.stagger) if apertures.stagger else (0.0,)
    outline = apertures.outline_m()
    return [
        outline + np.array(((row + 0.5) * along_m, (0.5 + shift + image) * across_m))
        for row, shift in enumerate(rows)
        for image in ((0, -1) if shift else (0,))
    ]


def _polygon(model: Any, outline: Array) -> int:
    points = [model.addPoint(s, y, 0.0) for s, y in outline]
    lines = [model.addLine(one, two) for one, two in zip(points, [*points[1:], points[0]], strict=True)]
    return int(model.addPlaneSurface([model.addCurveLoop(lines)]))


def _match(gmsh: Any, axis: int, period_m: float) -> None:
    """Give the curves on the far side of the cell the mesh of those on the near side."""
    near: dict[tuple[int, ...], int] = {}
    far: dict[tuple[int, ...], int] = {}
    fine = 1e-6 * period_m
    for _, curve in gmsh.model.getEntities(1):
        low = np.array(gmsh.model.getBoundingBox(1, curve))
        place = tuple(np.round(np.delete(low.reshape(2, 3), axis, axis=1).ravel() / fine, 0))
        ends = low.reshape(2, 3)[:, axis]
        if (np.abs(ends) < 10 * fine).all():
            near[place] = curve
        elif (np.abs(ends - period_m) < 10 * fine).all():
            far[place] = curve
    shift = np.eye(4)
    shift[axis, 3] = period_m
    order = sorted(near)
    gmsh.model.mesh.setPeriodic(
        1, [far[place] for place in order], [near[place] for place in order], shift.ravel().tolist()
    )
