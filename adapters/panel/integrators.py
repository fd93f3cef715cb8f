"""Which time integrator a plan asks for, and the largest step it takes."""

from __future__ import annotations

from adapters.panel.elastic_panel import Integrator
from adapters.panel.explicit import Explicit
from adapters.panel.structure import Structure
from adapters.panel.tangent import Tangent
from orchestrator.plans import PanelPlan

# Shares of the step at which small vibrations about the resting shape become unstable: the first
# leaves room for stiffening in motion, the second is what step_s = 0 takes.
STABLE_SHARE = 0.9
USUAL_SHARE = 0.8


def choose(plan: PanelPlan, structure: Structure, tangent: Tangent) -> Integrator:
    """The integrator of ``plan`` for a structure that stands in its resting shape."""
    largest = largest_step_s(plan, tangent)
    if plan.step_s > largest:
        raise ValueError(
            f"panel {plan.name}: step_s = {plan.step_s} is above the limit of {largest:.3g} s; "
            f"use {USUAL_SHARE / STABLE_SHARE * largest:.2g} or 0 (the solver's own choice)"
        )
    return Explicit(structure, plan.step_s or largest * USUAL_SHARE / STABLE_SHARE)


def largest_step_s(plan: PanelPlan, tangent: Tangent) -> float:
    """Largest step for the structure in its present shape.

    Maxwell branches answer fast changes like springs and raise the stiffness by their ratios.
    """
    if plan.integrator != "explicit":
        raise ValueError(f"panel {plan.name}: no integrator {plan.integrator!r}")
    stiffening = 1.0 + sum(ratio for ratio, _ in plan.material.branches)
    limit_s: float = STABLE_SHARE * 2.0 / (tangent.highest_frequency_rad_s() * stiffening**0.5)
    return limit_s
