"""The highest frequency with which a panel's mesh vibrates, as its solver tells."""

from __future__ import annotations

import math

from orchestrator.case import solvers
from orchestrator.case.deck.panels import single_panels
from orchestrator.case.planning import panel_plans
from orchestrator.case.tables.case import Case
from orchestrator.ports.plans import SolverFailed, SolverMissing

STEPPED = 2 * math.sqrt(2) / math.pi
"""Frequency over the one that velocity Verlet's steps make of it, at worst: two steps to half a
period.  Steps of h turn w into (2 / h) arcsin(w h / 2)."""


def largest_steps_s(case: Case) -> dict[str, float]:
    """Name of each row of panels -> largest step of its solver; empty where that is not limited by
    stability.  Raises SolverMissing, and SolverFailed where no resting shape is found."""
    limit = solvers.panel(case).largest_step_s
    if limit is None or case.panel.integrator != "explicit":
        return {}
    rows = {
        single.table_name: plan for single, plan in zip(single_panels(case), panel_plans(case), strict=True)
    }
    return {name: float(limit(plan)) for name, plan in rows.items()}


def highest_rad_per_s(case: Case) -> tuple[dict[str, float], str]:
    """Name of each row of panels -> highest frequency that its steps make; and why not, if none.

    Implicit steps longer than the mesh's periods have none that matters here: their phase
    stays below half a turn."""
    try:
        steps_s = largest_steps_s(case)
    except (SolverMissing, SolverFailed) as error:
        return {}, str(error)
    return {name: 2 / step_s / STEPPED for name, step_s in steps_s.items()}, ""
