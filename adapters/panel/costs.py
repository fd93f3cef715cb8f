"""What each panel solver costs; what is asked and answered: orchestrator/ports/plans/work.py.

Processor time on one core of a 2-core AMD EPYC machine that was busy with other work.  Measured on
drafts of shipped cases; ``python -m tests.cost_series`` measures predicted over taken.
"""

from __future__ import annotations

from orchestrator.ports.plans import Cost, PanelsWork

DOLFINX_S = 0.5
"""Importing it."""
RESTING_CELL_S = 7e-4
"""Of a sheet's resting shape and modes: 20 s for 50 x 50 cells, 121 s for 100 x 100."""
SHEET_CELL_GIB = 3e-4
"""Of a sheet: 0.8 GiB for 50 x 50 cells, 2.9 for 100 x 100, 11 for 200 x 200."""
SOLID_CELL_S = 1.1e-4
"""Of a cell and interval, for each cell across: the matrix has that band."""


def rigid(work: PanelsWork) -> Cost:
    return Cost(0.01 * work.panels, 4e-5 * work.panels * work.runs)


def recorded(work: PanelsWork) -> Cost:
    return Cost(0.02 * work.panels, 1.5e-4 * work.panels * work.runs)


def strip(work: PanelsWork) -> Cost:
    """A call, and the steps, whose length goes with that of a cell.  The resting shape of many
    cells is the longer part: 7 s for 200, 70 s for 400."""
    steps_s = 0.1 * work.interval_s * (work.cells[0] / 22) ** 2
    opening_s = 0.05 + 1.1e-6 * work.cells[0] ** 3
    return Cost(opening_s * work.panels, work.panels * work.runs * (1.0e-4 + steps_s))


def sheet(work: PanelsWork) -> Cost:
    """Explicit steps go with the length of a cell; an implicit interval solves a matrix."""
    cells = work.cells[0] * work.cells[1]
    if work.integrator == "implicit":
        interval_s = 3.5e-3 + 1.5e-4 * cells
    else:
        interval_s = 7.5e-5 + 6e-4 * cells * work.cells[0] * work.interval_s
    opening_s = 0.1 + RESTING_CELL_S * cells**1.3
    return Cost(DOLFINX_S + opening_s * work.panels, work.panels * work.runs * interval_s)


def solid(work: PanelsWork) -> Cost:
    """Solving a matrix in each interval is nearly all of it."""
    along, across = work.cells
    cells = work.resolved_cells or work.panels * along * across
    interval_s = SOLID_CELL_S * cells * across
    return Cost(DOLFINX_S + 0.3 * work.panels + 1e-3 * cells, work.runs * interval_s)
