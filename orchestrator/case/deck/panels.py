"""The deck's parts in world axes: panels, the stops below them and rigid surfaces.

The module also estimates the time that material stays on the deck.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from orchestrator.case.deck.surface_file import read_surface
from orchestrator.case.file.slice import cut_surface
from orchestrator.case.tables.case import Case
from orchestrator.case.tables.deck import DrawnApertures, PanelSheet, Stop
from orchestrator.case.tables.screen import PanelTable, Surface
from orchestrator.ports import Array, Indices
from orchestrator.ports.drawn_openings import Drawing, DrawnOpenings, as_outline
from orchestrator.ports.geometry import AperturePattern, Rectangle
from orchestrator.ports.plans import StopPlan

REMEMBERED = 32  # drawings of panels: more than a case has


def axes(case: Case) -> Array:
    """Return the deck axes in the world as the columns of (3, 3); x slopes down by the inclination."""
    angle = math.radians(case.screen.inclination_deg)
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def to_world(case: Case, vectors: Sequence[float] | Sequence[Sequence[float]] | Array) -> Array:
    """Turn vectors, (3,) or (n, 3), from deck axes to world axes; both have the same origin."""
    return np.asarray(np.asarray(vectors, dtype=float) @ axes(case).T)


@dataclass(frozen=True)
class SinglePanel:
    """One panel with its own name, frames, place and openings.

    The case describes it in the row ``table`` with the name ``table_name``.
    """

    name: str
    table_name: str
    table: PanelTable
    frames: tuple[str, str]
    rectangle: Rectangle
    apertures: AperturePattern | None

    @property
    def material_share(self) -> float:
        """The share of material in the panel's free area."""
        return self.mean_apertures.material_share(self.rectangle) if self.mean_apertures else 1.0

    @property
    def mean_apertures(self) -> AperturePattern | None:
        """The openings as the panel's mass and stiffness have them: their section half way down."""
        return self.apertures.mean_section if self.apertures else None


def single_panels(case: Case) -> tuple[SinglePanel, ...]:
    """Return all panels, in the order of the case.  A row's frames alternate from panel to panel."""
    return tuple(
        SinglePanel(
            name=name if row.count == 1 else f"{name}-{number + 1}",
            table_name=name,
            table=row,
            frames=row.frames if number % 2 == 0 else row.frames[::-1],
            rectangle=_rectangle(case, row, number),
            apertures=aperture_pattern(row),
        )
        for name, row in case.screen.panels.items()
        for number in range(row.count)
    )


def aperture_pattern(row: PanelSheet) -> AperturePattern | None:
    """Return the openings of a panel; None without any."""
    if row.apertures is None:
        return None
    depth_m = relief_deg = 0.0
    if row.apertures.rims == "deep":
        depth_m, relief_deg = row.apertures.depth_m or row.thickness_m, row.apertures.relief_deg or 0.0
    if isinstance(row.apertures, DrawnApertures):
        sides_m = (row.length_m, row.width_m, row.clamp_m)
        flat = _drawn_pattern(row.apertures.drawing, *sides_m, row.apertures.margin_share)
        return replace(flat, depth_m=depth_m, relief_deg=relief_deg) if flat else None
    given = row.apertures.model_dump(exclude={"rims", "depth_m", "relief_deg"})
    return AperturePattern(**given, depth_m=depth_m, relief_deg=relief_deg)


@lru_cache(REMEMBERED)
def _drawn_pattern(
    drawing: Drawing, length_m: float, width_m: float, clamp_m: float, margin_share: float
) -> AperturePattern | None:
    """Return the openings of a drawing on the free length; None if all lie under the clamps."""
    free = (corners - (clamp_m, 0.0) for corners in map(np.array, drawing.outlines_m))
    outlines_m = tuple(as_outline(at) for at in free if at[:, 0].max() > 0.0 and at[:, 0].min() < length_m)
    if not outlines_m:
        return None
    drawn = DrawnOpenings(outlines_m, (length_m, width_m))
    (along_m, across_m), (pitch_along_m, pitch_across_m) = drawn.mean_sides_m, drawn.pitch_m
    return AperturePattern(
        shape="polygon",
        length_m=along_m,
        width_m=across_m,
        pitch_along_m=pitch_along_m,
        pitch_across_m=pitch_across_m,
        margin_share=margin_share,
        drawn=drawn,
    )


def perforated_panels(case: Case) -> list[tuple[SinglePanel, ...]]:
    """Return the panels that have openings as groups of equal panels, in the order of the case."""
    alike: dict[object, list[SinglePanel]] = {}
    for panel in single_panels(case):
        if panel.apertures is not None:
            r = panel.rectangle
            shape = (panel.apertures, r.length_m, r.width_m, r.clamp_m, panel.table.thickness_m)
            alike.setdefault(shape, []).append(panel)
    return [tuple(panels) for panels in alike.values()]


def span_m(panel: PanelTable) -> float:
    """Return the distance between the clamps' inner edges."""
    return panel.span_m if panel.span_m is not None else panel.length_m + (panel.tension_m or 0.0)


