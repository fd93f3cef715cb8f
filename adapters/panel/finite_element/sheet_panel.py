"""The panel as a thin sheet on DOLFINx: the default model (docs/theory/panel_sheet.md).

All finite-element nodes are surface points, in the order of the grid: y runs fastest.  The nodes
under the clamps and on their inner edges are the clamp points; as they reach under the clamp they
carry its rotation, too.
"""

from __future__ import annotations

from orchestrator.ports.plans import PanelPlan, SolverMissing

try:
    from adapters.panel.common import _petsc  # noqa: F401
    from adapters.panel.finite_element import elastic_panel
    from adapters.panel.finite_element.elastic_panel import ElasticPanel
    from adapters.panel.finite_element.sheet_forms import sheet
except ImportError as missing:
    raise SolverMissing(
        f"panel solver 'sheet' needs DOLFINx 0.5 (Debian 12: python3-dolfinx): {missing}"
    ) from missing
try:
    from adapters.panel.finite_element import compiled_sheet
except ImportError as missing:
    raise SolverMissing(
        f"panel solver 'sheet' needs its compiled part, which docker/setup.sh builds: {missing}"
    ) from missing


def build(plan: PanelPlan) -> ElasticPanel:
    """Open the sheet at rest between its clamps.

    ValueError for a step that is too large, SolverFailed if no resting shape is found.
    """
    return elastic_panel.open_panel(plan, *sheet(plan), compiled_sheet.panel)


def largest_step_s(plan: PanelPlan) -> float:
    """Return the largest ``step_s`` that ``build`` accepts for this plan."""
    structure, _ = sheet(plan)
    return elastic_panel.largest_step_s(plan, structure)
