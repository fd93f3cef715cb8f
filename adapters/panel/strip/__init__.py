"""A panel as a width-uniform strip: one chain of rows along its length (docs/theory/panel_strip.md)."""

from __future__ import annotations

from collections.abc import Iterator

from adapters.panel.common.estimates import areal_mass_kg_per_m2
from orchestrator.ports import MeshedPanel
from orchestrator.ports.adapters import Objection, PanelAdapter
from orchestrator.ports.plans import Cost, PanelPlan, PanelsWork


def build(plan: PanelPlan) -> MeshedPanel:
    """Open the strip at rest between its clamps.

    Raises ValueError for an implicit integrator or a step above ``largest_step_s``, SolverFailed if no
    resting shape is found.
    """
    from adapters.panel.strip import panel

    return panel.build(plan)


def largest_step_s(plan: PanelPlan) -> float:
    """Return the largest ``step_s`` that ``build`` accepts for this plan."""
    from adapters.panel.strip import panel

    return panel.largest_step_s(plan)


def lightest_kg(plan: PanelPlan, surface_cells: tuple[int, int]) -> float:
    """Return the mass of a row, which moves as one."""
    sides_m2 = plan.rectangle.width_m * plan.rectangle.length_m
    return areal_mass_kg_per_m2(plan) * sides_m2 / plan.cells[0]


def objections(plan: PanelPlan) -> Iterator[Objection]:
    """Yield an objection to fewer than two rows of cells."""
    if plan.cells[0] < 2:
        yield Objection("a strip needs at least two cells", key=("panel", "cells", 0))


def cost(work: PanelsWork) -> Cost:
    """Return the cost of a call, and of steps whose length goes with that of a cell.

    The resting shape of many cells is the longer part: 7 s for 200, 70 s for 400.
    """
    steps_s = 0.05 * work.interval_s * (work.cells[0] / 22) ** 2
    opening_s = 0.01 + 1.1e-6 * work.cells[0] ** 3
    return Cost(opening_s * work.panels, work.panels * work.runs * (4e-6 + steps_s))


ADAPTER = PanelAdapter(
    about="a chain of rows along the length; nothing varies across",
    build=build,
    cost=cost,
    leaves_out={"variation-across": "nothing varies across a panel"},
    objections=objections,
    needs=("adapters.panel.strip.panel",),
    varies_across=False,
    integrators=("explicit",),
    largest_step_s=largest_step_s,
    lightest_kg=lightest_kg,
    fidelity=1,
    refined_by=2.0,
    order=2.0,
)
