"""The panel as a three-dimensional solid on DOLFINx: the reference (docs/theory/panel_solid.md).

The nodes of the mid-surface are the surface points, in the order of the grid: y runs fastest.
All nodes under the clamps and on their inner edges, through the thickness, are clamp points.
"""

from __future__ import annotations

from orchestrator.ports.plans import PanelPlan, SolverMissing

try:
    from adapters.panel.common import _petsc  # noqa: F401
    from adapters.panel.finite_element import elastic_panel
    from adapters.panel.finite_element.elastic_panel import ElasticPanel
    from adapters.panel.finite_element.solid_forms import solid
except ImportError as missing:
    raise SolverMissing(
        f"panel solver 'solid' needs DOLFINx 0.5 (Debian 12: python3-dolfinx): {missing}"
    ) from missing


def build(plan: PanelPlan) -> ElasticPanel:
    """Open the solid at rest between its clamps.

    ValueError for openings with round ends, for a mesh that no machine carries and for a step that
    is too large, SolverFailed if no resting shape is found.
    """
    return elastic_panel.open_panel(plan, *solid(plan))


def largest_step_s(plan: PanelPlan) -> float:
    """Return the largest ``step_s`` that ``build`` accepts for this plan."""
    structure, _ = solid(plan)
    return elastic_panel.largest_step_s(plan, structure)
