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
from dolfinx import fem

from adapters.panel.common.moulding import curvature_amplitude_1_m
from adapters.panel.common.solid_grid import PiercedGrid, bearable_grid
from adapters.panel.finite_element.branch_strain import SOLID_ENTRIES, solid_entries
from adapters.panel.finite_element.compiled import function_space, linear_mesh
from adapters.panel.finite_element.structure import Law, Structure, cell_constants
from orchestrator.ports import Array, Indices
from orchestrator.ports.plans import PanelPlan

ISOCHORIC_DEGREE = 4  # 3 x 3 x 3 Gauss points
VOLUMETRIC_DEGREE = 2  # 2 x 2 x 2


def box_mesh(grid: PiercedGrid, thickness_m: float) -> Any:
    """Make a mesh of one hexahedron per cell with material, from half the thickness below to half above."""
    s_m, y_m = grid.whole.s_m, grid.whole.y_m
    shape = (len(s_m), len(y_m), 2)
    number = np.arange(np.prod(shape)).reshape(shape)
    along, across = np.nonzero(grid.hole_of_cell() < 0)
    corners = [number[along + i, across + j, k] for k in (0, 1) for j in (0, 1) for i in (0, 1)]
    used, cells = np.unique(np.stack(corners, axis=1), return_inverse=True)
    height_m = np.array([-0.5, 0.5]) * thickness_m
    places = np.meshgrid(s_m, y_m, height_m, indexing="ij")
    points_m = np.stack(places, axis=-1).reshape(-1, 3)[used]
    return linear_mesh("hexahedron", points_m, cells.reshape(-1, 8))


def law(plan: PanelPlan, position: Any, volumetric_degree: int = VOLUMETRIC_DEGREE) -> Law:
    """Return the law: isochoric invariants, and  K/2 (J - 1)^2  with its own quadrature degree."""
    material = plan.material
    stretch = moulded_stretch(plan, position)
    gradient = ufl.grad(position)
    if plan.moulded_sag_m:
        gradient = gradient * ufl.diag(ufl.as_vector([1 / stretch, 1.0, 1.0]))
    C, J = ufl.transpose(gradient) * gradient, ufl.det(gradient)
    first = ufl.tr(C)
    second = 0.5 * (first**2 - ufl.inner(C, C))
    isochoric = material.c10_Pa * (J ** (-2 / 3) * first - 3) + material.c01_Pa * (J ** (-4 / 3) * second - 3)
    volumetric = 0.5 * material.bulk_modulus_Pa * (J - 1) ** 2
    energy = {
        "isochoric": stretch * isochoric * ufl.dx(metadata={"quadrature_degree": ISOCHORIC_DEGREE}),
        "volumetric": stretch * volumetric * ufl.dx(metadata={"quadrature_degree": volumetric_degree}),
    }
    entries = cell_constants(position.function_space.mesh, len(SOLID_ENTRIES))
    return Law(
        position,
        energy,
        scaled_strain(entries, C),
        entries,
        SOLID_ENTRIES,
        lambda strain: solid_entries(material.c10_Pa, material.c01_Pa, strain),
        ISOCHORIC_DEGREE,
        material.branches,
    )


def moulded_stretch(plan: PanelPlan, position: Any) -> Any:
    """Return how long fibres along the panel are where it is free of stress, over those of a flat panel.

    A curvature k turns the cross-sections of the stress-free shape, in which a fibre at the height z over the
    mid-surface is 1 - k z times as long as that one.
    """
    if not plan.moulded_sag_m:
        return 1.0
    length_m = plan.rectangle.length_m
    s, _, height = ufl.SpatialCoordinate(position.function_space.mesh)
    free = ufl.conditional(ufl.And(ufl.gt(s, 0.0), ufl.lt(s, length_m)), 1.0, 0.0)
    return 1.0 + curvature_amplitude_1_m(plan) * free * ufl.cos(2 * ufl.pi * s / length_m) * height


def scaled_strain(entries: Any, C: Any) -> Any:
    """Return the vector (A (E11, E22, E33), a 2 E12, b 2 E13, c 2 E23) for the ``entries`` A, a, b, c."""
    E = 0.5 * (C - ufl.Identity(3))
    normal = [sum(entries[3 * i + j] * E[j, j] for j in range(3)) for i in range(3)]
    across = [entries[9 + k] * 2.0 * E[i, j] for k, (i, j) in enumerate(((0, 1), (0, 2), (1, 2)))]
    return ufl.as_vector(normal + across)


def held_nodes(plan: PanelPlan, material_m: Array, middle: Indices) -> Indices:
    """Return the nodes that the clamps prescribe, of all nodes ``material_m`` (nodes, 3).

    A clamp with depth holds every node on and under it, so that the end cannot turn.  A clamp
    without depth (``clamp_m`` is 0) is a hinge as it is for the strip and for the sheet: it holds
    only those nodes of its edge that lie on the mid-surface, ``middle``, and the end face is free
    to turn about them.
    """
    held = np.flatnonzero(~np.isnan(plan.rectangle.end(material_m[:, :2])))
    return held if plan.rectangle.clamp_m > 0.0 else np.intersect1d(held, middle)


def solid(plan: PanelPlan) -> tuple[Structure, PiercedGrid, Indices]:
    """Make the structure of ``plan``, the grid of its mid-surface, and the node at each of the grid's."""
    grid = bearable_grid(plan)
    box = box_mesh(grid, plan.thickness_m)
    space = function_space(box, "Lagrange", 2, 3)
    material_m = space.tabulate_dof_coordinates()
    middle = np.flatnonzero(np.abs(material_m[:, 2]) < 0.1 * plan.thickness_m)
    held = held_nodes(plan, material_m, middle)
    structure = Structure(law(plan, fem.Function(space)), plan.material.density_kg_per_m3, held)
    return structure, grid, middle[grid.numbers_of(material_m[middle])]
