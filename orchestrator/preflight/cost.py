"""What a run will take: processor time of the whole of it, part by part, before anything runs.

The parts are those of ``wall_by_part_s``.  Solvers' shares are asked of their adapters
(``ports/plans``); what the orchestrator does itself has its constants here.  All were
measured on drafts of shipped cases on one core of a 2-core AMD EPYC machine, busy with other work;
``python -m tools.cost_series`` measures what was predicted over what was taken.  How long material
stays on the deck is known after the run only: the estimate lies between a thin dry layer and a
thick wet one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from orchestrator.case.bed.adhesion import adhesion_law
from orchestrator.case.bed.contact_times import smallest_diameters_m
from orchestrator.case.bed.size_distribution import mean_mass_kg
from orchestrator.case.bed.sources import initial_particles, inlets
from orchestrator.case.deck.panels import TRANSPORT_M_S, single_panels, stay_s
from orchestrator.case.deck.triangle_grid import surface_grids
from orchestrator.case.solver_plans import material_numbers, mesh_sizes, particle_step_s
from orchestrator.case.tables.case import Case, has_particles
from orchestrator.ports.clock import steps_in
from orchestrator.ports.physics import sphere_mass_kg
from orchestrator.ports.plans import Cost, FramesWork, PanelsWork, ParticlesWork, SolverMissing
from orchestrator.preflight.stability.report import case_with_scheme

IMPORT_S = 1.2
"""Starting Python, reading and checking the case."""
MESHED_S = 1e-4
"""Of a triangle that particles may touch."""
INTERVAL_S = {"rest": 3e-5, "monitor": 3.5e-5, "coupling": 6e-5, "mapping": 6e-5}
"""Of any sync interval; with particles twice as much but for the mapping."""
TRIANGLE_S = {"monitor": 1e-8, "coupling": 3e-8, "mapping": 5e-8}
"""Of any that particles may touch, and an interval."""
MAPPED_PANEL_S = 4.5e-5
TRIED_S = 1.5e-4
"""Saving, taking back and deciding, of an interval that is tried."""
STOPPED_PANEL_S = 2.5e-4
"""Of a panel over beams and an interval."""
ROW_S, ROW_PANEL_S, ROW_BODY_S = 1.5e-4, 6e-5, 5e-5
"""Of the time series."""
OUTPUT_S, OUTPUT_BED_S, OUTPUT_PARTICLE_S, OUTPUT_TRIANGLE_S = 8e-3, 5e-3, 6e-6, 2e-7
"""Of an output time."""
SAVE_S = 0.04
"""At the end."""


@dataclass(frozen=True)
class BedDensity:
    """How fast material moves along the deck."""

    transport_m_per_s: float


THICK = BedDensity(transport_m_per_s=TRANSPORT_M_S)
THIN = BedDensity(transport_m_per_s=1.5)
"""Level dry of cases/ffs0827-slice: single dry particles, thrown."""
TIMES = 2000  # places in time at which particles are counted


@dataclass(frozen=True)
class BedCost:
    """Particles at most and on average, and the particles' steps."""

    most: float
    mean: float
    steps: int

    @property
    def particle_steps(self) -> float:
        return self.mean * self.steps


def bed_cost(case: Case, at_start: int, bed: BedDensity) -> BedCost:
    """With ``at_start`` particles at t = 0, which leave as others do where there are exits."""
    time_s = np.linspace(0.0, case.duration_s, TIMES)
    stays_s = stay_s(case, bed.transport_m_per_s)
    count = np.where(time_s < stays_s, float(at_start), 0.0)
    for inlet in inlets(case, material_numbers(case)).values():
        per_kg = 1.0 / mean_mass_kg(inlet.sizes, inlet.density_kg_per_m3)
        there_kg = [inlet.due_kg(t) - inlet.due_kg(t - stays_s) for t in time_s]
        count += per_kg * np.array(there_kg)
    steps = math.ceil(case.duration_s / particle_step_s(case))
    return BedCost(float(count.max()), float(count.mean()), steps)


@dataclass(frozen=True)
class Tries:
    """How often an interval is run on average, by the particles and by the panels; ``point_s`` is
    the processor time in which the scheme looks for the way of a point of the surface."""

    particles: float
    panel: float
    point_s: float = 0.0


RUNS = {
    "particles-first": Tries(1.0, 1.0),
    "serial-staggered": Tries(1.0, 1.0),
    "robin": Tries(1.0, 2.0, 1.1e-6),
    "aitken": Tries(2.0, 3.0),
    "quasi-newton": Tries(2.0, 3.0),
}
"""Measured over whole runs of quickstart, draft; repeated intervals end with the panels under the
load that was found."""


