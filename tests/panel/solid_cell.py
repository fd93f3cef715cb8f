"""One cell of a pattern of rectangles in three dimensions, for comparison with plate theory."""

from __future__ import annotations

import numpy as np
import ufl
from scipy.sparse import csc_matrix, csr_matrix
from scipy.sparse.linalg import splu

from adapters.panel.finite_element.compiled import assembled_matrix, function_space, linear_mesh

POISSON_RATIO = 0.49


def solid_cell(pattern, thickness_m, pieces=((8, 3), (3, 3), 2)):
    """Membrane and bending stiffness (3, 3) as in ``CellStiffness``, by quadratic hexahedra; the
    volume's part with 2 x 2 x 2 points.  ``pieces`` of (opening, land) along and across, and
    through the thickness."""
    box = _mesh(pattern, thickness_m, pieces)
    space = function_space(box, "Lagrange", 2, 3)
    u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
    mu = 1 / (2 * (1 + POISSON_RATIO))
    bulk = 1 / (3 * (1 - 2 * POISSON_RATIO))
    full = ufl.dx(metadata={"quadrature_degree": 4})
    reduced = ufl.dx(metadata={"quadrature_degree": 2})

    isochoric = 2 * mu * ufl.inner(ufl.dev(_strain(u)), ufl.dev(_strain(v))) * full
    volume = bulk * ufl.tr(_strain(u)) * ufl.tr(_strain(v)) * reduced
    stiffness = assembled_matrix(isochoric + volume)
    points_m = space.tabulate_dof_coordinates()
    modes = np.column_stack([mode.ravel() for mode in _modes(points_m)])
    fold = _periodic(points_m, pattern)
    right = (fold.T @ stiffness @ modes)[3:]  # the first point is held: no rigid motion
    folded = csc_matrix((fold.T @ stiffness @ fold)[3:, 3:])
    gained = right.T @ splu(folded, permc_spec="MMD_AT_PLUS_A").solve(right)
    area_m2 = pattern.pitch_along_m * pattern.pitch_across_m
    effective = (modes.T @ stiffness @ modes - gained) / area_m2
    return effective[:3, :3] / thickness_m, effective[3:, 3:] / (thickness_m**3 / 12)


def _strain(w):
    return ufl.sym(ufl.grad(w))


def _modes(points_m):
    """Displacements (points, 3) of unit strains, then of unit curvatures, (11, 22, 2 x 12)."""
    flat, height = points_m[:, :2], points_m[:, 2:]
    units = (np.diag([1.0, 0.0]), np.diag([0.0, 1.0]), np.array([[0.0, 0.5], [0.5, 0.0]]))
    for unit in units:
        yield np.column_stack([flat @ unit, 0 * height])
    for unit in units:
        sag = -0.5 * np.einsum("ni,ij,nj->n", flat, unit, flat)
        yield np.column_stack([height * (flat @ unit), sag])


def _mesh(pattern, thickness_m, pieces):
    along, across, through = pieces
    s = _lines(pattern.length_m, pattern.pitch_along_m, *along)
    y = _lines(pattern.width_m, pattern.pitch_across_m, *across)
    z = np.linspace(-0.5, 0.5, through + 1) * thickness_m
    shape = (len(s), len(y), len(z))
    number = np.arange(np.prod(shape)).reshape(shape)
    corners = [
        number[i : shape[0] - 1 + i, j : shape[1] - 1 + j, k : shape[2] - 1 + k].ravel()
        for k in (0, 1)
        for j in (0, 1)
        for i in (0, 1)
    ]
    cells = np.stack(corners, axis=1)
    points = np.stack(np.meshgrid(s, y, z, indexing="ij"), axis=-1).reshape(-1, 3)
    middle = points[cells].mean(axis=1)
    hole = (np.abs(middle[:, 0]) < pattern.length_m / 2) & (np.abs(middle[:, 1]) < pattern.width_m / 2)
    used, cells = np.unique(cells[~hole], return_inverse=True)
    return linear_mesh("hexahedron", points[used], cells.reshape(-1, 8))


def _lines(size_m, pitch_m, in_opening, in_land):
    """Cell borders over one pitch about an opening's middle."""
    half, end = size_m / 2, pitch_m / 2
    count = max((in_land + 1) // 2, 1)
    return np.concatenate(
        [
            np.linspace(-end, -half, count + 1)[:-1],
            np.linspace(-half, half, in_opening + 1),
            np.linspace(half, end, count + 1)[1:],
        ]
    )


def _periodic(points_m, pattern):
    """(all, independent) displacements: points a pitch apart at one height are one."""
    fine = 1e-7
    place = np.round(points_m / fine).astype(np.int64)
    pitch = np.round(np.array([pattern.pitch_along_m, pattern.pitch_across_m]) / fine)
    place[:, :2] %= pitch.astype(np.int64)
    _, same = np.unique(place, axis=0, return_inverse=True)
    columns = (3 * same[:, None] + np.arange(3)).ravel()
    return csr_matrix((np.ones(len(columns)), (np.arange(len(columns)), columns)))
