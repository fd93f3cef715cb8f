"""How every finite-element panel is opened: from its structure to a panel at rest."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack, closing
from typing import Any

from adapters.panel.common.body import BodyState
from adapters.panel.finite_element import integrators
from adapters.panel.finite_element.elastic_panel import ElasticPanel
from adapters.panel.finite_element.grid import Surface
from adapters.panel.finite_element.resting_shape import first_guess_m, settle
from adapters.panel.finite_element.structure import Structure
from adapters.panel.finite_element.tangent import Tangent
from orchestrator.ports import Array
from orchestrator.ports.plans import PanelPlan

# From plan, structure, surface, resting shape (nodes, 3) and step in s; owns the structure.
Explicitly = Callable[[PanelPlan, Structure, Surface[Any], Array, float], ElasticPanel]


def explicit(
    plan: PanelPlan, structure: Structure, surface: Surface[Any], resting_m: Array, step_s: float
) -> ElasticPanel:
    """Explicit steps in Python, for any structure."""
    state = _at_rest(structure, resting_m)
    integrator = integrators.Explicit(structure, step_s)
    return ElasticPanel(plan, structure, integrator, state, surface.grid, surface.nodes)


def open_panel(
    plan: PanelPlan, structure: Structure, surface: Surface[Any], explicitly: Explicitly = explicit
) -> ElasticPanel:
    """The panel at rest between its clamps; ``explicitly`` makes the one with explicit steps.

    ValueError for a step that is too large, SolverFailed if no resting shape is found.
    """
    with ExitStack() as failed:
        failed.callback(structure.close)
        tangent = failed.enter_context(closing(Tangent(structure)))
        resting_m = _resting_m(plan, structure, tangent)
        step_s = integrators.step_s(plan, tangent)
        if plan.integrator == "explicit":
            panel = explicitly(plan, structure, surface, resting_m, step_s)
            tangent.close()
        else:
            integrator = integrators.GeneralizedAlpha(structure, tangent, step_s, plan.name)
            state = _at_rest(structure, resting_m)
            grid, nodes = surface.grid, surface.nodes
            panel = ElasticPanel(plan, structure, integrator, state, grid, nodes)
        failed.pop_all()
    return panel


def largest_step_s(plan: PanelPlan, structure: Structure) -> float:
    """The largest ``plan.step_s`` that ``open_panel`` accepts."""
    with closing(structure), closing(Tangent(structure)) as tangent:
        _resting_m(plan, structure, tangent)
        return integrators.largest_step_s(plan, tangent)


def _at_rest(structure: Structure, resting_m: Array) -> BodyState:
    structure.rest(resting_m)
    return BodyState.at_rest(resting_m, structure.force_N(resting_m))


def _resting_m(plan: PanelPlan, structure: Structure, tangent: Tangent) -> Array:
    """Positions (nodes, 3) at rest, left in the structure's field."""
    start_m = first_guess_m(plan.rectangle, plan.gravity_m_per_s2, structure.material_m)
    weight_N = structure.mass_kg[:, None] * plan.gravity_m_per_s2
    return settle(structure, tangent, start_m, weight_N, plan.name)