def predicted_parts_s(case: Case, at_start: int, bed: BedDensity = THICK) -> dict[str, float]:
    """Processor time by part, "start" first (importing, which no wall time counts), of a run with
    ``at_start`` particles at t = 0 in ``bed``.  Pictures and the report are made apart."""
    case = case_with_scheme(case)
    intervals = case.duration_s / case.coupling.sync_interval_s
    panels, particles = len(single_panels(case)), has_particles(case)
    tries = RUNS[case.coupling.scheme] if particles else RUNS["particles-first"]
    mean = bed_cost(case, at_start, bed).mean if particles else 0.0
    of_particles = case.particles.adapter
    costs = {
        "particles": of_particles.cost(_particles(case, mean, tries.particles))
        if of_particles is not None
        else Cost(0.0, 0.0),
        "panel": case.panel.adapter.cost(_panels(case, tries.panel)),
        "frames": case.frames.adapter.cost(_frames(case)),
    }
    triangles = _triangles(case) if particles else 0
    found = {"start": IMPORT_S + MESHED_S * triangles} | {
        part: cost.stepping_s for part, cost in costs.items()
    }
    twice = 1 + particles
    for part, each_s in INTERVAL_S.items():
        found[part] = intervals * (twice * each_s + TRIANGLE_S.get(part, 0.0) * triangles)
    mapped_s = INTERVAL_S["mapping"] + MAPPED_PANEL_S * panels + TRIANGLE_S["mapping"] * triangles
    found["mapping"] = tries.panel * intervals * mapped_s
    searched_s = tries.point_s * triangles / 2  # there are half as many points
    found["coupling"] += (TRIED_S * (tries.panel - 1) + searched_s) * intervals
    found["panel"] += tries.panel * intervals * STOPPED_PANEL_S * _stopped(case)
    found["rest"] += sum(cost.opening_s for cost in costs.values())
    return found | {"output": _output_s(case, panels, mean), "saves": SAVE_S}


def predicted_s(case: Case, at_start: int, bed: BedDensity = THICK) -> float:
    """Processor time of the whole run."""
    return sum(predicted_parts_s(case, at_start, bed).values())


def particles_at_start(case: Case) -> int:
    """How many there are at t = 0."""
    return len(initial_particles(case, material_numbers(case))) if has_particles(case) else 0


def predicted_range_s(case: Case, at_start: int) -> tuple[dict[str, float], dict[str, float]]:
    """``predicted_parts_s`` of a thin layer that is thrown and of a thick bed that creeps; alike
    where nothing is fed."""
    thin, thick = (predicted_parts_s(case, at_start, bed) for bed in (THIN, THICK))
    return thin, thick


def in_words(time_s: float) -> str:
    """A time to be read: in seconds below two minutes, in minutes below two hours, in hours below
    two days, else in days."""
    if time_s < 120:
        return f"{time_s:.0f} s"
    if time_s < 7200:
        return f"{time_s / 60:.0f} min"
    return f"{time_s / 3600:.0f} h" if time_s < 172_800 else f"{time_s / 86_400:.0f} days"


def _panels(case: Case, runs: float) -> PanelsWork:
    solver, interval_s = case.panel, case.coupling.sync_interval_s
    return PanelsWork(
        len(single_panels(case)),
        solver.cells,
        sum(size.cells for size in mesh_sizes(case).values()),
        solver.integrator,
        solver.step_s,
        interval_s,
        runs * case.duration_s / interval_s,
    )


def _frames(case: Case) -> FramesWork:
    screen, interval_s = case.screen, case.coupling.sync_interval_s
    return FramesWork(
        len(screen.frames),
        sum(frame.drive is not None for frame in screen.frames.values()),
        sum(len(bushing.positions_m) for bushing in screen.bushings.values()),
        len(screen.exciters),
        sum(exciter.motor is not None for exciter in screen.exciters.values()),
        interval_s,
        case.duration_s / interval_s,
    )


def _particles(case: Case, mean: float, runs: float) -> ParticlesWork:
    if not has_particles(case):
        return ParticlesWork(0.0, 0.0, 0.0, 0, False)
    interval_s = case.coupling.sync_interval_s
    steps = runs * math.ceil(case.duration_s / interval_s) * steps_in(interval_s, particle_step_s(case))
    intervals = case.duration_s / interval_s
    sticky = adhesion_law(case) != "none"
    return ParticlesWork(mean * steps, steps, runs * intervals, _triangles(case), sticky)


def _triangles(case: Case) -> int:
    """That particles may touch on panels; as many as without openings where no mesher is there."""
    try:
        return sum(len(grid.triangles) for grid in surface_grids(case).values())
    except SolverMissing:
        along, across = case.panel.surface_cells
        return 2 * along * across * len(single_panels(case))


def _stopped(case: Case) -> int:
    return sum(bool(panel.table.stops) for panel in single_panels(case))


def _output_s(case: Case, panels: int, particles: float) -> float:
    rows = case.duration_s / (case.output.series_s or case.coupling.sync_interval_s)
    times = case.duration_s / case.output.interval_s
    row_s = ROW_S + ROW_PANEL_S * panels + ROW_BODY_S * len(case.screen.frames)
    output_s = OUTPUT_S + OUTPUT_TRIANGLE_S * _triangles(case)
    output_s += OUTPUT_BED_S * has_particles(case) + OUTPUT_PARTICLE_S * particles
    return rows * row_s + times * output_s


@dataclass(frozen=True)
class Effort:
    """An interval is solved when the load that the particles give differs from the one that the
    panel moved under by at most ``tolerance`` of its size, or by ``floor_N``; sizes are Euclidean
    norms over all surface points.  It is run at most ``most`` times."""

    tolerance: float = 1e-3
    floor_N: float = 0.0
    most: int = 20


def effort(case: Case) -> Effort:
    """What a case asks for; the floor is the tolerance of the lightest particle's weight."""
    tolerance = case.coupling.tolerance
    lightest_kg = min(
        (
            float(sphere_mass_kg(np.array(diameter_m), case.materials[name].density_kg_per_m3))
            for name, diameter_m in smallest_diameters_m(case).items()
        ),
        default=0.0,
    )
    weight_N = lightest_kg * float(np.linalg.norm(case.gravity_m_per_s2))
    return Effort(tolerance, tolerance * weight_N, case.coupling.most_iterations)
