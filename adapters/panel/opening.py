"""How every finite-element panel is opened: from its structure to a panel at rest."""

from __future__ import annotations

from contextlib import ExitStack, closing

from adapters.panel import integrators
from adapters.panel.elastic_panel import ElasticPanel
from adapters.panel.grid import Surface
from adapters.panel.resting_shape import first_guess_m, settle
from adapters.panel.structure import Structure
from adapters.panel.tangent import Tangent
from orchestrator.plans import PanelPlan
from orchestrator.ports import Array


def open_panel(plan: PanelPlan, structure: Structure, surface: Surface) -> ElasticPanel:
    """The panel at rest between its clamps.

    ValueError for a step that is too large, SolverFailed if no resting shape is found.
    """
    with ExitStack() as failed:
        failed.callback(structure.close)
        tangent = failed.enter_context(closing(Tangent(structure)))
        resting_m = _resting_m(plan, structure, tangent)
        integrator = integrators.choose(plan, structure, tangent)
        panel = ElasticPanel(plan, structure, integrator, surface, resting_m)
        failed.pop_all()
    return panel


def largest_step_s(plan: PanelPlan, structure: Structure) -> float:
    """The largest ``plan.step_s`` that ``open_panel`` accepts."""
    with closing(structure), closing(Tangent(structure)) as tangent:
        _resting_m(plan, structure, tangent)
        return integrators.largest_step_s(plan, tangent)


def _resting_m(plan: PanelPlan, structure: Structure, tangent: Tangent) -> Array:
    """Positions (nodes, 3) at rest, left in the structure's field."""
    start_m = first_guess_m(plan.rectangle, plan.gravity_m_s2, structure.material_m)
    weight_N = structure.mass_kg[:, None] * plan.gravity_m_s2
    return settle(structure, tangent, start_m, weight_N, plan.name)
