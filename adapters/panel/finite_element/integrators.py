"""Which step a plan's time integrator takes, and the largest that it may."""

from __future__ import annotations

from adapters.panel.finite_element.tangent import Tangent
from orchestrator.ports.plans import PanelPlan

# Explicit: shares of the step at which small vibrations about the resting shape become unstable.
# The first leaves room for stiffening in motion, the second is what step_s = 0 takes.
STABLE_SHARE = 0.95
USUAL_SHARE = 0.85
# Implicit: no stability limit, but accuracy (docs/theory/panel_sheet.md).
COARSEST_STEP_S = 1e-3
USUAL_STEP_S = 2e-4


def step_s(plan: PanelPlan, tangent: Tangent) -> float:
    """The step of ``plan``'s integrator for a structure that stands in its resting shape.

    ValueError if there is no such integrator or ``plan.step_s`` is too large for it.
    """
    largest, usual = _limits_s(plan, tangent)
    if plan.step_s > largest:
        raise ValueError(
            f"panel {plan.name}: step_s = {plan.step_s} is above the limit of {largest:.3g} s; "
            f"use {usual:.2g} or 0 (the solver's own choice)"
        )
    return plan.step_s or usual


def largest_step_s(plan: PanelPlan, tangent: Tangent) -> float:
    """The largest step for the structure in its present shape."""
    return _limits_s(plan, tangent)[0]


def _limits_s(plan: PanelPlan, tangent: Tangent) -> tuple[float, float]:
    """Largest and usual step.  Maxwell branches answer fast changes like springs and so raise
    the stiffness that limits an explicit step by their ratios."""
    if plan.integrator == "implicit":
        return COARSEST_STEP_S, USUAL_STEP_S
    if plan.integrator != "explicit":
        raise ValueError(f"panel {plan.name}: integrator {plan.integrator!r}: take 'explicit' or 'implicit'")
    stiffening = 1.0 + sum(ratio for ratio, _ in plan.material.branches)
    critical_s = 2.0 / (tangent.highest_frequency_rad_per_s() * stiffening**0.5)
    return STABLE_SHARE * critical_s, USUAL_SHARE * critical_s
