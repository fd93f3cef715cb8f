"""Rows of two points, one at each edge of a panel, and what lies between them.

The points are numbered row by row along the panel: y = 0 first, then y = width.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from adapters.panel.common.grid import locate, tensor_product
from orchestrator.ports import Array, Indices, Interpolation

if TYPE_CHECKING:
    from scipy.sparse import csr_array


def points_m(rows_m: Array, width_m: float) -> Array:
    """Return the material coordinates (2 rows, 2) of the rows at s = ``rows_m`` (increasing)."""
    return np.array([(s, y) for s in rows_m for y in (0.0, width_m)])


def interpolation(
    rows_m: Array, width_m: float, coordinates_m: Array, row_slopes_1_m: Array | None = None
) -> Interpolation:
    """Return bilinear shape functions at ``coordinates_m`` (n, 2), or (n, 3) with offsets.

    The slope along the panel is that between the rows on either side, or goes linearly from row to row if
    ``row_slopes_1_m`` (rows, rows) gives it at the rows: the normal then has no jumps.  Raises ValueError for
    coordinates off the panel.
    """
    from scipy.sparse import csr_array

    slack_m, edges_m = 1e-9 * (rows_m[-1] - rows_m[0]), np.array([0.0, width_m])

    def shapes(at_m: Array) -> tuple[Indices, Array, Indices, Array]:
        row, s = locate(rows_m, at_m[:, 0], slack_m)
        column, y = locate(edges_m, at_m[:, 1], slack_m)
        return row, np.stack([1 - s, s], axis=1), column, np.stack([1 - y, y], axis=1)

    def values(at_m: Array) -> csr_array:
        return tensor_product(*shapes(at_m), (len(rows_m), 2))

    def slopes(at_m: Array) -> tuple[csr_array, csr_array]:
        row, along, column, across = shapes(at_m)
        rise = np.tile([-1.0, 1.0], (len(at_m), 1))
        over_width = tensor_product(row, along, column, rise / width_m, (len(rows_m), 2))
        if row_slopes_1_m is not None:
            return csr_array(values(at_m) @ np.kron(row_slopes_1_m, np.eye(2))), over_width
        between = rise / (rows_m[row + 1] - rows_m[row])[:, None]
        return tensor_product(row, between, column, across, (len(rows_m), 2)), over_width

    return Interpolation.of(coordinates_m, values, slopes)


def row_slopes_1_m(rows_m: Array, held: npt.NDArray[np.bool_]) -> Array:
    """Return the matrix (rows, rows) of the slopes at rows, by second-order differences between free rows.

    ``held`` (rows,) are the rows of clamps.  A clamp of two rows has the slope between these, since it is
    rigid.
    """
    slopes = np.zeros((len(rows_m), len(rows_m)))
    clamped = bool(held[1])
    free = slice(1, -1) if clamped else slice(None)
    free_m = rows_m[free]
    slopes[free, free] = np.gradient(
        np.eye(len(free_m)), free_m, axis=0, edge_order=2 if len(free_m) > 2 else 1
    )
    if clamped:
        for rows in (slice(0, 2), slice(-2, None)):
            slopes[rows] = 0.0
            slopes[rows, rows] = np.array([-1.0, 1.0]) / np.ptp(rows_m[rows])
    return slopes


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
