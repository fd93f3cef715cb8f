"""The cost of a run: an estimate of its processor time, part by part, before anything runs.

The parts are the same as in ``wall_by_part_s``, but what a scheme lets solvers repeat is in their own parts.
Adapters estimate the shares of their solvers (``ports/plans.py``), and the constants here estimate the
orchestrator's own work.  All constants were measured on drafts of shipped cases on an idle 2-core AMD EPYC
machine; on a busy one runs take up to twice as long.  ``python -m tools.cost_series`` compares predicted with
measured times.  Only a run tells how long material stays on the deck, so the estimate is a range from a thin
dry layer to a thick wet one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from orchestrator.case.bed.adhesion import adhesion_law
from orchestrator.case.bed.size_distribution import mean_mass_kg
from orchestrator.case.bed.sources import initial_particles, inlets
from orchestrator.case.deck.panels import TRANSPORT_M_PER_S, single_panels, stay_s, walls
from orchestrator.case.deck.triangle_grid import surface_grids
from orchestrator.case.solver_plans import air_plan, mesh_sizes, particle_step_s
from orchestrator.case.tables.case import Case, has_particles
from orchestrator.ports.clock import steps_in
from orchestrator.ports.plans import FramesWork, PanelsWork, ParticlesWork, SolverMissing
from orchestrator.preflight.stability.report import case_with_scheme

IMPORT_S = 0.6
"""Time to start Python, and to read and check the case."""
MESHED_S = 2e-5
"""Time to mesh a triangle that particles may touch."""
RIGID_S = 4.7e-5
"""Time to read, check and list a triangle of a rigid surface, whose intervals cost nothing."""
INTERVAL_S = {"rest": 1.5e-5, "monitor": 1.5e-5, "coupling": 2e-5, "mapping": 1.2e-5}
"""Time per sync interval of each part; particles double it."""
TRIANGLE_S = {"monitor": 9e-9, "coupling": 1.1e-8, "mapping": 1.8e-8}
"""Time per sync interval and triangle that particles may touch; for the mapping, in each try."""
TRIED_S = 5e-5
"""Time to save, take back and decide about an interval that a scheme tries."""
STOPPED_PANEL_S = 1.2e-4
"""Time per sync interval of a panel over beams."""
ROW_S, ROW_PANEL_S, ROW_BODY_S = 2.4e-5, 9e-6, 8e-6
"""Time per row of the time series: in all, per panel, and per frame."""
OUTPUT_S, OUTPUT_BED_S, OUTPUT_PARTICLE_S, OUTPUT_TRIANGLE_S = 4e-3, 2.5e-3, 3e-6, 1e-7
"""Time per output time: in all, with particles, per particle, and per triangle."""
CHECKPOINT_S = 0.02
"""Time to save the checkpoint at the end."""


THICK, THIN = TRANSPORT_M_PER_S, 1.5
"""Speeds in m/s at which material moves along the deck: a thick bed creeps, and single dry particles
are thrown (level dry of cases/ffs0827-slice)."""
TIMES = 2000  # number of moments at which particles are counted


@dataclass(frozen=True)
class BedCost:
    """The largest and the mean number of particles in a run, and the number of the particles' steps."""

    most: float
    mean: float
    steps: int

    @property
    def particle_steps(self) -> float:
        """The steps of all single particles together."""
        return self.mean * self.steps


def bed_cost(case: Case, at_start: int, transport_m_per_s: float) -> BedCost:
    """Return the cost of a bed with ``at_start`` particles at t = 0.

    If the case has exits, all particles leave after the time that the deck takes to carry them over.
    """
    time_s = np.linspace(0.0, case.duration_s, TIMES)
    stays_s = stay_s(case, transport_m_per_s)
    count = np.where(time_s < stays_s, float(at_start), 0.0)
    for inlet in inlets(case).values():
        there_kg = [inlet.due_kg(t) - inlet.due_kg(t - stays_s) for t in time_s]
        count += np.array(there_kg) / mean_mass_kg(inlet.sizes, inlet.grain)
    interval_s = case.coupling.sync_interval_s
    steps = steps_in(case.duration_s, interval_s) * steps_in(interval_s, particle_step_s(case))
    return BedCost(float(count.max()), float(count.mean()), steps)


