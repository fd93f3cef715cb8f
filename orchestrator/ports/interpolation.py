"""Points on a panel, and beside it along its normal, as functions of the panel's own surface points."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from orchestrator.ports.interface_records import Array, Indices

if TYPE_CHECKING:
    from scipy.sparse import csr_array

Values = Callable[[Array], "csr_array"]
"""The matrix (k, surface points) that takes values at the surface points to coordinates (k, 2) in m."""
Slopes = Callable[[Array], "tuple[csr_array, csr_array]"]
"""The matrices (k, surface points) of the values' derivatives with respect to s and to y, in 1/m."""


@dataclass(frozen=True)
class Interpolation:
    """Where n points are, of which some stand at an offset from the panel's surface along its normal.

    With the surface points at x (surface points, 3), point i is at

        values x + offset_m n,    n = a / |a|,    a = (along x) x (across x),

    its foot on the surface plus its offset along the normal of the surface as it is bent now.  The load on
    the points goes to the surface points by the transpose of this function's derivative
    (docs/theory/coupling.md), so that force, moment and virtual work are the same on both sides.

    Parameters
    ----------
    values
        H (n, surface points).  Its rows sum to one.
    along, across
        The derivatives of ``values`` with respect to s and y, in 1/m, (n, surface points).  Their rows sum to
        zero; rows of points without an offset are empty.
    offset_m
        (n,), positive on the side of the bed.
    """

    values: csr_array
    along: csr_array
    across: csr_array
    offset_m: Array

    @staticmethod
    def of(coordinates_m: Array, values: Values, slopes: Slopes) -> Interpolation:
        """Return the interpolation at material coordinates, from a panel's shape functions.

        Parameters
        ----------
        coordinates_m
            (n, 2), or (n, 3) with the offset along the normal.
        values, slopes
            The shape functions and their derivatives; these are asked for points with an offset only.

        Raises
        ------
        ValueError
            The coordinates have another shape, an offset is not finite, or as the functions do.

        Examples
        --------
        Two points joined by a line along s, and a point 3 mm above its middle.

        >>> import numpy as np
        >>> from scipy.sparse import csr_array
        >>> def values(at_m):
        ...     return csr_array(np.stack([1.0 - at_m[:, 0], at_m[:, 0]], axis=1))
        >>> def slopes(at_m):
        ...     return csr_array(np.tile([-1.0, 1.0], (len(at_m), 1))), csr_array((len(at_m), 2))
        >>> points = Interpolation.of(np.array([[0.5, 0.0, 0.003], [1.0, 0.0, 0.0]]), values, slopes)
        >>> points.values.toarray().tolist(), points.along.toarray().tolist(), points.offset_m.tolist()
        ([[0.5, 0.5], [0.0, 1.0]], [[-1.0, 1.0], [0.0, 0.0]], [0.003, 0.0])
        """
        if coordinates_m.ndim != 2 or coordinates_m.shape[1] not in (2, 3):
            raise ValueError(
                f"material coordinates: shape (n, 2) or (n, 3) wanted, got {coordinates_m.shape}"
            )
        places_m, offset_m = coordinates_m[:, :2], np.zeros(len(coordinates_m))
        if coordinates_m.shape[1] == 3:
            offset_m = coordinates_m[:, 2].copy()
        if not np.isfinite(offset_m).all():
            raise ValueError(f"offset of a material coordinate: {offset_m[~np.isfinite(offset_m)][0]} m")
        H, beside = values(places_m), np.flatnonzero(offset_m)
        if not len(beside):
            return Interpolation.on_surface(H)
        along, across = (_among(len(offset_m), beside, of_those) for of_those in slopes(places_m[beside]))
        return Interpolation(H, along, across, offset_m)

    @staticmethod
    def on_surface(values: csr_array) -> Interpolation:
        """Return the interpolation of points of the surface itself, by the matrix ``values``."""
        from scipy.sparse import csr_array

        none = csr_array(values.shape)
        return Interpolation(values, none, none, np.zeros(values.shape[0]))

    @staticmethod
    def joined(parts: Sequence[Interpolation]) -> Interpolation:
        """Return the interpolation of the points of several panels, one panel after the other."""
        from scipy.sparse import block_diag, csr_array

        return Interpolation(
            csr_array(block_diag([part.values for part in parts])),
            csr_array(block_diag([part.along for part in parts])),
            csr_array(block_diag([part.across for part in parts])),
            np.concatenate([part.offset_m for part in parts]),
        )

    def renumbered(self, numbers: Indices | list[int]) -> Interpolation:
        """Return the interpolation from surface points in another order: k is the old ``numbers[k]``."""
        values, along, across = (matrix[:, numbers] for matrix in (self.values, self.along, self.across))
        return Interpolation(values, along, across, self.offset_m)


def _among(points: int, numbers: Indices, rows: csr_array) -> csr_array:
    """Return a matrix of ``points`` rows: ``rows`` at ``numbers``, which ascend, and empty ones elsewhere."""
    from scipy.sparse import csr_array

    entries = np.zeros(points, dtype=np.int64)
    entries[numbers] = np.diff(rows.indptr)
    starts = np.concatenate([[0], np.cumsum(entries)])
    return csr_array((rows.data, rows.indices, starts), shape=(points, rows.shape[1]))
