"""From the case's deck axes to the world, and from rows of panels to single ones."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from orchestrator.case.deck import stl
from orchestrator.case.file.slice import cut_surface
from orchestrator.case.tables.case import Case
from orchestrator.case.tables.screen import PanelTable, Surface
from orchestrator.ports import Array, Indices
from orchestrator.ports.geometry import AperturePattern, Rectangle


def axes(case: Case) -> Array:
    """(3, 3): its columns are the deck axes in the world; x slopes down by the inclination."""
    angle = math.radians(case.screen.inclination_deg)
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def to_world(case: Case, vectors: Sequence[float] | Sequence[Sequence[float]] | Array) -> Array:
    """Vectors in deck axes, (3,) or (n, 3), in world axes.  Both have the same origin."""
    return np.asarray(np.asarray(vectors, dtype=float) @ axes(case).T)


@dataclass(frozen=True)
class SinglePanel:
    """One panel of a row (``table_name``): its own name, frames, place and openings."""

    name: str
    table_name: str
    table: PanelTable
    frames: tuple[str, str]
    rectangle: Rectangle
    apertures: AperturePattern | None


def single_panels(case: Case) -> tuple[SinglePanel, ...]:
    """All panels, in the order of the case.  A row's frames alternate from panel to panel."""
    return tuple(
        SinglePanel(
            name=name if row.count == 1 else f"{name}-{number + 1}",
            table_name=name,
            table=row,
            frames=row.frames if number % 2 == 0 else row.frames[::-1],
            rectangle=_rectangle(case, row, number),
            apertures=AperturePattern(**dict(row.apertures)) if row.apertures else None,
        )
        for name, row in case.screen.panels.items()
        for number in range(row.count)
    )


def perforated(case: Case) -> list[tuple[SinglePanel, ...]]:
    """The panels that have openings, equal ones together, in the order of the case."""
    alike: dict[object, list[SinglePanel]] = {}
    for panel in single_panels(case):
        if panel.apertures is not None:
            r = panel.rectangle
            shape = (panel.apertures, r.length_m, r.width_m, r.clamp_m, panel.table.thickness_m)
            alike.setdefault(shape, []).append(panel)
    return [tuple(panels) for panels in alike.values()]


def span_m(panel: PanelTable) -> float:
    """Distance between the clamps' inner edges."""
    return panel.span_m if panel.span_m is not None else panel.length_m + (panel.tension_m or 0.0)


def unit(vector: Sequence[float] | Array) -> Array:
    """The direction of a vector that is not zero."""
    array = np.asarray(vector, dtype=float)
    return np.asarray(array / np.linalg.norm(array))


def _rectangle(case: Case, row: PanelTable, number: int) -> Rectangle:
    along, across = unit(row.along), unit(row.across)
    corner = np.asarray(row.corner_m) + number * (row.pitch_m or 0.0) * along
    return Rectangle(
        corner_m=to_world(case, corner),
        along=to_world(case, along),
        across=to_world(case, across),
        length_m=row.length_m,
        span_m=span_m(row),
        width_m=row.width_m,
        clamp_m=row.clamp_m,
    )


@dataclass(frozen=True)
class Wall:
    """A rigid surface: points (n, 3) in the world at t = 0, triangles (m, 3) of point numbers."""

    name: str
    frame: str
    material: str
    position_m: Array
    triangles: Indices


def walls(case: Case, folder: Path) -> tuple[Wall, ...]:
    """The rigid surfaces of the case: plates, and files in its folder.  Raises stl.UnreadableStl."""
    found = []
    for name, surface in case.screen.surfaces.items():
        corners_m, triangles = cut_surface(case, *_triangles(surface, folder))
        position_m = to_world(case, corners_m)
        if len(triangles):
            found.append(Wall(name, surface.frame, surface.material, position_m, triangles))
    return tuple(found)


def _triangles(surface: Surface, folder: Path) -> tuple[Array, Indices]:
    """Corners (n, 3) in deck axes and triangles (m, 3)."""
    if surface.stl is not None:
        facets = stl.read(folder, surface.stl)
        return facets.position_m, facets.triangles
    return plate_corners_m(surface), np.array([[0, 1, 2], [0, 2, 3]], dtype=np.int64)


def plate_corners_m(surface: Surface) -> Array:
    """(4, 3) of a plate, in deck axes."""
    corner, (one, two) = np.array(surface.corner_m), np.array(surface.edges_m)
    return np.array([corner, corner + one, corner + one + two, corner + two])
