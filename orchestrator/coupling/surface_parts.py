"""The parts of the surface: panels, walls, and points that are only looked at.

Each part is a ``Panel`` to the coupling: a finite-element panel seen through the particles'
triangles, a wall that a frame carries, or points on a frame that nothing touches.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import Any, cast

import numpy as np

from orchestrator.case import solvers
from orchestrator.case.deck.panels import Wall, single_panels, to_world, walls
from orchestrator.case.deck.triangle_grid import TriangleGrid, surface_grids
from orchestrator.case.file.errors import CaseError, CaseProblem
from orchestrator.case.playback import playbacks
from orchestrator.case.solver_plans import panel_plans
from orchestrator.case.tables.case import Case
from orchestrator.coupling.mapping import mapped
from orchestrator.coupling.metered import Stopwatch, meter_panel
from orchestrator.coupling.mpi import first_rank_does
from orchestrator.ports import Array, Indices, MeshedPanel, Panel
from orchestrator.ports.geometry import Edges
from orchestrator.ports.plans import PanelPlan
from orchestrator.ports.recording import RecordedGrid


def _nothing(*shape: int) -> Callable[[], Indices]:
    return lambda: np.empty(shape, dtype=np.int64)


@dataclass(frozen=True)
class SurfacePart:
    """One part of the surface: how to open it, and what is known of its points before.

    ``drawn_m`` (n, 3) are its surface points as they are drawn, a panel's straight between its
    clamps.  ``triangles`` (m, 3), their stress-free ``edges``, ``centre_line`` and ``shape`` (the
    points of its ``RecordedGrid``, where it is recorded) hold the part's own point numbers;
    ``points`` maps the names of points looked at (probes, centres of mass) to their numbers.  The
    last three times ``stops`` of its clamps are points of beams below it.
    """

    name: str
    open: Callable[[], Panel]
    drawn_m: Array
    points: dict[str, int]
    triangles: Indices = field(default_factory=_nothing(0, 3))
    edges: Edges = field(default_factory=lambda: Edges.of(np.empty((0, 2)), _nothing(0, 3)()))
    material: str = ""
    centre_line: Indices = field(default_factory=_nothing(0))
    shape: Indices = field(default_factory=_nothing(0))
    stops: int = 0


def panel_parts(case: Case, case_folder: Path, stopwatch: Stopwatch, world: Any = None) -> list[SurfacePart]:
    """Returns one part per panel, in the order of the case, alike on every rank of ``world``."""
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
    # on every rank, also on those that will own no panel: PETSc starts up collectively
    solvers.adapter("panel", solver).load()

    def opened() -> Panel:
        own = cast(MeshedPanel, solvers.opened("panel", solver, plan))
        if plan.stops:
            own = _on_stops(own, plan)
        panel = meter_panel(own, f"panel {plan.name} ({solver})", "panel", stopwatch)
        return mapped(panel, own.interpolation(coordinates))

    first = len(touched.coordinates_m)
    return SurfacePart(
        name=plan.name,
        open=opened,
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
    """Returns one part per rigid surface."""

    def part(wall: Wall) -> SurfacePart:
        opened = carried(wall.position_m, wall.frame)
        place_m = wall.position_m
        return SurfacePart(wall.name, opened, place_m, {}, wall.triangles, material=wall.material)

    return [part(wall) for wall in walls(case, case_folder)]


def frame_parts(case: Case) -> list[SurfacePart]:
    """Returns one part per frame: its centre of mass (under the frame's name), the ends of three arms of
    1 m from there along the world's axes, which tell its rotation, and its probes."""
    return [_looked_at(case, name) for name in case.screen.frames]


def _looked_at(case: Case, frame: str) -> SurfacePart:
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
    """Returns a call that opens a rigid surface of points (n, 3) that ``frame`` carries."""
    made = "adapters.panel.common.carried"
    return lambda: cast(Panel, import_module(made).build(position_m, frame))
