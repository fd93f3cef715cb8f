"""The sheet: a Kirchhoff-Love model on the flat, stress-free rectangle.

The unknown is the world position x(s, y) of the mid-surface.  Membrane: two-parameter
Mooney-Rivlin in plane stress, incompressible, so that C33 = 1/det C.  Bending: ``bending``.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

from adapters.panel.bending import Bending, stiffness_matrix
from adapters.panel.grid import Grid
from adapters.panel.material import Law
from adapters.panel.structure import Structure
from orchestrator.plans import Hyperelastic, PanelPlan
from orchestrator.ports import Array, Indices

QUADRATURE_DEGREE = 4  # 3 x 3 Gauss points
POISSON_RATIO = 0.5


def _flat_mesh(grid: Grid) -> Any:
    """One quadrilateral per cell of ``grid``, in its material coordinates."""
    along, across = grid.shape
    flat = mesh.create_rectangle(
        MPI.COMM_SELF, [[0, 0], [along, across]], [along, across], mesh.CellType.quadrilateral
    )
    nodes = flat.geometry.x
    nodes[:, 0] = np.interp(nodes[:, 0], np.arange(along + 1), grid.s_m)
    nodes[:, 1] = np.interp(nodes[:, 1], np.arange(across + 1), grid.y_m)
    return flat


def membrane_energy(material: Hyperelastic, thickness_m: float, C: Any) -> Any:
    """Energy per area in J/m2 for the right Cauchy-Green tensor C (2 x 2) of the mid-surface."""
    trace, det = ufl.tr(C), ufl.det(C)
    return thickness_m * (
        material.c10_Pa * (trace + 1 / det - 3) + material.c01_Pa * (det + trace / det - 3)
    )


def _scaled_strain(material: Hyperelastic, thickness_m: float, C: Any) -> Any:
    """Vector whose half square is the small-strain plane-stress energy  mu t (E:E + (tr E)^2)."""
    E = 0.5 * (C - ufl.Identity(2))
    root = (2.0 * material.shear_modulus_Pa * thickness_m) ** 0.5
    return ufl.as_vector(
        [
            root * 1.5**0.5 * (E[0, 0] + E[1, 1]),
            root * 0.5**0.5 * (E[0, 0] - E[1, 1]),
            root * 2.0**0.5 * E[0, 1],
        ]
    )


def sheet(plan: PanelPlan, grid: Grid) -> tuple[Structure, Indices]:
    """The structure of ``plan`` on ``grid`` and, for each grid node, its number in it."""
    flat = _flat_mesh(grid)
    space = fem.FunctionSpace(flat, ufl.VectorElement("Lagrange", flat.ufl_cell(), 2, dim=3))
    scalars = fem.FunctionSpace(flat, ("Lagrange", 2))
    position = fem.Function(space)
    gradient = ufl.grad(position)
    C = gradient.T * gradient
    material, t = plan.material, plan.thickness_m
    measure = ufl.dx(metadata={"quadrature_degree": QUADRATURE_DEGREE})
    law = Law(
        position,
        {"membrane": membrane_energy(material, t, C) * measure},
        _scaled_strain(material, t, C),
        QUADRATURE_DEGREE,
        material.branches,
    )
    plate_N_m = material.youngs_modulus_Pa * t**3 / (12 * (1 - POISSON_RATIO**2))
    material_m = space.tabulate_dof_coordinates()
    flat_m = plan.rectangle.corner_m + material_m[:, :2] @ np.stack(
        (plan.rectangle.along, plan.rectangle.across)
    )
    matrix = stiffness_matrix(scalars, plate_N_m, POISSON_RATIO)
    bending = Bending(matrix, flat_m, material.branches)
    number = node_numbers(grid, material_m)
    held = number[~np.isnan(plan.rectangle.end(grid.nodes_m()))]
    return Structure(law, material.density_kg_m3 * t, held, bending), number


def node_numbers(grid: Grid, coordinates_m: Array) -> Indices:
    """(grid nodes,) which of the points ``coordinates_m`` (n, 2 or more) stands at each."""
    order = grid.interpolation(coordinates_m[:, :2]).tocoo()
    there = order.data > 0.5
    number = np.empty(len(coordinates_m), dtype=np.int64)
    number[order.col[there]] = order.row[there]
    return number