class Tries(NamedTuple):
    """The mean number of times that particles and panels run an interval under a scheme.

    ``point_s`` is the scheme's own processor time per interval and point of the surface.
    """

    particles: float = 1.0
    panel: float = 1.0
    point_s: float = 0.0


TRIES = {
    "particles-first": Tries(),
    "serial-staggered": Tries(),
    "aitken": Tries(2.0, 3.0),
    "quasi-newton": Tries(2.0, 3.0),
    "robin": Tries(1.0, 2.0, 4.5e-7),
}
"""Tries by scheme, measured over whole runs of quickstart, draft.  Schemes that repeat intervals run the
panels once more, under the load on which they have settled."""


class RankShare(NamedTuple):
    """The shares of the panels' and of the particles' work that one rank has; 1 in a run of one process.

    The rest of the work is done by every rank, or by the first while the others wait.
    """

    panels: float = 1.0
    particles: float = 1.0


WHOLE = RankShare()


def predicted_parts_s(
    case: Case, at_start: int, transport_m_per_s: float = THICK, share: RankShare = WHOLE, rigid: int = 0
) -> dict[str, float]:
    """Return the processor time by part, on a rank with a ``share`` of the work, of a run with ``at_start``
    particles at t = 0 and ``rigid`` triangles of rigid surfaces.

    The first part, "start", is the time of imports, which no wall time counts.  Pictures and the
    report are not included.
    """
    case = case_with_scheme(case)
    intervals = case.duration_s / case.coupling.sync_interval_s
    panels, particles = single_panels(case), has_particles(case)
    tries = TRIES[case.coupling.scheme] if particles else Tries()
    mean = bed_cost(case, at_start, transport_m_per_s).mean if particles else 0.0
    triangles = surface_triangles(case) if particles else 0
    costs = {
        "panel": case.panel.adapter.cost(_panels_work(case, tries.panel * intervals, share.panels)),
        "frames": case.frames.adapter.cost(_frames_work(case, intervals)),
    }
    if particles and case.particles.adapter is not None:
        work = _particles_work(case, share.particles * mean, tries.particles, triangles)
        costs["particles"] = case.particles.adapter.cost(replace(work, thrown=transport_m_per_s >= THIN))
    parts_s = {"start": IMPORT_S + MESHED_S * triangles + RIGID_S * rigid, "particles": 0.0}
    parts_s |= {part: cost.stepping_s for part, cost in costs.items()}
    for part, each_s in INTERVAL_S.items():
        times = tries.panel if part == "mapping" else 1.0
        parts_s[part] = intervals * ((1 + particles) * each_s + times * TRIANGLE_S.get(part, 0.0) * triangles)
    searched_s = tries.point_s * triangles / 2  # there are half as many points
    parts_s["coupling"] += (TRIED_S * (tries.panel - 1) + searched_s) * intervals
    stopped = sum(bool(panel.table.stops) for panel in panels)
    parts_s["panel"] += tries.panel * intervals * STOPPED_PANEL_S * stopped * share.panels
    parts_s["rest"] += sum(cost.opening_s for cost in costs.values())
    return parts_s | {"output": _output_s(case, mean), "checkpoints": CHECKPOINT_S}


def predicted_s(case: Case, at_start: int) -> float:
    """Return the processor time of the whole run: with a thin bed if it is fed and dry, else with a thick
    one."""
    return sum(predicted_parts_s(case, at_start, likely_transport_m_per_s(case, at_start)).values())


