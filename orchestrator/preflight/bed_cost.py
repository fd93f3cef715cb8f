"""How many particles a run has at a time, and their steps, which is most of what it costs.

An estimate for deciding where to run a case, between a thin dry layer and a thick wet one: how
long material stays on the deck is known after the run only.  What that takes:
orchestrator/preflight/cost.py.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from orchestrator.case.bed.particle_sizes import mean_mass_kg
from orchestrator.case.bed.particle_step import particle_step_s
from orchestrator.case.bed.sources import inlets
from orchestrator.case.bed.transport import TRANSPORT_M_S, stay_s
from orchestrator.case.planning import material_numbers
from orchestrator.case.tables.case import Case


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
