"""Common estimates for panels before they are opened.

Costs are processor time on one core of a 2-core AMD EPYC machine that was busy with other work, measured on
drafts of shipped cases; ``python -m tools.cost_series`` compares predicted with measured times.
"""

from __future__ import annotations

import math

import numpy as np

from orchestrator.ports import Array
from orchestrator.ports.plans import PanelPlan

DOLFINX_S = 0.3
"""The time in which DOLFINx is imported, in s."""


def areal_mass_kg_per_m2(plan: PanelPlan) -> float:
    """Return the mass of the perforated part of a panel per area."""
    solid = plan.apertures.solid_share if plan.apertures is not None else 1.0
    return solid * plan.material.density_kg_per_m3 * plan.thickness_m


def lightest_sheet_point_kg(plan: PanelPlan, surface_cells: tuple[int, int]) -> float:
    """Return the effective mass of the lightest point of a surface on a grid of quadratic cells, the free
    edges left out.

    It is 1 / sum(N^2 / m), with N the shape functions and m the masses of the cells' nodes, lumped
    at their Gauss-Lobatto points (1/6, 2/3, 1/6 in each direction; corners belong to two cells).
    Openings have corners everywhere, so some stand on the lightest nodes, the cells' corners.
    """
    sides_m = (plan.rectangle.length_m, plan.rectangle.width_m)
    cell_m2 = math.prod(side_m / n for side_m, n in zip(sides_m, plan.cells, strict=True))
    lightest = np.zeros(1) if plan.apertures is not None else np.empty(0)
    mobility = [
        _mobility(np.append(np.arange(1, m) * n / m, lightest)).max(initial=0.75)
        for n, m in zip(plan.cells, surface_cells, strict=True)
    ]
    return float(areal_mass_kg_per_m2(plan) * cell_m2 / math.prod(mobility))


def _mobility(cells_from_edge: Array) -> Array:
    """Return the sum of N^2 / weight at places counted in cells, along one direction."""
    x = 2 * (cells_from_edge % 1.0) - 1
    left, middle, right = x * (x - 1) / 2, 1 - x * x, x * (x + 1) / 2
    mobility: Array = 3 * (left**2 + right**2) + 1.5 * middle**2
    return mobility
