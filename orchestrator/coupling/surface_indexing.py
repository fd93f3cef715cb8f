"""Indices of points and triangles in the whole surface, which all parts make up together."""

from __future__ import annotations

import numpy as np

from orchestrator.case.deck.panels import SinglePanel, single_panels
from orchestrator.case.solver_plans import material_numbers
from orchestrator.case.tables.case import Case
from orchestrator.coupling.machine import PanelPoints, PlacedProbe
from orchestrator.coupling.panel_set import PanelSet
from orchestrator.coupling.surface_parts import SurfacePart
from orchestrator.ports import Array, Indices
from orchestrator.ports.geometry import TriangleSurface
from orchestrator.ports.penetration import Penetrations, ProbedPanel, SurfaceBody

NONE = np.empty(0, dtype=np.int64)  # a machine need not have anything to touch


def touched_surface(
    case: Case, touched: list[SurfacePart], together: PanelSet, position_m: Array
) -> TriangleSurface:
    """Returns all that particles touch; points on frames belong to it, but to no triangle."""
    number = material_numbers(case)
    return TriangleSurface(
        position_m,
        np.concatenate(
            [
                NONE.reshape(0, 3),
                *(
                    part.triangles + points.start
                    for part, points in zip(touched, together.surface, strict=False)
                ),
            ]
        ),
        np.concatenate([NONE, *(np.full(len(part.triangles), number[part.material]) for part in touched)]),
    )


def panel_points(case: Case, panels: list[SurfacePart], together: PanelSet) -> tuple[PanelPoints, ...]:
    """Returns where the panels' points lie; a clamp is the first up to the middle of the span."""
    found = []
    for number, (part, single) in enumerate(zip(panels, single_panels(case), strict=True)):
        surface, clamps, at = together.surface[number], together.clamps[number], single.rectangle
        end_of_held = clamps.stop - 3 * part.stops
        held, stops = np.arange(clamps.start, end_of_held), np.arange(end_of_held, clamps.stop)
        along_m = (together.mount.position_m[held] - at.corner_m) @ at.along
        first = along_m < at.span_m / 2
        line = surface.start + part.centre_line
        shape = surface.start + part.shape
        found.append(
            PanelPoints(
                part.name,
                surface,
                clamps,
                line,
                shape,
                held[first],
                held[~first],
                stops,
                surface.start + part.edges.points,
                part.edges.length_m,
            )
        )
    return tuple(found)


def panel_of_triangle(touched: list[SurfacePart], panels: int) -> Indices:
    """Returns the number of each triangle's panel, of which there are ``panels``; -1 for walls."""
    return np.concatenate(
        [
            NONE,
            *(
                np.full(len(part.triangles), number if number < panels else -1)
                for number, part in enumerate(touched)
            ),
        ]
    )


def penetrations(case: Case, parts: list[SurfacePart], panels: int, together: PanelSet) -> Penetrations:
    """Returns the search for penetrations: of the first ``panels`` parts, where no clamp and no stop
    holds them, through everything that has triangles."""
    bodies = [
        SurfaceBody(part.name, part.triangles + points.start)
        for part, points in zip(parts, together.surface, strict=True)
    ]
    singles = zip(single_panels(case), parts[:panels], together.surface, strict=False)
    probed = [
        ProbedPanel(number, points.start + _free_pairs(single, part), single.table.thickness_m)
        for number, (single, part, points) in enumerate(singles)
    ]
    return Penetrations(np.concatenate([part.drawn_m for part in parts]), bodies, probed)


def _free_pairs(single: SinglePanel, part: SurfacePart) -> Indices:
    """Returns pairs (k, 2) of points: those of a panel's triangles, as pairs of equal ones, and its edges
    that are longer than it is thick, where neither a clamp nor a stop holds their middles."""
    at, points = single.rectangle, np.unique(part.triangles)
    long = part.edges.points[part.edges.length_m > single.table.thickness_m]
    pairs = np.concatenate([np.column_stack([points, points]), long])
    along = (part.drawn_m[pairs].mean(axis=1) - at.corner_m) @ at.along / at.span_m
    free = (along > 1e-9) & (along < 1.0 - 1e-9)
    for stop in single.table.stops.values():
        free &= (along < stop.from_m / at.length_m) | (along > stop.to_m / at.length_m)
    return np.asarray(pairs[free])


def probes(case: Case, parts: list[SurfacePart], together: PanelSet) -> tuple[PlacedProbe, ...]:
    """Returns the case's probes; points of frames are read from the clamps, which are exact."""
    found = []
    for number, part in enumerate(parts):
        on_frame = part.name in case.screen.frames
        points = together.clamps[number] if on_frame else together.surface[number]
        for name, point in part.points.items():
            if name in case.probes:
                on = "clamps" if on_frame else "surface"
                found.append(PlacedProbe(name, on, points.start + point))
    found += [
        PlacedProbe(name, "particle", probe.particle)
        for name, probe in case.probes.items()
        if probe.particle is not None
    ]
    return tuple(found)
