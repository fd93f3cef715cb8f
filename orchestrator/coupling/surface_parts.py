"""The surface of a machine: its parts, and the indices of their points and triangles in the whole.

The parts are panels, walls, and points that are only observed.  The coupling treats each part as a
``Panel``: a finite-element panel seen through the particles' triangles, a wall that a frame carries,
or points on a frame that nothing touches.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import Any, cast

import numpy as np

from orchestrator.case import solvers
from orchestrator.case.deck.panels import SinglePanel, Wall, single_panels, to_world, walls
from orchestrator.case.deck.triangle_grid import TriangleGrid, surface_grids
from orchestrator.case.file.errors import CaseError, CaseProblem
from orchestrator.case.recordings import playbacks
from orchestrator.case.solver_plans import material_numbers, panel_plans
from orchestrator.case.tables.case import Case
from orchestrator.coupling.machine import PanelPoints, PlacedProbe
from orchestrator.coupling.mapping import MappedPanel
from orchestrator.coupling.metered import Stopwatch, TimedPanel
from orchestrator.coupling.mpi import first_rank_does
from orchestrator.coupling.panel_set import PanelSet
from orchestrator.ports import Array, Indices, MeshedPanel, Panel
from orchestrator.ports.geometry import Edges, TriangleSurface
from orchestrator.ports.penetration import Penetrations, ProbedPanel, SurfaceBody
from orchestrator.ports.plans import PanelPlan
from orchestrator.ports.recording import RecordedGrid

NO_TRIANGLES = np.empty((0, 3), dtype=np.int64)
NO_POINTS = np.empty(0, dtype=np.int64)


@dataclass(frozen=True)
class SurfacePart:
    """A part of the surface: the call that opens it, and the data of its points before the call.

    ``drawn_m`` (n, 3) are its surface points as drawn; a panel is drawn straight between its clamps.
    ``triangles`` (m, 3), their stress-free ``edges``, ``centre_line`` and ``shape`` (the points of its
    ``RecordedGrid`` if it is recorded) hold the part's own point numbers.  ``points`` maps the names of
    observed points (probes, centres of mass) to their numbers.  The last three times ``stops`` clamp points
    belong to beams below the part.
    """

    name: str
    open: Callable[[], Panel]
    drawn_m: Array
    points: dict[str, int]
    triangles: Indices = field(default_factory=lambda: NO_TRIANGLES)
    edges: Edges = field(default_factory=lambda: Edges.of(np.empty((0, 2)), NO_TRIANGLES))
    material: str = ""
    centre_line: Indices = field(default_factory=lambda: NO_POINTS)
    shape: Indices = field(default_factory=lambda: NO_POINTS)
    stops: int = 0


def panel_parts(case: Case, case_folder: Path, stopwatch: Stopwatch, world: Any = None) -> list[SurfacePart]:
    """Return a part for each panel, in the order of the case; every rank of ``world`` gets the same parts."""
    plans = panel_plans(case, playbacks(case, case_folder))
    grids = first_rank_does(world, lambda: surface_grids(case))
    return [
        _panel(case, plan, single.table.material, grids[plan.name], stopwatch)
        for plan, single in zip(plans, single_panels(case), strict=True)
    ]


def _panel(
    case: Case, plan: PanelPlan, material: str, touched: TriangleGrid, stopwatch: Stopwatch
) -> SurfacePart:
    at = {
        name: np.multiply(probe.at, (plan.rectangle.length_m, plan.rectangle.width_m))
        for name, probe in case.probes.items()
        if probe.panel == plan.name and probe.at is not None
    }
    recorded = RecordedGrid.of(plan.rectangle, case.panel.surface_cells).points_m
    shape_m = recorded if case.output.shapes_s > 0 else np.empty((0, 2))
    coordinates = np.vstack([touched.coordinates_m, *at.values(), shape_m])
    solver = case.panel.solver
    # load the adapter on every rank, even on ranks without a panel: PETSc starts up collectively
    solvers.adapter("panel", solver).load()

    def open_panel() -> Panel:
        own = cast(MeshedPanel, solvers.open_solver("panel", solver, plan))
        if plan.stops:
            own = _on_stops(own, plan)
        panel = TimedPanel(own, f"panel {plan.name} ({solver})", "panel", stopwatch)
        return MappedPanel(panel, own.interpolation(coordinates))

    first = len(touched.coordinates_m)
    return SurfacePart(
        name=plan.name,
        open=open_panel,
        drawn_m=plan.rectangle.mounted(coordinates),
        points={name: first + number for number, name in enumerate(at)},
        stops=len(plan.stops),
        triangles=touched.triangles,
        edges=Edges.of(touched.coordinates_m, touched.triangles),
        material=material,
        centre_line=touched.centre_line,
        shape=np.arange(len(coordinates) - len(shape_m), len(coordinates)),
    )


def _on_stops(panel: MeshedPanel, plan: PanelPlan) -> MeshedPanel:
    from orchestrator.coupling.stopped_panel import StoppedPanel

    try:
        return StoppedPanel(panel, plan)
    except ValueError as error:
        key = ("screen", "panels", plan.name, "stops")
        raise CaseError([CaseProblem(key, str(error), "lower it, or tighten the panel")]) from error


def wall_parts(case: Case, case_folder: Path) -> list[SurfacePart]:
    """Return a part for each rigid surface."""

    def part(wall: Wall) -> SurfacePart:
        opened = carried(wall.position_m, wall.frame)
        place_m = wall.position_m
        return SurfacePart(wall.name, opened, place_m, {}, wall.triangles, material=wall.material)

    return [part(wall) for wall in walls(case, case_folder)]


def _frame_points(case: Case, frame: str) -> SurfacePart:
    """Return the part of a frame's points that are only observed.

    They are its centre of mass (under the frame's name), the ends of three arms of 1 m from there along the
    world's axes, which show its rotation, and its probes.
    """
    probes = {
        name: probe.point_m
        for name, probe in case.probes.items()
        if probe.frame == frame and probe.point_m is not None
    }
    centre_m = to_world(case, case.screen.frames[frame].center_of_mass_m)
    probes_m = to_world(case, np.array(list(probes.values())).reshape(-1, 3))
    position_m = np.vstack([centre_m, centre_m + np.eye(3), probes_m])
    points = {frame: 0} | {name: number for number, name in enumerate(probes, start=4)}
    return SurfacePart(frame, carried(position_m, frame), position_m, points)


def carried(position_m: Array, frame: str) -> Callable[[], Panel]:
    """Return a call that opens a rigid surface of points (n, 3) that ``frame`` carries."""
    module = "adapters.panel.common.carried"
    return lambda: cast(Panel, import_module(module).build(position_m, frame))


@dataclass(frozen=True)
class OpenSurface:
    """The open surface of a machine, with all parts: panels in the case's order, walls, and frames.

    Particles touch the parts that have a material; points on frames belong to the surface, but to no
    triangle.
    """

    case: Case
    parts: list[SurfacePart]
    together: PanelSet

    @staticmethod
    def of(case: Case, case_folder: Path, stopwatch: Stopwatch, world: Any) -> OpenSurface:
        """Open the surface of a case, on every rank of ``world``."""
        parts = [
            *panel_parts(case, case_folder, stopwatch, world),
            *wall_parts(case, case_folder),
            *(_frame_points(case, frame) for frame in case.screen.frames),
        ]
        return OpenSurface(case, parts, PanelSet(len(parts), lambda i: parts[i].open(), world))

    def bodies(self) -> list[SurfaceBody]:
        """Return the triangles of every part, in points of the whole surface."""
        return [
            SurfaceBody(part.name, part.triangles + points.start)
            for part, points in zip(self.parts, self.together.surface, strict=True)
        ]

    def triangle_surface(self) -> TriangleSurface:
        """Return the surface that particles touch, at rest."""
        number = material_numbers(self.case)
        touched = [part for part in self.parts if part.material]
        return TriangleSurface(
            self.together.initial().surface.position_m,
            np.concatenate([NO_TRIANGLES, *(body.triangles for body in self.bodies())]),
            np.concatenate(
                [NO_POINTS, *(np.full(len(part.triangles), number[part.material]) for part in touched)]
            ),
        )

    def panel_of_triangle(self) -> Indices:
        """Return the number of each triangle's panel; -1 for walls."""
        panels = len(single_panels(self.case))
        numbers = [number if number < panels else -1 for number in range(len(self.parts))]
        return np.repeat(np.array(numbers, dtype=np.int64), [len(part.triangles) for part in self.parts])

    def panel_points(self) -> tuple[PanelPoints, ...]:
        """Return the places of the panels' points; the first clamp extends up to the middle of the span."""
        return tuple(
            self._points_of(part, single, surface, clamps)
            for part, single, surface, clamps in zip(
                self.parts,
                single_panels(self.case),
                self.together.surface,
                self.together.clamps,
                strict=False,
            )
        )

    def _points_of(
        self, part: SurfacePart, single: SinglePanel, surface: slice, clamps: slice
    ) -> PanelPoints:
        at, end_of_clamps = single.rectangle, clamps.stop - 3 * part.stops
        clamp_points = np.arange(clamps.start, end_of_clamps)
        first = (self.together.mount.position_m[clamp_points] - at.corner_m) @ at.along < at.span_m / 2
        return PanelPoints(
            name=part.name,
            surface=surface,
            clamps=clamps,
            centre_line=surface.start + part.centre_line,
            shape=surface.start + part.shape,
            first_clamp=clamp_points[first],
            second_clamp=clamp_points[~first],
            stops=np.arange(end_of_clamps, clamps.stop),
            edges=surface.start + part.edges.points,
            edge_length_m=part.edges.length_m,
        )

    def penetrations(self) -> Penetrations:
        """Return the search for panels that penetrate a body of triangles.

        Points of a panel that a clamp or a stop holds do not count.
        """
        singles = zip(single_panels(self.case), self.parts, self.together.surface, strict=False)
        probed = [
            ProbedPanel(number, points.start + _free_pairs(single, part), single.table.thickness_m)
            for number, (single, part, points) in enumerate(singles)
        ]
        return Penetrations(np.concatenate([part.drawn_m for part in self.parts]), self.bodies(), probed)

    def centres(self) -> dict[str, int]:
        """Return the number of each frame's centre of mass among the carried points."""
        frames = self.case.screen.frames
        places = zip(self.parts, self.together.clamps, strict=True)
        return {part.name: clamps.start for part, clamps in places if part.name in frames}

    def probes(self) -> tuple[PlacedProbe, ...]:
        """Return the case's probes; probes on frames use the clamp points, which are exact."""
        placed = []
        for number, part in enumerate(self.parts):
            on_frame = part.name in self.case.screen.frames
            points = self.together.clamps[number] if on_frame else self.together.surface[number]
            for name, point in part.points.items():
                if name in self.case.probes:
                    on = "clamps" if on_frame else "surface"
                    placed.append(PlacedProbe(name, on, points.start + point))
        placed += [
            PlacedProbe(name, "particle", probe.particle)
            for name, probe in self.case.probes.items()
            if probe.particle is not None
        ]
        return tuple(placed)


def _free_pairs(single: SinglePanel, part: SurfacePart) -> Indices:
    """Return pairs (k, 2) of points where neither a clamp nor a stop holds their middles.

    They are the points of a panel's triangles, as pairs of equal points, and its edges that are longer than
    the panel is thick.
    """
    at, points = single.rectangle, np.unique(part.triangles)
    long = part.edges.points[part.edges.length_m > single.table.thickness_m]
    pairs = np.concatenate([np.column_stack([points, points]), long])
    along = (part.drawn_m[pairs].mean(axis=1) - at.corner_m) @ at.along / at.span_m
    free = (along > 1e-9) & (along < 1.0 - 1e-9)
    for stop in single.table.stops.values():
        free &= (along < stop.from_m / at.length_m) | (along > stop.to_m / at.length_m)
    return np.asarray(pairs[free])
