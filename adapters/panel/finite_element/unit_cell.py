"""The stiffness of a perforated sheet: one cell of its pattern, repeated for ever, on DOLFINx.

gmsh meshes the cell with triangles that match on opposite sides; openings that cross its border
appear on both sides of it.  Membrane: plane stress.  Bending: Reissner-Mindlin, because lands are
often no wider than the sheet is thick.  Small strain, incompressible (Poisson's ratio 1/2): only
geometry counts.
docs/theory/perforated_panel.md
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI
from scipy.sparse import csc_matrix, csr_matrix
from scipy.sparse.linalg import splu

from adapters.panel.finite_element.compiled import assembled_matrix, form, function_space
from orchestrator.ports import Array, Indices
from orchestrator.ports.geometry import AperturePattern
from orchestrator.ports.meshing import closed_line, gmsh_session, made_triangles

TRIANGLES_PER_LAND = 6
MOST_TRIANGLES = 6_000
TRIANGLES_PER_OPENING = 60  # of a cell with very many: at least so many
POISSON_RATIO = 0.5
SHEAR_CORRECTION = 5 / 6
# plane stress of unit modulus, for strains (11, 22, 2 x 12)
SOLID = np.array([[1, POISSON_RATIO, 0], [POISSON_RATIO, 1, 0], [0, 0, (1 - POISSON_RATIO) / 2]]) / (
    1 - POISSON_RATIO**2
)


@dataclass(frozen=True)
class CellStiffness:
    """The stiffness of a pattern's cell, for strains and curvatures (11, 22, 2 x 12) along and across.

    ``membrane`` (3, 3) is in units of E t, and ``bending`` (3, 3) in units of E t^3 / 12; without openings
    both are ``SOLID``.
    """

    membrane: Array
    bending: Array


def along(stiffness: Array, hindered_share: float = 0.0) -> float:
    """Return the stiffness along of a strip in units of E; a share of its contraction across is hindered."""
    free = 1.0 / np.linalg.inv(stiffness)[0, 0]
    return float((1 - hindered_share) * free + hindered_share * stiffness[0, 0])


@cache
def cell_stiffness(apertures: AperturePattern, thickness_m: float) -> CellStiffness:
    """Return the stiffness of the pattern in a sheet of ``thickness_m``; margins do not matter."""
    cell = _mesh(*cell_triangles(apertures))
    area_m2 = float(np.prod(cell_m(apertures)))
    period_m = np.array(cell_m(apertures))
    return CellStiffness(
        _effective(_membrane, cell, 2, period_m) / area_m2,
        _effective(_bending(cell, thickness_m), cell, 3, period_m) / area_m2,
    )


def _mesh(points_m: Array, triangles: Indices) -> Any:
    linear = ufl.Mesh(ufl.VectorElement("Lagrange", ufl.Cell("triangle", geometric_dimension=2), 1))
    return mesh.create_mesh(MPI.COMM_SELF, triangles, points_m, linear)


def _strain(u: Any) -> Any:
    """Return the strain (11, 22, 2 x 12) of the first two components of a field."""
    g = ufl.grad(u)
    return ufl.as_vector([g[0, 0], g[1, 1], g[0, 1] + g[1, 0]])


def _solid(strain: Any) -> Any:
    return ufl.dot(ufl.as_matrix(SOLID.tolist()), strain)


def _membrane(u: Any, v: Any) -> Any:
    """Return the energy product of two displacement fluctuations."""
    return ufl.inner(_solid(_strain(u)), _strain(v)) * ufl.dx


def _bending(cell: Any, thickness_m: float) -> Any:
    """Return the energy product of two fields (slope 1, slope 2, deflection), over t^3 / 12.

    The shear part has reduced integration, so that thin sheets do not lock.
    """
    shear = SHEAR_CORRECTION / (2 * (1 + POISSON_RATIO)) * 12 / thickness_m**2
    shear_1_m2 = fem.Constant(cell, shear)

    def turned(u: Any) -> Any:  # transverse shear
        return ufl.grad(u)[2, :] - ufl.as_vector([u[0], u[1]])

    def product(u: Any, v: Any) -> Any:
        reduced = ufl.dx(metadata={"quadrature_degree": 2})
        return (
            ufl.inner(_solid(_strain(u)), _strain(v)) * ufl.dx
            + shear_1_m2 * ufl.inner(turned(u), turned(v)) * reduced
        )

    return product


def _effective(product: Any, cell: Any, size: int, period_m: Array) -> Array:
    """Return the energy (3, 3) of the unit strains with the periodic fluctuation that makes it least."""
    space = function_space(cell, ufl.VectorElement("Lagrange", cell.ufl_cell(), 2, dim=size))
    u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
    fold = _periodic(space.tabulate_dof_coordinates()[:, :2], period_m, size)
    stiffness = fold.T @ assembled_matrix(product(u, v)) @ fold
    loads = np.column_stack([_load(unit, v) for unit in np.eye(3)])
    kept = np.arange(stiffness.shape[0] - size)  # the last point is held: no rigid motion
    right = (fold.T @ loads)[kept]
    factors = splu(
        csc_matrix(stiffness[kept][:, kept]),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )
    answer = factors.solve(right)
    solid_m2 = fem.assemble_scalar(form(fem.Constant(cell, 1.0) * ufl.dx))
    # the pattern is its own mirror image, so that shear couples to nothing but by the mesh
    uncoupled = np.array([[1, 1, 0], [1, 1, 0], [0, 0, 1]])
    return np.asarray(uncoupled * (solid_m2 * SOLID - right.T @ answer))


def _load(unit: Array, test: Any) -> Array:
    """Return the virtual work of the stress of a uniform strain or curvature."""
    stress = ufl.as_vector((SOLID @ unit).tolist())
    work: Array = fem.assemble_vector(form(ufl.inner(stress, _strain(test)) * ufl.dx)).array
    return work.copy()


def _periodic(points_m: Array, period_m: Array, size: int) -> csr_matrix:
    """Return the matrix (all unknowns, independent unknowns) that identifies points a period apart.

    Each point has ``size`` components.
    """
    fine = 1e-7 * period_m
    place = np.round(points_m / fine).astype(np.int64) % np.round(period_m / fine).astype(np.int64)
    _, same = np.unique(place, axis=0, return_inverse=True)
    columns = (size * same[:, None] + np.arange(size)).ravel()
    rows = np.arange(len(columns))
    return csr_matrix((np.ones(len(rows)), (rows, columns)))


def cell_m(apertures: AperturePattern) -> tuple[float, float]:
    """Return the period along and across: two rows if they are staggered, and that of drawn openings."""
    if apertures.drawn:
        return apertures.drawn.period_m
    rows = 2 if apertures.stagger else 1
    return rows * apertures.pitch_along_m, apertures.pitch_across_m


def cell_triangles(apertures: AperturePattern) -> tuple[Array, Indices]:
    """Return points (n, 2) and triangles (m, 3) of the material in one period."""
    with gmsh_session() as gmsh:
        return _meshed(gmsh, apertures)


def _meshed(gmsh: Any, apertures: AperturePattern) -> tuple[Array, Indices]:
    model, (along_m, across_m) = gmsh.model.occ, cell_m(apertures)
    box = model.addRectangle(0.0, 0.0, 0.0, along_m, across_m)
    outlines = _outlines(apertures)
    holes = [(2, model.addPlaneSurface([closed_line(model, outline)])) for outline in outlines]
    model.cut([(2, box)], holes)
    model.synchronize()
    for axis, period_m in ((0, along_m), (1, across_m)):
        _match(gmsh, axis, period_m)
    narrowest_m = min(apertures.land_m, apertures.spheres_m[0])
    solid_m2 = apertures.solid_share * along_m * across_m
    most_triangles = max(MOST_TRIANGLES, TRIANGLES_PER_OPENING * len(outlines))
    size_m = max(narrowest_m / TRIANGLES_PER_LAND, math.sqrt(2.5 * solid_m2 / most_triangles))
    gmsh.option.setNumber("Mesh.MeshSizeMin", size_m)
    gmsh.option.setNumber("Mesh.MeshSizeMax", size_m)
    gmsh.model.mesh.generate(2)
    points_m, triangles = made_triangles(gmsh)
    used, triangles = np.unique(triangles, return_inverse=True)
    return points_m[used], triangles.reshape(-1, 3)


def _outlines(apertures: AperturePattern) -> list[Array]:
    """Return the outlines of all openings that reach into the cell."""
    if apertures.drawn:
        return apertures.drawn.cell_m
    along_m, across_m = apertures.pitch_along_m, apertures.pitch_across_m
    rows = (0.0, apertures.stagger) if apertures.stagger else (0.0,)
    outline = apertures.outline_m()
    return [
        outline + np.array(((row + 0.5) * along_m, (0.5 + shift + image) * across_m))
        for row, shift in enumerate(rows)
        for image in ((0, -1) if shift else (0,))
    ]


def _match(gmsh: Any, axis: int, period_m: float) -> None:
    """Give the curves on the far side of the cell the mesh of those on the near side."""
    near: dict[tuple[int, ...], int] = {}
    far: dict[tuple[int, ...], int] = {}
    fine = 1e-6 * period_m
    for _, curve in gmsh.model.getEntities(1):
        low = np.array(gmsh.model.getBoundingBox(1, curve))
        place = tuple(np.round(np.delete(low.reshape(2, 3), axis, axis=1).ravel() / fine, 0))
        ends = low.reshape(2, 3)[:, axis]
        if (np.abs(ends) < 10 * fine).all():
            near[place] = curve
        elif (np.abs(ends - period_m) < 10 * fine).all():
            far[place] = curve
    shift = np.eye(4)
    shift[axis, 3] = period_m
    order = sorted(near)
    gmsh.model.mesh.setPeriodic(
        1, [far[place] for place in order], [near[place] for place in order], shift.ravel().tolist()
    )
