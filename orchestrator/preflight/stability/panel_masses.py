"""The least mass that a contact finds at a point of the surface."""

from __future__ import annotations

import math

import numpy as np

from orchestrator.case.planning.panel_meshes import mesh_sizes
from orchestrator.case.tables.case import Case
from orchestrator.case.tables.screen import Panel
from orchestrator.ports import Array
from orchestrator.ports.geometry import Apertures

MIDDLE_OF_SOLID = 2 / 3  # of the mass under a point: what the solid's mid-surface nodes carry


def areal_kg_per_m2(case: Case, panel: Panel) -> float:
    """Mass of the perforated part per area."""
    solid = Apertures(**dict(panel.apertures)).solid_share if panel.apertures else 1.0
    return solid * case.materials[panel.material].density_kg_per_m3 * panel.thickness_m


def lightest_point_kg(case: Case, panel: Panel) -> float:
    """Of a panel that is no rigid one: effective mass of the lightest point of its surface."""
    if case.panel.solver == "strip":  # a row moves as one
        return areal_kg_per_m2(case, panel) * panel.width_m * panel.length_m / case.panel.cells[0]
    if panel.apertures and (sizes := mesh_sizes(case)):  # rims of openings are in the mesh
        return min(size.lightest_kg for size in sizes.values())
    share = MIDDLE_OF_SOLID if case.panel.solver == "solid" else 1.0
    return share * lightest_node_kg(case, panel)


def lightest_node_kg(case: Case, panel: Panel) -> float:
    """Effective mass 1 / sum(N^2 / m) of the surface's points, the free edges left out.

    N: shape functions, m: masses of the sheet's quadratic cells, lumped at their
    Gauss-Lobatto points (1/6, 2/3, 1/6 in each direction; corners belong to two cells).
    Openings have corners everywhere, so some stand on the lightest nodes, the cells' corners.
    """
    sides_m = (panel.length_m, panel.width_m)
    cells, surface = case.panel.cells, case.panel.surface_cells
    cell_m2 = math.prod(side_m / n for side_m, n in zip(sides_m, cells, strict=True))
    lightest = np.zeros(1) if panel.apertures else np.empty(0)
    mobility = [
        _mobility(np.append(np.arange(1, m) * n / m, lightest)).max(initial=0.75)
        for n, m in zip(cells, surface, strict=True)
    ]
    return float(areal_kg_per_m2(case, panel) * cell_m2 / math.prod(mobility))


def _mobility(cells_from_edge: Array) -> Array:
    """Sum of N^2 / weight at places counted in cells, along one direction."""
    x = 2 * (cells_from_edge % 1.0) - 1
    one, middle, two = x * (x - 1) / 2, 1 - x * x, x * (x + 1) / 2
    mobility: Array = 3 * (one**2 + two**2) + 1.5 * middle**2
    return mobility
