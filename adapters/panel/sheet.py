"""The panel as a thin sheet on DOLFINx: the default model (docs/theory/panel_sheet.md).

All finite-element nodes are surface points, in the order of the grid: y runs fastest.  The nodes
under the clamps and on their inner edges are the clamp points; as they reach under the clamp they
carry its rotation, too.
"""

from __future__ import annotations

from functools import partial

from adapters.panel.common.estimates import DOLFINX_S, lightest_sheet_point_kg
from orchestrator.ports import MeshedPanel
from orchestrator.ports.adapters import PanelAdapter
from orchestrator.ports.plans import Cost, PanelPlan, PanelsWork

RESTING_CELL_S = 7e-4
"""Time per cells^1.3 for the resting shape and modes: 20 s for 50 x 50 cells, 121 s for 100 x 100."""
CELL_GIB = 3e-4
"""Memory per cell: 0.8 GiB for 50 x 50 cells, 2.9 for 100 x 100, 11 for 200 x 200."""


def build(plan: PanelPlan) -> MeshedPanel:
    """Open the sheet at rest between its clamps.

    Raises ValueError for a step that is too large, SolverFailed if no resting shape is found.
    """
    from adapters.panel.finite_element.compiled_sheet import SheetPanel, open_sheet
    from adapters.panel.finite_element.elastic_panel import open_panel
    from adapters.panel.finite_element.panel_at_rest import at_rest
    from adapters.panel.finite_element.sheet_forms import sheet

    rest = at_rest(plan, sheet)
    structure, grid, nodes = sheet(plan)
    if plan.moulded_sag_m:  # which the compiled loop does not know
        return open_panel(plan, rest, structure, grid, nodes)
    make_explicit = partial(open_sheet, plan, grid)
    return open_panel(plan, rest, structure, grid, nodes, make_explicit, SheetPanel)


def largest_step_s(plan: PanelPlan) -> float:
    """Return the largest ``step_s`` that ``build`` accepts for this plan."""
    from adapters.panel.finite_element import panel_at_rest, sheet_forms

    return panel_at_rest.at_rest(plan, sheet_forms.sheet).step_limits_s[0]


def cost(work: PanelsWork) -> Cost:
    """Return the cost: explicit steps scale with a cell's length, and an implicit interval solves a
    matrix."""
    cells = work.cells[0] * work.cells[1]
    if work.integrator == "implicit":
        interval_s = 3.5e-3 + 1.5e-4 * cells
    else:
        interval_s = 2.5e-5 + 1.8e-4 * cells * work.cells[0] * work.interval_s
    opening_s = 0.03 * work.panels + RESTING_CELL_S * cells**1.3  # equal panels share one resting shape
    return Cost(DOLFINX_S + opening_s, work.panels * work.runs * interval_s)


ADAPTER = PanelAdapter(
    about="a membrane that bends, varying along and across (DOLFINx)",
    build=build,
    cost=cost,
    needs=("adapters.panel.finite_element.compiled_sheet",),
    largest_step_s=largest_step_s,
    memory_GiB=lambda plan: CELL_GIB * plan.cells[0] * plan.cells[1],
    lightest_kg=lightest_sheet_point_kg,
    joins_sides=True,
    fidelity=2,
    refined_by=1.5,
    order=2.0,
)
