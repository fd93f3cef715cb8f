"""How many more particles a run has than the study's, where feeds fill the deck on after that.

The particles' share of the time goes with their number; how long they stay on the deck is an
assumption, as in ``flipflow check`` (bed/cost.py).
"""

from __future__ import annotations

from collections.abc import Callable

from orchestrator.case.bed.sources import initial_particles
from orchestrator.case.planning import material_numbers
from orchestrator.case.tables.case import Case
from orchestrator.preflight.bed_cost import THICK, THIN, bed_cost


def filling(case: Case, study_s: float) -> Callable[[float], float]:
    """For a run of so many seconds: its particles, in the mean over the run, relative to those of a
    run of ``study_s``."""
    if not case.bed.feeds:
        return lambda duration_s: 1.0
    bed = THIN if case.particles.adhesion == "none" else THICK
    at_start = len(initial_particles(case, material_numbers(case)).diameter_m)

    def mean(duration_s: float) -> float:
        return bed_cost(case.model_copy(update={"duration_s": duration_s}), at_start, bed).mean

    of_study = mean(study_s)
    return lambda duration_s: mean(duration_s) / of_study if of_study else 1.0
