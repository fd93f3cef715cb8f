"""The panel as a three-dimensional solid on DOLFINx: the reference (docs/theory/panel_solid.md)."""

from __future__ import annotations

from collections.abc import Iterator

from adapters.panel.common.estimates import DOLFINX_S, lightest_sheet_point_kg
from orchestrator.ports import MeshedPanel
from orchestrator.ports.adapters import Objection, PanelAdapter
from orchestrator.ports.plans import Cost, MeshSize, PanelPlan, PanelsWork

CELL_S = 1.1e-4
"""Time of a cell and interval for each cell across: the matrix has that band."""
MIDDLE_LAYER = 2 / 3
"""Share of the mass under a point of the surface that the mid-surface's nodes carry."""


def build(plan: PanelPlan) -> MeshedPanel:
    """Open the solid at rest between its clamps.

    Raises ValueError for openings with round ends, for a mesh that no machine carries and for a step that is
    too large, SolverFailed if no resting shape is found.
    """
    from adapters.panel.finite_element.elastic_panel import open_panel
    from adapters.panel.finite_element.panel_at_rest import at_rest
    from adapters.panel.finite_element.solid_forms import solid

    return open_panel(plan, at_rest(plan, solid), *solid(plan))


def largest_step_s(plan: PanelPlan) -> float:
    """Return the largest ``step_s`` that ``build`` accepts for this plan."""
    from adapters.panel.finite_element import panel_at_rest, solid_forms

    return panel_at_rest.at_rest(plan, solid_forms.solid).step_limits_s[0]


def mesh_size(plan: PanelPlan) -> MeshSize:
    """Return the size of the mesh before it is made.  Raises ValueError for openings with round ends."""
    from adapters.panel.common import solid_grid

    return solid_grid.size(plan)


def lightest_kg(plan: PanelPlan, surface_cells: tuple[int, int]) -> float:
    """Return the effective mass of the mid-surface's lightest point; rims of openings are in the mesh."""
    if plan.apertures is not None:
        return mesh_size(plan).lightest_kg
    return MIDDLE_LAYER * lightest_sheet_point_kg(plan, surface_cells)


def objections(plan: PanelPlan) -> Iterator[Objection]:
    """Yield objections to openings with round ends, to margins of a slice, and to sensors."""
    if plan.point_masses:
        what = f"panel {plan.name} has sensors, whose masses a solid does not carry"
        yield Objection(what, 'take the sensor_kg of its probes away, or panel.solver = "sheet"')
    if plan.apertures is not None and plan.apertures.shape != "rectangle":
        drawn = plan.apertures.drawn is not None
        ends, remedy = ("outlines", "give a pattern") if drawn else ("round ends", 'take "rectangle"')
        what = f"{plan.apertures.shape}: the solid's cells are boxes and follow no {ends}"
        key = ("screen", "panels", plan.name, "apertures", *(() if drawn else ("shape",)))
        yield Objection(what, f'{remedy}, or panel.solver = "sheet"', key)
    if plan.apertures is not None and plan.apertures.margin_share > 0.0:
        what = f"panel {plan.name} is a slice of a panel with margins, which a solid has only where they are"
        yield Objection(what, 'leave the slice away, or take panel.solver = "sheet"')


def cost(work: PanelsWork) -> Cost:
    """Return the cost, nearly all of which is solving a matrix in each interval."""
    along, across = work.cells
    cells = work.resolved_cells or work.panels * along * across
    interval_s = CELL_S * cells * across
    return Cost(DOLFINX_S + 0.3 * work.panels + 1e-3 * cells, work.runs * interval_s)


ADAPTER = PanelAdapter(
    about="a three-dimensional body with its openings in the mesh (DOLFINx)",
    build=build,
    cost=cost,
    objections=objections,
    needs=("adapters.panel.finite_element.solid_forms",),
    largest_step_s=largest_step_s,
    mesh_size=mesh_size,
    memory_GiB=lambda plan: mesh_size(plan).memory_GiB,
    lightest_kg=lightest_kg,
    compresses=True,
    fidelity=3,
    refined_by=1.5,
)
