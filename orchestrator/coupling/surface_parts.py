"""The surface of a machine: its parts, and the indices of their points and triangles in the whole.

The parts are panels, seen through the particles' triangles, and walls that a frame carries.  The coupling
treats all of them together as one ``Panel``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any, cast

import numpy as np
from scipy.sparse import csr_array, identity

from orchestrator.case import solvers
from orchestrator.case.bed.grains import material_numbers
from orchestrator.case.deck.deck_plan import deck_plan
from orchestrator.case.deck.panels import SinglePanel, single_panels, to_world, walls
from orchestrator.case.deck.triangle_grid import TriangleGrid, surface_grids
from orchestrator.case.file.errors import CaseError, CaseProblem
from orchestrator.case.solver_plans import panel_plans
from orchestrator.case.tables.case import Case
from orchestrator.coupling.machine import PanelPoints, PlacedProbe
from orchestrator.coupling.mapping import mapped
from orchestrator.coupling.metered import Stopwatch, TimedPanel
from orchestrator.coupling.mpi import first_rank_does
from orchestrator.coupling.panel_set import PanelSet, consecutive_slices
from orchestrator.ports import Array, Indices, Interpolation, MeshedPanel, Panel
from orchestrator.ports.geometry import UPPER, Edges, RigidVertices, TriangleSurface, shares_in, tetrahedron_m
from orchestrator.ports.penetration import Penetrations, ProbedPanel, SurfaceBody
from orchestrator.ports.plans import DeckPlan, PanelPlan
from orchestrator.ports.shape_grid import ShapeGrid

NO_TRIANGLES = np.empty((0, 3), dtype=np.int64)
NO_POINTS = np.empty(0, dtype=np.int64)


@dataclass(frozen=True, kw_only=True)
class SurfacePart:
    """A part of the surface, as far as it is known before anything opens.

    ``drawn_m`` (n, 3) are its surface points as drawn; a panel is drawn straight between its clamps.
    ``triangles`` (m, 3) holds the part's own point numbers.
    """

    name: str
    drawn_m: Array
    triangles: Indices
    material: str


@dataclass(frozen=True, kw_only=True)
class PanelPart(SurfacePart):
    """A panel, seen through the triangles that particles touch.

    ``open`` opens the panel, and returns it with the interpolation that takes its motion to the part's
    points.  The stress-free ``edges`` of the triangles, ``centre_line`` and ``shape``
    (the points of its ``ShapeGrid`` if it is recorded) hold the part's own point numbers, and ``probes``
    those of probes by name.  ``side`` is that of the triangles (``TriangleGrid``).  The last three times
    ``stops`` clamp points belong to beams below the part.
    """

    open: Callable[[], tuple[Panel, Interpolation]]
    edges: Edges
    side: Indices | None
    centre_line: Indices
    shape: Indices
    probes: dict[str, int]
    stops: int


@dataclass(frozen=True, kw_only=True)
class RigidPart(SurfacePart):
    """A wall that ``frame`` carries by the four points ``drawn_m``.

    Its triangles have the numbers of its own ``vertices_m`` (k, 3).
    """

    frame: str
    vertices_m: Array

    def vertices(self, first: int) -> RigidVertices:
        """Return the vertices, whose four points begin with the number ``first``."""
        return RigidVertices(np.full(len(self.vertices_m), first), shares_in(self.drawn_m, self.vertices_m))


def panel_parts(case: Case, stopwatch: Stopwatch, world: Any = None) -> list[PanelPart]:
    """Return a part for each panel, in the order of the case; every rank of ``world`` gets the same parts."""
    plans = panel_plans(case)
    grids = first_rank_does(world, lambda: surface_grids(case))
    return [
        _panel(case, plan, single.table.material, grids[plan.name], stopwatch)
        for plan, single in zip(plans, single_panels(case), strict=True)
    ]


def _panel(
    case: Case, plan: PanelPlan, material: str, touched: TriangleGrid, stopwatch: Stopwatch
) -> PanelPart:
    at = {
        name: np.multiply(probe.at, (plan.rectangle.length_m, plan.rectangle.width_m))
        for name, probe in case.probes.items()
        if probe.panel == plan.name and probe.at is not None
    }
    recorded = ShapeGrid.of(plan.rectangle, case.panel.surface_cells).points_m
    shape_m = recorded if case.output.shapes_s > 0 else np.empty((0, 2))
    coordinates = _with_offsets(touched.coordinates_m, *at.values(), shape_m)
    solver = case.panel.solver
    # load the adapter on every rank, even on ranks without a panel: PETSc starts up collectively
    solvers.adapter("panel", solver).load()

    def open_panel() -> tuple[Panel, Interpolation]:
        own = cast(MeshedPanel, solvers.open_solver("panel", solver, plan))
        if plan.stops:
            own = _on_stops(own, plan)
        panel = TimedPanel(own, f"panel {plan.name} ({solver})", "panel", stopwatch)
        return panel, own.interpolation(coordinates)

    first = len(touched.coordinates_m)
    return PanelPart(
        name=plan.name,
        open=open_panel,
        drawn_m=plan.rectangle.mounted(coordinates),
        probes={name: first + number for number, name in enumerate(at)},
        stops=len(plan.stops),
        triangles=touched.triangles,
        edges=Edges.of(touched.coordinates_m, touched.triangles),
        side=touched.side,
        material=material,
        centre_line=touched.centre_line,
        shape=np.arange(len(coordinates) - len(shape_m), len(coordinates)),
    )


def _with_offsets(touched_m: Array, *observed_m: Array) -> Array:
    """Return the coordinates of all points of a panel, (n, 3) if those that particles touch have an offset;
    points that are only observed have none."""
    observed = np.vstack([np.empty((0, 2)), *observed_m])
    offsets = np.zeros((len(observed), touched_m.shape[1] - 2))
    return np.vstack([touched_m, np.hstack([observed, offsets])])


def _on_stops(panel: MeshedPanel, plan: PanelPlan) -> MeshedPanel:
    from orchestrator.coupling.stopped_panel import StoppedPanel

    try:
        return StoppedPanel(panel, plan)
    except ValueError as error:
        key = ("screen", "panels", plan.name, "stops")
        raise CaseError(
            [CaseProblem(key, str(error), "lower it, or tighten the panel", kind="misplaced")]
        ) from error


def wall_parts(case: Case, case_folder: Path) -> list[RigidPart]:
    """Return a part for each rigid surface."""
    return [
        RigidPart(
            name=wall.name,
            drawn_m=tetrahedron_m(wall.position_m),
            vertices_m=wall.position_m,
            triangles=wall.triangles,
            material=wall.material,
            frame=wall.frame,
        )
        for wall in walls(case, case_folder)
    ]


@dataclass(frozen=True)
class OpenSurface:
    """The open surface of a machine: ``together`` has the points of all parts, part by part.

    The parts are the panels in the case's order and the walls; part i has the points ``surface[i]`` and
    ``clamps[i]`` of the whole.
    """

    case: Case
    panels: list[PanelPart]
    rigid: list[RigidPart]
    together: Panel
    clamps: tuple[slice, ...]

    @staticmethod
    def of(case: Case, case_folder: Path, stopwatch: Stopwatch, world: Any) -> OpenSurface:
        """Open the surface of a case, on every rank of ``world``.

        All rigid parts are one member of the set of panels, and one interpolation maps the whole surface.
        """
        panels = panel_parts(case, stopwatch, world)
        rigid = wall_parts(case, case_folder)
        opened: dict[int, Interpolation] = {}

        def open_member(number: int) -> Panel:
            if number == len(panels):
                panel, opened[number] = _open_rigid(rigid)
            else:
                panel, opened[number] = panels[number].open()
            return panel

        members = PanelSet(len(panels) + 1, open_member, world)
        together = mapped(members, Interpolation.joined(members.exchange(opened)))
        lengths = [part.stop - part.start for part in members.clamps[:-1]]
        lengths += [len(part.drawn_m) for part in rigid]
        return OpenSurface(case, panels, rigid, together, consecutive_slices(lengths))

    @property
    def parts(self) -> list[SurfacePart]:
        """All parts, in the order of their points."""
        return [*self.panels, *self.rigid]

    @property
    def surface(self) -> tuple[slice, ...]:
        """The points of each part in the whole surface."""
        return consecutive_slices([len(part.drawn_m) for part in self.parts])

    def bodies(self) -> list[SurfaceBody]:
        """Return the triangles of every part, in vertices of the whole surface."""
        starts = [points.start for points in self.surface[: len(self.panels)]]
        starts += [of.start + self.surface[-1].stop for of in self._rigid_vertices()]
        return [
            SurfaceBody(part.name, part.triangles + start)
            for part, start in zip(self.parts, starts, strict=True)
        ]

    def _rigid_vertices(self) -> tuple[slice, ...]:
        """Return the vertices of each wall among those of all walls."""
        return consecutive_slices([len(part.vertices_m) for part in self.rigid])

    def rigid_vertices(self) -> RigidVertices:
        """Return the vertices of all walls."""
        points = self.surface[len(self.panels) :]
        each = [part.vertices(at.start) for part, at in zip(self.rigid, points, strict=True)]
        return RigidVertices(
            np.concatenate([NO_POINTS, *(one.first for one in each)]),
            np.concatenate([np.empty((0, 3)), *(one.share for one in each)]),
        )

    def triangle_surface(self) -> TriangleSurface:
        """Return the surface that particles touch, at rest."""
        number = material_numbers(self.case)
        return TriangleSurface(
            self.together.initial().surface.position_m,
            np.concatenate([NO_TRIANGLES, *(body.triangles for body in self.bodies())]),
            np.concatenate(
                [NO_POINTS, *(np.full(len(part.triangles), number[part.material]) for part in self.parts)]
            ),
            self.panel_of_triangle(),
            self.rigid_vertices(),
            self._sides(),
        )

    def _sides(self) -> Indices | None:
        """Return the side of its panel on which each triangle is; None where no panel has a depth."""
        if all(panel.side is None for panel in self.panels):
            return None
        given = [panel.side for panel in self.panels] + [None for _ in self.rigid]
        each = [
            np.full(len(part.triangles), UPPER) if side is None else side
            for part, side in zip(self.parts, given, strict=True)
        ]
        return np.asarray(np.concatenate(each))

    def panel_of_triangle(self) -> Indices:
        """Return the number of each triangle's panel; -1 for walls."""
        numbers = [*range(len(self.panels)), *(-1 for _ in self.rigid)]
        return np.repeat(np.array(numbers, dtype=np.int64), [len(part.triangles) for part in self.parts])

    def panel_points(self) -> tuple[PanelPoints, ...]:
        """Return the places of the panels' points; the first clamp extends up to the middle of the span."""
        return tuple(
            self._points_of(part, single, surface, clamps)
            for part, single, surface, clamps in zip(
                self.panels, single_panels(self.case), self.surface, self.clamps, strict=False
            )
        )

    def _points_of(self, part: PanelPart, single: SinglePanel, surface: slice, clamps: slice) -> PanelPoints:
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

    def deck(self) -> DeckPlan | None:
        """Return the plan of the deck whose contacts with particles are counted; None without such a deck."""
        lines = [
            points.start + part.centre_line for part, points in zip(self.panels, self.surface, strict=False)
        ]
        drawn_m = [part.drawn_m[part.centre_line] for part in self.panels]
        return deck_plan(self.case, self.together.initial().surface.position_m, lines, drawn_m)

    def penetrations(self) -> Penetrations:
        """Return the search for panels that penetrate a body of triangles.

        Points of a panel that a clamp or a stop holds do not count.
        """
        singles = zip(single_panels(self.case), self.panels, self.surface, strict=False)
        probed = [
            ProbedPanel(number, points.start + _free_pairs(single, part), single.table.thickness_m)
            for number, (single, part, points) in enumerate(singles)
        ]
        drawn_m = np.concatenate([np.empty((0, 3)), *(part.drawn_m for part in self.parts)])
        return Penetrations(drawn_m, self.bodies(), probed, self.rigid_vertices())

    def probes(self) -> tuple[PlacedProbe, ...]:
        """Return the case's probes."""
        number = {name: place for place, name in enumerate(self.case.screen.frames)}
        on_panels = {
            name: points.start + point
            for part, points in zip(self.panels, self.surface, strict=False)
            for name, point in part.probes.items()
        }
        placed = []
        for name, probe in self.case.probes.items():
            if probe.particle is not None:
                placed.append(PlacedProbe(name, "particle", probe.particle))
            elif probe.frame is not None and probe.point_m is not None:
                centre_m = self.case.screen.frames[probe.frame].recorded_point_m
                arm_m = to_world(self.case, np.subtract(probe.point_m, centre_m))
                placed.append(PlacedProbe(name, "frame", number[probe.frame], arm_m))
            else:
                placed.append(PlacedProbe(name, "surface", on_panels[name]))
        return tuple(placed)


def _free_pairs(single: SinglePanel, part: PanelPart) -> Indices:
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


def _open_rigid(parts: list[RigidPart]) -> tuple[Panel, Interpolation]:
    """Open the points of all walls as one surface; return it with the identity as its mapping."""
    points_m = np.concatenate([np.empty((0, 3)), *(part.drawn_m for part in parts)])
    frames = tuple(part.frame for part in parts for _ in part.drawn_m)
    surface = import_module("adapters.panel.common.carried").build(points_m, frames)
    return cast(Panel, surface), Interpolation.on_surface(csr_array(identity(len(points_m))))