def likely_transport_m_per_s(case: Case, at_start: int) -> float:
    """Return the speed ``THIN`` if all particles are fed and none sticks, else ``THICK``."""
    return THIN if at_start == 0 and case.bed.feeds and adhesion_law(case) == "none" else THICK


def particles_at_start(case: Case) -> int:
    """Return the number of particles at t = 0."""
    return len(initial_particles(case)) if has_particles(case) else 0


def in_words(time_s: float) -> str:
    """Return a time as text: in s below two minutes, min below two hours, h below two days, else days."""
    for unit, unit_s, end_s in (("s", 1, 120), ("min", 60, 7200), ("h", 3600, 172_800)):
        if time_s < end_s:
            return f"{time_s / unit_s:.0f} {unit}"
    return f"{time_s / 86_400:.0f} days"


def _panels_work(case: Case, runs: float, share: float) -> PanelsWork:
    return PanelsWork(
        panels=round(share * len(single_panels(case))),
        cells=case.panel.cells,
        resolved_cells=round(share * sum(size.cells for size in mesh_sizes(case).values())),
        integrator=case.panel.integrator,
        step_s=case.panel.step_s,
        interval_s=case.coupling.sync_interval_s,
        runs=runs,
    )


def _frames_work(case: Case, runs: float) -> FramesWork:
    screen = case.screen
    return FramesWork(
        bodies=len(screen.frames),
        driven=sum(frame.drive is not None for frame in screen.frames.values()),
        bushings=sum(len(bushing.positions_m) for bushing in screen.bushings.values()),
        exciters=len(screen.exciters),
        motors=sum(exciter.motor is not None for exciter in screen.exciters.values()),
        interval_s=case.coupling.sync_interval_s,
        runs=runs,
    )


def _particles_work(case: Case, mean: float, tries: float, triangles: int) -> ParticlesWork:
    interval_s = case.coupling.sync_interval_s
    intervals, step_s = case.duration_s / interval_s, particle_step_s(case)
    steps = tries * math.ceil(intervals) * steps_in(interval_s, step_s)
    return ParticlesWork(
        particle_steps=mean * steps,
        steps=steps,
        runs=tries * intervals,
        triangles=triangles,
        sticky=adhesion_law(case) != "none",
        spheres_each=_spheres_each(case),
        in_air=air_plan(case) is not None,
    )


def _spheres_each(case: Case) -> float:
    """Return the mean number of spheres of all particles that the case has or feeds, by number."""
    start = initial_particles(case)
    number, spheres = float(len(start)), float(np.sum(start.grains.sphere_count)) if len(start) else 0.0
    for inlet in inlets(case).values():
        fed = inlet.due_kg(case.duration_s) / mean_mass_kg(inlet.sizes, inlet.grain)
        number, spheres = number + fed, spheres + fed * float(inlet.grain.sphere_count)
    return spheres / number if number else 1.0


def surface_triangles(case: Case) -> int:
    """Return the number of triangles of panels, which without a mesher is counted without openings."""
    try:
        return sum(len(grid.triangles) for grid in surface_grids(case).values())
    except SolverMissing:
        along, across = case.panel.surface_cells
        return 2 * along * across * len(single_panels(case))


def rigid_triangles(case: Case, folder: Path) -> list[int]:
    """Return the numbers of triangles of a case's rigid surfaces.  Raises stl.UnreadableSurface."""
    return [len(wall.triangles) for wall in walls(case, folder)]


def _output_s(case: Case, particles: float) -> float:
    rows = case.duration_s / (case.output.series_s or case.coupling.sync_interval_s)
    row_s = ROW_S + ROW_PANEL_S * len(single_panels(case)) + ROW_BODY_S * len(case.screen.frames)
    output_s = OUTPUT_S + OUTPUT_TRIANGLE_S * surface_triangles(case)
    output_s += OUTPUT_BED_S * has_particles(case) + OUTPUT_PARTICLE_S * particles
    return rows * row_s + case.duration_s / case.output.interval_s * output_s
