"""The sheet: a Kirchhoff-Love model on the flat, stress-free rectangle.

The unknown is the world position x(s, y) of the mid-surface.  Membrane: two-parameter
Mooney-Rivlin in plane stress, incompressible, so that C33 = 1/det C.  Bending: ``bending``.
Openings, if any: ``perforation``.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

from adapters.panel.common.grid import ElementGrid
from adapters.panel.common.moulding import curvature_amplitude_1_m
from adapters.panel.finite_element.bending import Bending, Moment, moulded_energy, plate, stiffness_matrix
from adapters.panel.finite_element.branch_strain import SHEET_ENTRIES, sheet_entries
from adapters.panel.finite_element.compiled import function_space
from adapters.panel.finite_element.dolfinx_versions import cell_corners
from adapters.panel.finite_element.structure import Law, Structure, cell_constants
from orchestrator.ports import Array, Indices
from orchestrator.ports.plans import HyperelasticPlan, PanelPlan

if TYPE_CHECKING:
    from adapters.panel.finite_element.perforation import Perforated

QUADRATURE_DEGREE = 4  # 3 x 3 Gauss points
POISSON_RATIO = 0.5


def flat_mesh(grid: ElementGrid) -> Any:
    """Make a mesh of one quadrilateral per cell of ``grid``, in its material coordinates."""
    along, across = grid.shape
    flat = mesh.create_rectangle(
        MPI.COMM_SELF, [[0, 0], [along, across]], [along, across], mesh.CellType.quadrilateral
    )
    nodes = flat.geometry.x
    nodes[:, 0] = np.interp(nodes[:, 0], np.arange(along + 1), grid.s_m)
    nodes[:, 1] = np.interp(nodes[:, 1], np.arange(across + 1), grid.y_m)
    return flat


def _membrane_energy(material: HyperelasticPlan, thickness_m: float, C: Any) -> Any:
    """Return the energy per area in J/m2 for the right Cauchy-Green tensor C (2 x 2) of the mid-surface."""
    trace, det = ufl.tr(C), ufl.det(C)
    return thickness_m * (material.c10_Pa * (trace + 1 / det - 3) + material.c01_Pa * (det + trace / det - 3))


def scaled_strain(entries: Any, C: Any) -> Any:
    """Return the vector (s0 E11 + s1 E22, s2 E11 + s3 E22, s4 2 E12) for five ``entries``."""
    E = 0.5 * (C - ufl.Identity(2))
    return ufl.as_vector(
        [
            entries[0] * E[0, 0] + entries[1] * E[1, 1],
            entries[2] * E[0, 0] + entries[3] * E[1, 1],
            2.0 * entries[4] * E[0, 1],
        ]
    )


def sheet(plan: PanelPlan) -> tuple[Structure, ElementGrid, Indices]:
    """Make the structure of ``plan``, its grid, and the numbers of the nodes at the grid's nodes."""
    pattern = plan.apertures
    region_m = pattern.region_m(plan.rectangle) if pattern else None
    grid = ElementGrid.of(plan.rectangle, plan.cells, region_m)
    flat = flat_mesh(grid)
    holes = openings(plan, flat)
    space = function_space(flat, "Lagrange", 2, 3)
    scalars = function_space(flat, "Lagrange", 2)
    material_m = space.tabulate_dof_coordinates()
    nodes = grid.numbers_of(material_m)
    held = nodes[~np.isnan(plan.rectangle.end(grid.nodes_m()))]
    areal_mass_kg_per_m2 = plan.material.density_kg_per_m3 * plan.thickness_m
    if holes:
        areal_mass_kg_per_m2 = holes.areal_mass_kg_per_m2(areal_mass_kg_per_m2)
    membrane = law(plan, fem.Function(space), holes)
    if plan.moulded_sag_m:
        energy = {**membrane.energy, "moulding": moulding(plan, membrane.position, holes)}
        membrane = replace(membrane, energy=energy)
    bent = bending(plan, scalars, material_m, holes)
    added_kg = point_masses_kg(plan, grid, nodes)
    joined = sides(plan, grid, nodes, held)
    return Structure(membrane, areal_mass_kg_per_m2, held, bent, added_kg, joined), grid, nodes


def sides(plan: PanelPlan, grid: ElementGrid, nodes: Indices, held: Indices) -> Indices | None:
    """Return the pairs of free nodes at both sides, (pairs, 2), that explicit steps join, or None."""
    if not plan.joined_sides or plan.integrator != "explicit":
        return None
    pairs = nodes.reshape(-1, 2 * len(grid.y_m) - 1)[:, [0, -1]]
    return np.asarray(pairs[~np.isin(pairs[:, 0], held)])


