"""The solid: nearly incompressible Mooney-Rivlin on quadratic hexahedra.

The unknown is the world position x(s, y, z).  One cell through the thickness has nodes on the
mid-surface.  The volumetric energy is integrated with 2 x 2 x 2 points (selective reduced
integration: Malkus and Hughes, Comput. Methods Appl. Mech. Engrg. 15 (1978) 63-81,
doi:10.1016/0045-7825(78)90005-1), without which the thin cells lock.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

from adapters.panel.compiled import function_space
from adapters.panel.grid import Grid, Surface
from adapters.panel.material import Law
from adapters.panel.structure import Structure
from orchestrator.plans import PanelPlan

ISOCHORIC_DEGREE = 4  # 3 x 3 x 3 Gauss points
VOLUMETRIC_DEGREE = 2  # 2 x 2 x 2


def box_mesh(grid: Grid, thickness_m: float) -> Any:
    """One hexahedron per cell of ``grid``, from half the thickness below to half above."""
    along, across = grid.shape
    box = mesh.create_box(
        MPI.COMM_SELF,
        [[0, 0, 0], [along, across, 1]],
        [along, across, 1],
        mesh.CellType.hexahedron,
    )
    nodes = box.geometry.x
    nodes[:, 0] = np.interp(nodes[:, 0], np.arange(along + 1), grid.s_m)
    nodes[:, 1] = np.interp(nodes[:, 1], np.arange(across + 1), grid.y_m)
    nodes[:, 2] = (nodes[:, 2] - 0.5) * thickness_m
    return box


def law(plan: PanelPlan, position: Any, volumetric_degree: int = VOLUMETRIC_DEGREE) -> Law:
    """Isochoric invariants, and  K/2 (J - 1)^2  with its own quadrature degree."""
    material = plan.material
    gradient = ufl.grad(position)
    C, J = ufl.transpose(gradient) * gradient, ufl.det(gradient)
    first = ufl.tr(C)
    second = 0.5 * (first**2 - ufl.inner(C, C))
    isochoric = material.c10_Pa * (J ** (-2 / 3) * first - 3) + material.c01_Pa * (
        J ** (-4 / 3) * second - 3
    )
    volumetric = 0.5 * material.bulk_modulus_Pa * (J - 1) ** 2
    energy = {
        "isochoric": isochoric * ufl.dx(metadata={"quadrature_degree": ISOCHORIC_DEGREE}),
        "volumetric": volumetric * ufl.dx(metadata={"quadrature_degree": volumetric_degree}),
    }
    strain = _scaled_strain(material.shear_modulus_Pa, C)
    return Law(position, energy, strain, ISOCHORIC_DEGREE, material.branches)


def _scaled_strain(shear_modulus_Pa: float, C: Any) -> Any:
    """Vector whose half square is  mu dev(E) : dev(E)."""
    E = ufl.dev(0.5 * (C - ufl.Identity(3)))
    root, twice = (2.0 * shear_modulus_Pa) ** 0.5, 2.0**0.5
    return ufl.as_vector(
        [
            root * E[0, 0],
            root * E[1, 1],
            root * E[2, 2],
            root * twice * E[0, 1],
            root * twice * E[0, 2],
            root * twice * E[1, 2],
        ]
    )


def solid(plan: PanelPlan) -> tuple[Structure, Surface]:
    """The structure of ``plan``; its surface is the nodes of the mid-surface."""
    grid = Grid.of(plan.rectangle, plan.cells)
    box = box_mesh(grid, plan.thickness_m)
    space = function_space(box, ufl.VectorElement("Lagrange", box.ufl_cell(), 2))
    material_m = space.tabulate_dof_coordinates()
    middle = np.flatnonzero(np.abs(material_m[:, 2]) < 0.1 * plan.thickness_m)
    held = np.flatnonzero(~np.isnan(plan.rectangle.end(material_m[:, :2])))
    structure = Structure(law(plan, fem.Function(space)), plan.material.density_kg_m3, held)
    return structure, Surface(grid, middle[grid.numbers_of(material_m[middle])])
