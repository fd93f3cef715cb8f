"""The grid on which the shape of a panel between its clamps is recorded.

The panel's points stand on a rectangular grid of rows (constant s) and columns (constant y) in
material coordinates.  Carried by its clamps alone, the panel would be flat: bilinear between the
eight corners of the two clamps' rectangles (four where they have no depth).  The *shape* is what
is left: actual place less carried place, in the panel's axes (along, across, normal) at t = 0.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchestrator.ports import Array
from orchestrator.ports.geometry import Rectangle


@dataclass(frozen=True)
class ShapeGrid:
    """A grid of ``rows_m`` (a,) and ``columns_m`` (b,), both increasing.

    It reaches from clamp's outer edge to clamp's outer edge and from side to side; points are numbered with y
    running fastest.
    """

    rows_m: Array
    columns_m: Array

    @staticmethod
    def of(rectangle: Rectangle, cells: tuple[int, int]) -> ShapeGrid:
        """Return the grid of ``cells`` equal cells along and across, and one row under each clamp."""
        free = np.linspace(0.0, rectangle.length_m, cells[0] + 1)
        under = [rectangle.clamp_m] if rectangle.clamp_m > 0 else []
        rows = [*(-c for c in under), *free, *(rectangle.length_m + c for c in under)]
        return ShapeGrid(np.array(rows), np.linspace(0.0, rectangle.width_m, cells[1] + 1))

    @property
    def points_m(self) -> Array:
        """The material coordinates (points, 2)."""
        s, y = np.meshgrid(self.rows_m, self.columns_m, indexing="ij")
        return np.column_stack([s.ravel(), y.ravel()])

    def carried(self, rectangle: Rectangle) -> Array:
        """Return the matrix N (points, corners) for which the clamps alone carry  points = N @ corners."""
        clamp_m, length_m = rectangle.clamp_m, rectangle.length_m
        edges_m = [-clamp_m, 0.0, length_m, length_m + clamp_m] if clamp_m > 0 else [0.0, length_m]
        s, y = self.points_m.T
        along, across = _hats(s, np.array(edges_m)), _hats(y, np.array([0.0, rectangle.width_m]))
        return np.asarray((along[:, :, None] * across[:, None, :]).reshape(len(s), -1))


def _hats(places: Array, nodes: Array) -> Array:
    """Return linear interpolation between increasing nodes as a matrix (places, nodes)."""
    return np.column_stack([np.interp(places, nodes, unit) for unit in np.eye(len(nodes))])
