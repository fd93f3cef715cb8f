"""STL files: there, readable, whole, consistently oriented, and inside the domain; plates."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from orchestrator.case.deck import stl
from orchestrator.case.deck.panels import plate_corners_m, single_panels, to_world
from orchestrator.case.file.errors import CaseProblem, Key
from orchestrator.case.tables.case import Case
from orchestrator.ports import Array, Indices


def stl_files(case: Case, folder: Path) -> Iterator[CaseProblem]:
    """All that is wrong with the files of ``[screen.surfaces]``."""
    for name, surface in case.screen.surfaces.items():
        if surface.stl is None:
            continue
        key: Key = ("screen", "surfaces", name, "stl")
        try:
            facets = stl.read(folder, surface.stl)
        except stl.UnreadableStl as error:
            yield CaseProblem(key, f'"{surface.stl}": {error}')
            continue
        for what, hint in faults(facets):
            yield CaseProblem(key, f'"{surface.stl}": {what}', hint)
        position_m = to_world(case, facets.position_m)
        outside = _outside(case, position_m)
        if outside:
            extent = np.ptp(position_m, axis=0).max()
            millimetres = "is it in mm? m are wanted" if extent > 50 else ""
            yield CaseProblem(key, f'"{surface.stl}": {outside}', millimetres or "enlarge domain_m")


def plates(case: Case) -> Iterator[CaseProblem]:
    """Each surface is a file or a plate, and a plate has an area."""
    for name, surface in case.screen.surfaces.items():
        key: Key = ("screen", "surfaces", name)
        given = [surface.corner_m is not None, surface.edges_m is not None]
        if surface.stl is not None and any(given):
            yield CaseProblem(key, "is a file and a plate", "give stl, or corner_m and edges_m")
        elif surface.stl is None and not all(given):
            yield CaseProblem(key, "is no surface", "give stl, or corner_m and edges_m")
        elif surface.edges_m is not None:
            longest_m = max(math.hypot(*edge) for edge in surface.edges_m)
            one, two = np.array(surface.edges_m) / (longest_m or 1.0)
            if not np.linalg.norm(np.cross(one, two)) > 1e-9:
                yield CaseProblem((*key, "edges_m"), "span no area", "give two edges at an angle")


def panels_inside(case: Case) -> Iterator[CaseProblem]:
    """Panels and plates with corners outside the domain."""
    for name, surface in case.screen.surfaces.items():
        if surface.edges_m is not None:
            outside = _outside(case, to_world(case, plate_corners_m(surface)))
            if outside:
                plate: Key = ("screen", "surfaces", name, "corner_m")
                yield CaseProblem(plate, f"surface {name}: {outside}", "enlarge domain_m")
    for panel in single_panels(case):
        r = panel.rectangle
        s = np.array([-r.clamp_m, r.length_m + r.clamp_m])
        corners = np.array([(a, b) for a in s for b in (0.0, r.width_m)])
        outside = _outside(case, r.mounted(corners))
        if outside:
            row = panel.name if panel.table.count == 1 else panel.name.rpartition("-")[0]
            key: Key = ("screen", "panels", row, "corner_m")
            yield CaseProblem(key, f"panel {panel.name}: {outside}", "enlarge domain_m")


def faults(facets: stl.Facets) -> Iterator[tuple[str, str]]:
    """What is wrong with a triangulation, and what to do about it."""
    corners = facets.position_m[facets.triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    size = np.ptp(corners.reshape(-1, 3), axis=0).max()
    flat = np.flatnonzero(np.linalg.norm(normal, axis=1) <= 1e-10 * size**2)
    if len(flat):
        yield f"{len(flat)} triangles without area, the first is number {flat[0]}", "remove them"
        return
    edges, count = _directed_edges(facets.triangles)
    both, sharing = np.unique(np.sort(edges, axis=1), axis=0, return_counts=True)
    if (sharing > 2).any():
        middle = facets.position_m[both[np.argmax(sharing > 2)]].mean(axis=0)
        yield (
            f"{(sharing > 2).sum()} edges with more than two triangles, the first at "
            f"{np.round(middle, 4).tolist()}",
            "remove double or inner triangles",
        )
    elif (count > 1).any():
        yield "neighbouring triangles are oriented against each other", "orient all alike"
    elif (sharing == 2).all() and _volume_m3(corners) < 0:
        yield "a closed surface whose normals point inwards", "turn its triangles over"
    against = np.einsum("ij,ij->i", normal, facets.normal) < 0
    if against.any():
        yield f"{against.sum()} normals contradict the order of the corners", "export it again"


def _directed_edges(triangles: Indices) -> tuple[Indices, Indices]:
    """Edges as pairs of points, as the triangles run through them, each with how often."""
    edges = triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    _, inverse, count = np.unique(edges, axis=0, return_inverse=True, return_counts=True)
    return edges, count[inverse]


def _volume_m3(corners: Array) -> float:
    """By the divergence theorem, (m, 3, 3) corners of a closed surface."""
    return float(np.linalg.det(corners - corners.reshape(-1, 3).mean(axis=0)).sum() / 6)


def _outside(case: Case, position_m: Array) -> str:
    """Says how far points reach outside the domain; empty if they do not."""
    low, high = np.array(case.domain_m)
    beyond = np.maximum(low - position_m, position_m - high).max(axis=0)
    if beyond.max() <= 0:
        return ""
    axis = int(beyond.argmax())
    return f"reaches {beyond[axis]:.4g} m out of domain_m along {'xyz'[axis]}"
