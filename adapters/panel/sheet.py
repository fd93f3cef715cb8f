"""The panel as a thin sheet on DOLFINx: the default model.

See docs/theory/panel_sheet.md.  All finite-element nodes are surface points, in the order of the
grid: y runs fastest.  The nodes under the clamps and on their inner edges are the clamp points;
as they reach under the clamp they carry its rotation, too.
"""

from __future__ import annotations

import numpy as np

from orchestrator.plans import PanelPlan, SolverMissing
from orchestrator.ports import Array

try:
    from adapters.panel import integrators, resting_shape
    from adapters.panel.elastic_panel import ElasticPanel, Surface
    from adapters.panel.grid import Grid
    from adapters.panel.sheet_forms import sheet
    from adapters.panel.structure import Structure
    from adapters.panel.tangent import Tangent
except ImportError as missing:
    raise SolverMissing(
        f"panel solver 'sheet' needs DOLFINx 0.5 (Debian 12: python3-dolfinx): {missing}"
    ) from missing


def build(plan: PanelPlan) -> ElasticPanel:
    """The sheet at rest between its clamps.

    ValueError for a step that is too large, SolverFailed if no resting shape is found.
    """
    structure, surface = _structure(plan)
    tangent = Tangent(structure)
    resting_m = _resting_m(plan, structure, surface, tangent)
    integrator = integrators.choose(plan, structure, tangent)
    return ElasticPanel(plan, structure, integrator, surface, resting_m)


def largest_step_s(plan: PanelPlan) -> float:
    """The largest ``step_s`` that ``build`` accepts for this plan."""
    structure, surface = _structure(plan)
    tangent = Tangent(structure)
    _resting_m(plan, structure, surface, tangent)
    return integrators.largest_step_s(plan, tangent)


def _structure(plan: PanelPlan) -> tuple[Structure, Surface]:
    grid = Grid.of(plan.rectangle, plan.cells)
    structure, number = sheet(plan, grid)
    return structure, Surface(grid, number)


def _resting_m(plan: PanelPlan, structure: Structure, surface: Surface, tangent: Tangent) -> Array:
    """Positions (nodes, 3), left in the structure's field."""
    guess = resting_shape.first_guess(plan.rectangle, plan.gravity_m_s2, surface.grid.nodes_m())
    start_m = np.empty_like(guess.position_m)
    start_m[surface.nodes] = guess.position_m
    weight_N = structure.mass_kg[:, None] * plan.gravity_m_s2
    return resting_shape.settle(structure, tangent, start_m, weight_N, plan.name)
