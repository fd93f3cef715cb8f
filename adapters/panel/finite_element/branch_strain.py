"""The strain on which Maxwell branches act, scaled by the elastic stiffness of the shape at rest.

A branch answers a small change of the stretches about that shape as the elastic material does, times its
ratio; the loss factor of a small vibration is then the material's, however much a panel is stretched.  In
logarithms of the principal stretches l, with l1 l2 l3 = 1, Mooney-Rivlin's energy has the derivatives

    t = 2 (C10 l^2 - C01 / l^2),    h = 4 (C10 l^2 + C01 / l^2).

The change of the stresses on the undeformed area is h - t, and across the axes (t_i - t_j) / (l_i - l_j),
all less what acts across the thickness, where nothing does (Ogden, Non-Linear Elastic Deformations, 1984,
chapter 6).  Changes of Green's strain E are l_i dl_i, and (l_i + l_j) / 2 times the change across the axes.
The axes are those of the panel, along which it is stretched.
"""

from __future__ import annotations

import numpy as np

from orchestrator.ports import Array

SHEET_ENTRIES = np.array([1.0, 0.0, 0.0, 1.0, 1.0])
"""Entries with which the scaled strain of a sheet is (E11, E22, 2 E12)."""
SOLID_ENTRIES = np.concatenate([np.eye(3).ravel(), np.ones(3)])
"""Entries with which the scaled strain of a solid is (E11, E22, E33, 2 E12, 2 E13, 2 E23)."""


def sheet_entries(c10: float, c01: float, solid: Array, rest: Array, strain: Array) -> Array:
    """Return the entries (cells, 5) of ``sheet_forms.scaled_strain`` about a strain (cells, 3) at rest.

    Half the square of the scaled strain is the branches' energy per area, over their ratio.  ``c10`` and
    ``c01`` are in N/m; ``solid`` (cells,) is the share of this law, and ``rest`` (cells, 3, 3) the stiffness
    on top of it, in N/m, which acts on (C - 1/C) / 4 (``perforation``).
    """
    stretch = _stretches(strain)
    stress, change = _derivatives(c10, c01, stretch)
    stress = solid[:, None] * (stress - stress[:, 2:])
    matrix = (solid * change[:, 2])[:, None, None] + _diagonal(solid[:, None] * change[:, :2])
    twice_log = 2 * np.log(stretch[:, :2])
    more = np.einsum("nij,nj->ni", rest[:, :2, :2], np.sinh(twice_log) / 2)
    slope = np.cosh(twice_log)
    matrix = matrix + slope[:, :, None] * rest[:, :2, :2] * slope[:, None, :]
    matrix = matrix + _diagonal(2 * np.sinh(twice_log) * more - slope * more - stress[:, :2])
    square = stretch[:, :2] ** 2
    root = _root(matrix / square[:, :, None] / square[:, None, :])
    across = np.sqrt(_across(stress, change, stretch, solid, 0, 1) + rest[:, 2, 2])
    return np.column_stack([root.reshape(-1, 4), across])


def solid_entries(c10_Pa: float, c01_Pa: float, strain: Array) -> Array:
    """Return the entries (cells, 12) of ``solid_forms.scaled_strain`` about a strain (cells, 6) at rest.

    Half the square of the scaled strain is the branches' energy per volume, over their ratio.  They do not
    answer a change of volume.
    """
    stretch = _stretches(strain)
    stress, change = _derivatives(c10_Pa, c01_Pa, stretch)
    stress = stress - stress[:, 2:]
    deviator = np.eye(3) - 1 / 3
    root = _root(deviator @ _diagonal(change - stress) @ deviator) / stretch[:, None, :] ** 2
    one = np.ones(len(strain))
    across = [np.sqrt(_across(stress, change, stretch, one, i, j)) for i, j in ((0, 1), (0, 2), (1, 2))]
    return np.column_stack([root.reshape(-1, 9), *across])


def _stretches(strain: Array) -> Array:
    """Return the principal stretches (cells, 3) of an incompressible panel, from E11 and E22."""
    first, second = np.sqrt(1 + 2 * strain[:, :2]).T
    return np.column_stack([first, second, 1 / (first * second)])


def _derivatives(c10: float, c01: float, stretch: Array) -> tuple[Array, Array]:
    """Return the first and second derivatives (cells, 3) of the energy by each logarithm of a stretch."""
    first, second = c10 * stretch**2, c01 / stretch**2
    return np.asarray(2 * (first - second)), np.asarray(4 * (first + second))


def _diagonal(values: Array) -> Array:
    """Return the diagonal matrices (cells, n, n) of ``values`` (cells, n)."""
    return np.asarray(values[:, :, None] * np.eye(values.shape[1]))


def _across(stress: Array, change: Array, stretch: Array, solid: Array, i: int, j: int) -> Array:
    """Return the stiffness (cells,) of 2 E_ij: the solid law turns its stresses with the axes."""
    apart = stretch[:, i] - stretch[:, j]
    alike = np.abs(apart) < 1e-6
    # equal stretches: the limit of the quotient, with the mean of both derivatives
    limit = solid * (change[:, i] + change[:, j]) / 2 - (stress[:, i] + stress[:, j]) / 2
    per_length = stress / stretch
    quotient = (per_length[:, i] - per_length[:, j]) / np.where(alike, 1.0, apart)
    turning = np.where(alike, limit / (stretch[:, i] * stretch[:, j]), quotient)
    return np.asarray(np.maximum(turning, 0.0) / (stretch[:, i] + stretch[:, j]) ** 2 * 2)


def _root(matrix: Array) -> Array:
    """Return the symmetric roots of symmetric matrices (cells, n, n)."""
    values, vectors = np.linalg.eigh(matrix)
    scaled = vectors * np.sqrt(np.maximum(values, 0.0))[:, None, :]
    return np.asarray(scaled @ np.swapaxes(vectors, 1, 2))
