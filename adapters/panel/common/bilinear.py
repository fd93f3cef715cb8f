"""Rows of two points, one at each edge of a panel, and what lies between them.

The points are numbered row by row along the panel: y = 0 first, then y = width.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from adapters.panel.common.grid import locate, tensor_product
from orchestrator.ports import Array

if TYPE_CHECKING:
    from scipy.sparse import csr_array


def points_m(rows_m: Array, width_m: float) -> Array:
    """Return the material coordinates (2 rows, 2) of the rows at s = ``rows_m`` (increasing)."""
    return np.array([(s, y) for s in rows_m for y in (0.0, width_m)])


def interpolation(rows_m: Array, width_m: float, coordinates_m: Array) -> csr_array:
    """Return bilinear shape functions (n, points) at ``coordinates_m`` (n, 2).

    Raises ValueError for coordinates off the panel.
    """
    slack_m = 1e-9 * (rows_m[-1] - rows_m[0])
    row, s = locate(rows_m, coordinates_m[:, 0], slack_m)
    column, y = locate(np.array([0.0, width_m]), coordinates_m[:, 1], slack_m)
    along, across = np.stack([1 - s, s], axis=1), np.stack([1 - y, y], axis=1)
    return tensor_product(row, along, column, across, (len(rows_m), 2))


def half_row_mass_kg(rows_m: Array, mass_per_length_kg_per_m: float | Array) -> Array:
    """Return the lumped mass (points,): each cell gives equal parts to its four corners.  The mass per length
    is one number or one of each cell."""
    cell = mass_per_length_kg_per_m * np.diff(rows_m)
    row = np.zeros(len(rows_m))
    row[:-1] += cell / 2
    row[1:] += cell / 2
    return np.repeat(row / 2, 2)


def middle(points: Array) -> Array:
    """Return the mean of each row's two points, (rows, 3)."""
    return np.asarray((points[::2] + points[1::2]) / 2)


def half(points: Array) -> Array:
    """Return half the difference of each row's two points, (rows, 3)."""
    return np.asarray((points[1::2] - points[::2]) / 2)


def join_halves(middle: Array, half: Array) -> Array:
    """Return the points (2 rows, 3) of given middles and halves."""
    points = np.empty((len(middle), 2, 3))
    np.subtract(middle, half, out=points[:, 0])
    np.add(middle, half, out=points[:, 1])
    return points.reshape(-1, 3)
