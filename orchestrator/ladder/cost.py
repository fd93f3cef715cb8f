"""What a rung will take: rough rates, for deciding before anything runs.

Processor time on one core of a 2-core machine, busy with other work; good to a factor of three.
"""

from __future__ import annotations

import math

from orchestrator.bed.cost import THICK, cost
from orchestrator.bed.particle_step import particle_step_s
from orchestrator.bed.sources import initial_particles
from orchestrator.casefile.case import Case
from orchestrator.casefile.contents import has_particles
from orchestrator.deck.panel_meshes import mesh_sizes
from orchestrator.deck.panels import single_panels
from orchestrator.planning import material_numbers

START_S = 5.0
PER_INTERVAL_S = 1e-3  # coupling, mapping and output
PER_PANEL_INTERVAL_S = {
    "rigid": 1e-4,
    "recorded": 2e-4,
    "strip": 5e-4,
    "sheet": 3e-4,
    "solid": 0.05,
}
SHEET_CELL_S_S = 2.3 / 176 / 22  # per cell, simulated second and cell along, for the step
SOLID_CELL_INTERVAL_S = 0.03 / 33 / 2
SPHERE_STEP_S = 3e-5


def predicted_s(case: Case, at_start: int) -> float:
    """Processor time of a run, with ``at_start`` particles at t = 0."""
    intervals = case.duration_s / case.coupling.sync_interval_s
    along, across = case.panel.cells
    panels = len(single_panels(case))
    panels_s = panels * PER_PANEL_INTERVAL_S[case.panel.solver] * intervals
    if case.panel.solver == "sheet":
        panels_s += panels * SHEET_CELL_S_S * along * across * along * case.duration_s
    if case.panel.solver == "solid":
        resolved = sum(size.cells for size in mesh_sizes(case).values())
        cells = resolved or panels * along * across
        panels_s += SOLID_CELL_INTERVAL_S * cells * intervals
    return START_S + PER_INTERVAL_S * intervals + panels_s + _particles_s(case, at_start)


def particles_at_start(case: Case) -> int:
    """How many there are at t = 0."""
    return len(initial_particles(case, material_numbers(case))) if has_particles(case) else 0


def _particles_s(case: Case, at_start: int) -> float:
    if not has_particles(case):
        return 0.0
    if case.particles.solver == "spheres":
        return SPHERE_STEP_S * at_start * math.ceil(case.duration_s / particle_step_s(case))
    return cost(case, at_start, THICK).processor_s