def point_masses_kg(plan: PanelPlan, grid: ElementGrid, nodes: Indices) -> Array:
    """Return the mass that point masses add to the mesh's nodes; ``nodes`` are those at the grid's nodes."""
    added_kg = np.zeros(len(nodes))
    if plan.point_masses:
        places_m = np.array([(mass.along_m, mass.across_m) for mass in plan.point_masses])
        mass_kg = np.array([mass.mass_kg for mass in plan.point_masses])
        added_kg[nodes] = grid.shares(places_m).T @ mass_kg
    return added_kg


def openings(plan: PanelPlan, flat: Any) -> Perforated | None:
    """Return the openings of ``plan`` on its mesh."""
    if plan.apertures is None:
        return None
    from adapters.panel.finite_element.perforation import perforate

    return perforate(plan, plan.apertures, flat)


def law(plan: PanelPlan, position: Any, holes: Perforated | None = None) -> Law:
    """Return the law of the membrane on the field ``position``."""
    gradient = ufl.grad(position)
    C = ufl.transpose(gradient) * gradient
    measure = ufl.dx(metadata={"quadrature_degree": QUADRATURE_DEGREE})
    energy = _membrane_energy(plan.material, plan.thickness_m, C)
    if holes:
        energy = holes.membrane_energy(energy, plan.material.youngs_modulus_Pa * plan.thickness_m, C)
    flat = position.function_space.mesh
    entries = cell_constants(flat, len(SHEET_ENTRIES))
    c10_N_per_m, c01_N_per_m = (c * plan.thickness_m for c in (plan.material.c10_Pa, plan.material.c01_Pa))
    solid, rest = membrane_shares(plan, flat, holes)
    return Law(
        position,
        {"membrane": energy * measure},
        scaled_strain(entries, C),
        entries,
        SHEET_ENTRIES,
        lambda strain: sheet_entries(c10_N_per_m, c01_N_per_m, solid, rest, strain),
        QUADRATURE_DEGREE,
        plan.material.branches,
    )


def membrane_shares(plan: PanelPlan, flat: Any, holes: Perforated | None) -> tuple[Array, Array]:
    """Return the share (cells,) of the solid law in each cell of the mesh ``flat``, and the stiffness
    (cells, 3, 3) on top of it, in N/m."""
    if holes is None:
        cells = flat.topology.index_map(flat.topology.dim).size_local
        return np.ones(cells), np.zeros((cells, 3, 3))
    share = holes.share.x.array
    factor, stiffer = holes.split(plan.material.youngs_modulus_Pa * plan.thickness_m)
    return 1.0 - (1.0 - factor) * share, share[:, None, None] * stiffer


def bending(plan: PanelPlan, scalars: Any, material_m: Array, holes: Perforated | None = None) -> Bending:
    """Make the bending, with plate stiffness  E t^3 / (12 (1 - nu^2))  where there are no openings."""
    rectangle = plan.rectangle
    sides = np.stack((rectangle.along, rectangle.across))
    flat_m = rectangle.corner_m + material_m[:, :2] @ sides
    matrix = stiffness_matrix(scalars, moment_law(plan, holes))
    return Bending(matrix, flat_m, plan.material.branches)


def moment_law(plan: PanelPlan, holes: Perforated | None) -> Moment:
    """Return the law of the bending moments, with or without openings."""
    beam_N_m = plan.material.youngs_modulus_Pa * plan.thickness_m**3 / 12
    return holes.moment(beam_N_m) if holes else plate(beam_N_m / (1 - POISSON_RATIO**2), POISSON_RATIO)


def moulding(plan: PanelPlan, position: Any, holes: Perforated | None) -> Any:
    """Return the energy of the moments of the moulded, stress-free curvature of the free length."""
    flat = position.function_space.mesh
    free = cell_constants(flat, 1)
    s_m = flat.geometry.x[cell_corners(flat), 0].mean(axis=1)
    free.x.array[:] = (s_m > 0.0) & (s_m < plan.rectangle.length_m)
    wave = ufl.cos(2 * ufl.pi * ufl.SpatialCoordinate(flat)[0] / plan.rectangle.length_m)
    along_1_m = -curvature_amplitude_1_m(plan) * free[0] * wave
    curvature_1_m = ufl.as_matrix([[along_1_m, 0.0], [0.0, 0.0]])
    across = ufl.as_vector([float(value) for value in plan.rectangle.across])
    return moulded_energy(position, moment_law(plan, holes), curvature_1_m, across)
