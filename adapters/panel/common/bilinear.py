"""Rows of two points, one at each edge of a panel, and what lies between them.

The points are numbered row by row along the panel: y = 0 first, then y = width.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from orchestrator.ports import Array
from orchestrator.ports.geometry import Rectangle

if TYPE_CHECKING:
    from scipy.sparse import csr_array


def clamped_rows_m(rectangle: Rectangle, free_m: Array) -> Array:
    """Return the rows ``free_m`` of the free length, and one more under each clamp that has a depth."""
    under_m = np.array([rectangle.clamp_m] if rectangle.clamp_m > 0.0 else [])
    return np.concatenate([-under_m, free_m, rectangle.length_m + under_m])


def points_m(rows_m: Array, width_m: float) -> Array:
    """Return the material coordinates (2 rows, 2) of the rows at s = ``rows_m`` (increasing)."""
    return np.array([(s, y) for s in rows_m for y in (0.0, width_m)])


def interpolation(rows_m: Array, width_m: float, coordinates_m: Array) -> csr_array:
    """Return bilinear shape functions (n, points) at ``coordinates_m`` (n, 2).

    Raises ValueError for coordinates off the panel.
    """
    from scipy.sparse import csr_array

    s, y = coordinates_m.T
    slack = 1e-9 * (rows_m[-1] - rows_m[0])
    off = (s < rows_m[0] - slack) | (s > rows_m[-1] + slack) | (y < -slack) | (y > width_m + slack)
    if off.any() or not np.isfinite(coordinates_m).all():
        worst = coordinates_m[off | ~np.isfinite(coordinates_m).all(axis=1)][0]
        raise ValueError(f"material coordinates {worst.tolist()} m are off the panel")
    cell = np.clip(np.searchsorted(rows_m, s, side="right") - 1, 0, len(rows_m) - 2)
    t = (s - rows_m[cell]) / (rows_m[cell + 1] - rows_m[cell])
    u = y / width_m
    shapes = np.stack([(1 - t) * (1 - u), (1 - t) * u, t * (1 - u), t * u], axis=1)
    points = 2 * cell[:, None] + np.arange(4)
    starts = 4 * np.arange(len(s) + 1)
    return csr_array((shapes.ravel(), points.ravel(), starts), shape=(len(s), 2 * len(rows_m)))


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


def joined(middle: Array, half: Array) -> Array:
    """Return the points (2 rows, 3) of given middles and halves."""
    points = np.empty((len(middle), 2, 3))
    np.subtract(middle, half, out=points[:, 0])
    np.add(middle, half, out=points[:, 1])
    return points.reshape(-1, 3)
