"""The stiffness of a perforated sheet: one cell of its pattern, repeated for ever, on DOLFINx.

gmsh meshes the cell with triangles that match on opposite sides; openings that cross its border
appear on both sides of it.  Of very many openings that do not repeat, windows with mirrored borders stand
for all.  Membrane: plane stress.  Bending: Reissner-Mindlin, because lands are
often no wider than the sheet is thick.  Small strain, incompressible (Poisson's ratio 1/2): only
geometry counts.
docs/theory/perforated_panel.md
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import ufl
from dolfinx import fem
from scipy.sparse import coo_array, csc_matrix, identity
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu

from adapters.panel.finite_element.compiled import assembled_matrix, form, function_space, linear_mesh
from orchestrator.ports import Array, Indices
from orchestrator.ports.geometry import AperturePattern
from orchestrator.ports.meshing import closed_line, gmsh_session, made_triangles

TRIANGLES_PER_LAND = 6
MOST_TRIANGLES = 6_000
TRIANGLES_PER_OPENING = 60  # of a cell with very many: at least so many
MOST_OPENINGS = 100  # of a cell that is solved as a whole
WINDOW = 6.0  # pitches of a window along and across
FEWEST_WINDOWS = 6
STANDARD_ERROR = 0.01  # of the mean of windows, over it
POISSON_RATIO = 0.5
SHEAR_CORRECTION = 5 / 6
# plane stress of unit modulus, for strains (11, 22, 2 x 12)
SOLID = np.array([[1, POISSON_RATIO, 0], [POISSON_RATIO, 1, 0], [0, 0, (1 - POISSON_RATIO) / 2]]) / (
    1 - POISSON_RATIO**2
)


Conditions = list[tuple[list[int], csc_matrix]]
"""The numbers of unit strains, and the matrix (all unknowns, free unknowns) of their fluctuation."""


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
    outlines_m, sides_m = _outlines(apertures), np.array(cell_m(apertures))
    if apertures.drawn is None or apertures.drawn.openings_in_period <= MOST_OPENINGS:
        return CellStiffness(*_stiffness(cell_triangles(apertures), sides_m, thickness_m, mirrored=False))
    windows = _windows(outlines_m, sides_m, WINDOW * np.array(apertures.drawn.pitch_m))
    shares, found = np.empty(0), np.empty((0, 2, 3, 3))
    for window_m, side_m in windows:
        mesh = _triangles(apertures, window_m, side_m, mirrored=True)
        shares = np.append(shares, _area_m2(*mesh) / side_m.prod())
        found = np.append(found, [_stiffness(mesh, side_m, thickness_m, mirrored=True)], axis=0)
        mean, error = _mean(shares, found, apertures.solid_share, len(windows))
        if len(found) >= FEWEST_WINDOWS and error < STANDARD_ERROR:
            break
    return CellStiffness(*mean)


def _windows(outlines_m: list[Array], sides_m: Array, window_m: Array) -> list[tuple[list[Array], Array]]:
    """Return the outlines and the sides (2,) of the windows of some ``window_m`` (2,) that fill a cell, in an
    order that is random, and the same each time."""
    counts = np.maximum(1, np.round(sides_m / window_m).astype(int))
    side_m = sides_m / counts
    places = np.stack(np.unravel_index(np.arange(counts.prod()), counts), axis=1)
    windows = []
    for place in np.random.default_rng(0).permutation(places):
        moved = [outline - place * side_m for outline in outlines_m]
        near = [at for at in moved if ((at.max(axis=0) > 0) & (at.min(axis=0) < side_m)).all()]
        windows.append((near, side_m))
    return windows


def _mean(shares: Array, found: Array, share: float, windows: int) -> tuple[Array, float]:
    """Return the mean (2, 3, 3) of all ``windows`` by the stiffness (n, 2, 3, 3) of some, and the largest
    standard error on its diagonals over their values.

    The mean apparent stiffness is that of the whole (Kanit, Forest, Galliet, Mounoury and Jeulin, Int. J.
    Solids Struct. 40 (2003) 3647-3679, doi 10.1016/S0020-7683(03)00143-4).  The solid ``share`` of the whole
    is known, and ``shares`` (n,) are those of the windows: the estimate is the regression's (Cochran,
    Sampling Techniques, 3rd ed., Wiley 1977, ch. 7).
    """
    count, mean, beyond = len(shares), found.mean(axis=0), shares - shares.mean()
    square, lacking = float(beyond @ beyond), share - shares.mean()
    if count < 3 or square == 0.0:
        return mean, math.inf
    slope = np.tensordot(beyond, found, axes=1) / square
    rest = np.diagonal(found - mean - np.multiply.outer(beyond, slope), axis1=2, axis2=3)
    mean = mean + lacking * slope
    variance = (rest**2).sum(axis=0) / (count - 2) * ((1 - count / windows) / count + lacking**2 / square)
    return mean, float((np.sqrt(variance) / np.diagonal(mean, axis1=1, axis2=2)).max())


def _area_m2(points_m: Array, triangles: Indices) -> float:
    one, two = (points_m[triangles[:, k]] - points_m[triangles[:, 0]] for k in (1, 2))
    return float(np.abs(one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0]).sum() / 2)


def _stiffness(triangles: tuple[Array, Indices], sides_m: Array, thickness_m: float, mirrored: bool) -> Array:
    """Return the membrane and the bending stiffness (2, 3, 3) of a cell that repeats, or is ``mirrored``."""
    cell = linear_mesh("triangle", *triangles)
    energies = [
        _effective(product, cell, _conditions(size, sides_m, mirrored), size)
        for product, size in ((_membrane, 2), (_bending(cell, thickness_m), 3))
    ]
    return np.array(energies) / float(np.prod(sides_m))


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


def _effective(product: Any, cell: Any, conditions: Callable[[Array], Conditions], size: int) -> Array:
    """Return the energy (3, 3) of the unit strains with the fluctuation that makes it least, among those that
    keep the ``conditions`` of its points (n, 2)."""
    space = function_space(cell, "Lagrange", 2, size)
    u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
    whole = assembled_matrix(product(u, v))
    loads = np.column_stack([_load(unit, v) for unit in np.eye(3)])
    solid_m2 = fem.assemble_scalar(form(fem.Constant(cell, 1.0) * ufl.dx))
    energy = solid_m2 * SOLID
    for strains, fold in conditions(space.tabulate_dof_coordinates()[:, :2]):
        right = fold.T @ loads[:, strains]
        factors = splu(
            csc_matrix(fold.T @ whole @ fold),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
        energy[np.ix_(strains, strains)] -= right.T @ factors.solve(right)
    # the pattern is its own mirror image, so that shear couples to nothing but by the mesh
    uncoupled = np.array([[1, 1, 0], [1, 1, 0], [0, 0, 1]])
    return np.asarray(uncoupled * energy)


def _load(unit: Array, test: Any) -> Array:
    """Return the virtual work of the stress of a uniform strain or curvature."""
    stress = ufl.as_vector((SOLID @ unit).tolist())
    work: Array = fem.assemble_vector(form(ufl.inner(stress, _strain(test)) * ufl.dx)).array
    return work.copy()


def _conditions(size: int, sides_m: Array, mirrored: bool) -> Callable[[Array], Conditions]:
    """Return the conditions of a cell that repeats, or is ``mirrored``; a point has ``size`` components."""
    fold = _mirrored if mirrored else _periodic
    return lambda points_m: fold(points_m, sides_m, size)


def _mirrored(points_m: Array, sides_m: Array, size: int) -> Conditions:
    """Return the conditions of a cell that its borders mirror: stretched or bent, it stays its own mirror
    image; sheared or twisted, it turns into its negative.

    So both fulfil Hill's condition, as any such mixture of given displacements and tractions does (Hazanov
    and Huet, J. Mech. Phys. Solids 42 (1994) 1995-2011, doi 10.1016/0022-5096(94)90022-1).
    """
    along, across = ((np.abs(points_m) < 1e-7 * sides_m) | (np.abs(points_m - sides_m) < 1e-7 * sides_m)).T
    first = np.arange(len(points_m)) == 0  # no rigid motion
    alike = np.column_stack([along, across, first])[:, :size]
    contrary = np.column_stack([across, along, along | across])[:, :size]
    unknowns = identity(size * len(points_m), format="csc")
    return [
        ([0, 1], unknowns[:, np.flatnonzero(~alike.ravel())]),
        ([2], unknowns[:, np.flatnonzero(~contrary.ravel())]),
    ]


def _periodic(points_m: Array, period_m: Array, size: int) -> Conditions:
    """Return the condition that points a period apart move alike, and that the last does not move."""
    fine = 1e-7 * period_m
    place = np.round(points_m / fine).astype(np.int64) % np.round(period_m / fine).astype(np.int64)
    _, same = np.unique(place, axis=0, return_inverse=True)
    columns = (size * same[:, None] + np.arange(size)).ravel()
    rows = np.arange(len(columns))
    fold = csc_matrix((np.ones(len(rows)), (rows, columns)))
    return [([0, 1, 2], fold[:, :-size])]


def cell_m(apertures: AperturePattern) -> tuple[float, float]:
    """Return the period along and across: two rows if they are staggered, and that of drawn openings."""
    if apertures.drawn:
        return apertures.drawn.period_m
    rows = 2 if apertures.stagger else 1
    return rows * apertures.pitch_along_m, apertures.pitch_across_m


def cell_triangles(apertures: AperturePattern) -> tuple[Array, Indices]:
    """Return points (n, 2) and triangles (m, 3) of the material in one period."""
    return _triangles(apertures, _outlines(apertures), np.array(cell_m(apertures)), mirrored=False)


def _triangles(
    apertures: AperturePattern, outlines_m: list[Array], sides_m: Array, mirrored: bool
) -> tuple[Array, Indices]:
    """Return points (n, 2) and triangles (m, 3) of the material between outlines in a cell.

    Opposite sides have the same points unless it is ``mirrored``.  Corners that an opening cuts off from a
    mirrored cell carry nothing, and are left out.
    """
    with gmsh_session() as gmsh:
        points_m, triangles = _meshed(gmsh, apertures, outlines_m, sides_m, mirrored)
    edges = triangles[:, [0, 1, 2]], triangles[:, [1, 2, 0]]
    graph = coo_array((np.ones(triangles.size), (edges[0].ravel(), edges[1].ravel())), 2 * (len(points_m),))
    _, part = connected_components(graph, directed=False)
    held_together = part == np.bincount(part).argmax()
    number = np.cumsum(held_together) - 1
    return points_m[held_together], number[triangles[held_together[triangles[:, 0]]]]


def _meshed(
    gmsh: Any, apertures: AperturePattern, outlines: list[Array], sides_m: Array, mirrored: bool
) -> tuple[Array, Indices]:
    model, (along_m, across_m) = gmsh.model.occ, sides_m
    box = model.addRectangle(0.0, 0.0, 0.0, along_m, across_m)
    holes = [(2, model.addPlaneSurface([closed_line(model, outline)])) for outline in outlines]
    model.cut([(2, box)], holes)
    model.synchronize()
    for axis, period_m in () if mirrored else ((0, along_m), (1, across_m)):
        _match(gmsh, axis, period_m)
    narrowest_m = min(apertures.land_m, apertures.spheres_m[0])
    solid_m2 = apertures.solid_share * along_m * across_m
    per_opening = TRIANGLES_PER_OPENING * len(outlines)
    most_triangles = per_opening if mirrored else max(MOST_TRIANGLES, per_opening)
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