def unit_vector(vector: Sequence[float] | Array) -> Array:
    """Return the unit vector in the direction of a vector that is not zero."""
    array = np.asarray(vector, dtype=float)
    return np.asarray(array / np.linalg.norm(array))


def _rectangle(case: Case, row: PanelTable, number: int) -> Rectangle:
    along, across = unit_vector(row.along), unit_vector(row.across)
    corner = np.asarray(row.corner_m) + number * (row.pitch_m or 0.0) * along
    return Rectangle(
        corner_m=to_world(case, corner),
        along=to_world(case, along),
        across=to_world(case, across),
        length_m=row.length_m,
        span_m=span_m(row),
        width_m=row.width_m,
        clamp_m=row.clamp_m,
        clamp_angle_deg=row.clamp_angle_deg,
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
    """Return the rigid surfaces of the case: plates, and files in its ``folder``.

    Surfaces outside of a slice are left out.  Raises UnreadableSurface.
    """
    surfaces = []
    for name, surface in case.screen.surfaces.items():
        corners_m, triangles = cut_surface(case, *_triangles(surface, folder))
        position_m = to_world(case, corners_m)
        if len(triangles):
            surfaces.append(Wall(name, surface.frame, surface.material, position_m, triangles))
    return tuple(surfaces)


def _triangles(surface: Surface, folder: Path) -> tuple[Array, Indices]:
    """Return the corners (n, 3) of a surface, in deck axes, and its triangles (m, 3)."""
    if surface.stl is not None or surface.file is not None:
        healed = read_surface(surface, folder)
        return healed.position_m, healed.triangles
    return plate_corners_m(surface), np.array([[0, 1, 2], [0, 2, 3]], dtype=np.int64)


def plate_corners_m(surface: Surface) -> Array:
    """Return the corners of a plate (4, 3), in deck axes."""
    corner, (one, two) = np.array(surface.corner_m), np.array(surface.edges_m)
    return np.array([corner, corner + one, corner + one + two, corner + two])


USUAL, MOST = 0.1, 1.0
"""Values of k dt^2 / m for a layer of stiffness k under a mass m per area; above 4 it is unstable."""


def planned_stops(case: Case, panel: SinglePanel) -> tuple[StopPlan, ...]:
    """Return the stops of one panel, in the order of the case."""
    return tuple(_stop(case, panel, name, row) for name, row in panel.table.stops.items())


def stiffest_Pa_per_m(case: Case, panel: SinglePanel) -> float:
    """Return the largest stiffness of a stop's layer that the sync interval allows."""
    return MOST * areal_mass_kg_per_m2(case, panel) / case.coupling.sync_interval_s**2


def areal_mass_kg_per_m2(case: Case, panel: SinglePanel) -> float:
    """Return the panel's mass over its area; the area includes the openings."""
    density_kg_per_m3 = case.materials[panel.table.material].density_kg_per_m3
    return density_kg_per_m3 * panel.table.thickness_m * panel.material_share


def _stop(case: Case, panel: SinglePanel, name: str, row: Stop) -> StopPlan:
    """Return the plan of one stop; by default, the frame of the nearer clamp carries it."""
    mass_kg_per_m2 = areal_mass_kg_per_m2(case, panel)
    stiffness_Pa_per_m = row.stiffness_Pa_per_m or USUAL / MOST * stiffest_Pa_per_m(case, panel)
    nearer = (row.from_m + row.to_m) / 2 > panel.table.length_m / 2
    return StopPlan(
        name=name,
        frame=row.frame or panel.frames[nearer],
        from_m=row.from_m,
        to_m=row.to_m,
        gap_m=row.gap_m,
        stiffness_Pa_per_m=stiffness_Pa_per_m,
        damping_Pa_s_per_m=2 * row.damping_ratio * math.sqrt(stiffness_Pa_per_m * mass_kg_per_m2),
    )


TRANSPORT_M_PER_S = 0.34
"""Speed of the material: 40 kg/s in a layer of 175 mm on a width of 0.8 m, with 850 kg/m3 in bulk (Xu et
al., Minerals 14, 2024, 278).  Thin layers are faster, and fewer particles are then on the deck."""


def stay_s(case: Case, transport_m_per_s: float = TRANSPORT_M_PER_S) -> float:
    """Return the time that material stays on the deck; infinite where nothing leaves, or without panels."""
    length_m = deck_length_m(case)
    return length_m / transport_m_per_s if case.screen.exits and length_m else math.inf


def deck_length_m(case: Case) -> float:
    """Return the length from the first panel's upper end to the last panel's lower end; 0 without panels."""
    ends_m = [
        panel.rectangle.mounted(np.array([[along_m, 0.0]]))[0]
        for panel in single_panels(case)
        for along_m in (0.0, panel.rectangle.length_m)
    ]
    return float(np.linalg.norm(np.ptp(ends_m, axis=0))) if ends_m else 0.0
