"""A grid with rectangular holes: in a hole there are neither cells nor nodes.

What is seen in a hole lies on the straight line between its two longer sides.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from adapters.panel.finite_element.grid import Grid, numbers_at_nodes
from orchestrator.ports import Array, Indices

SIMPSON = (1 / 6, 2 / 3, 1 / 6)  # integrals of the shape functions over a cell of length 1
NOWHERE = np.full((1, 2, 2), np.nan)  # a hole that nothing is in, for cells with material


def snapped(breaks_m: Array, value_m: Array, slack_m: float) -> Array:
    """Values, those within ``slack_m`` of a cell border on it: shape functions are then exactly
    0 or 1."""
    after = np.clip(np.searchsorted(breaks_m, value_m), 1, len(breaks_m) - 1)
    low, high = breaks_m[after - 1], breaks_m[after]
    nearest = np.where(value_m - low < high - value_m, low, high)
    return np.where(np.abs(value_m - nearest) <= slack_m, nearest, value_m)


def _cell(breaks_m: Array, value_m: Array) -> Indices:
    after = np.searchsorted(breaks_m, value_m, side="right")
    return np.asarray(np.clip(after - 1, 0, len(breaks_m) - 2))


@dataclass(frozen=True)
class PiercedGrid:
    """``whole``, of which the holes are left out; lowest and highest (s, y) of each in m, on
    borders of cells: ``holes_m`` (holes, 2, 2)."""

    whole: Grid
    holes_m: Array

    def hole_of_cell(self) -> Indices:
        """(along, across): the hole that each cell is in, -1 where there is material."""
        found = np.full(self.whole.shape, -1, dtype=np.int64)
        middle = 0.5 * (self.whole.s_m[:-1] + self.whole.s_m[1:])
        rows = np.searchsorted(middle, self.holes_m[:, :, 0])
        middle = 0.5 * (self.whole.y_m[:-1] + self.whole.y_m[1:])
        columns = np.searchsorted(middle, self.holes_m[:, :, 1])
        for number, (row, column) in enumerate(zip(rows, columns, strict=True)):
            found[slice(*row), slice(*column)] = number
        return found

    def nodes_m(self) -> Array:
        """Material coordinates (nodes, 2)."""
        return self.whole.nodes_m()[self._there()]

    def node_areas_m2(self) -> Array:
        """(nodes,): the integral of each shape function, which is positive."""
        return self._areas_m2()[self._there()]

    def _there(self) -> Indices:
        """Which nodes of the whole grid belong to cells with material."""
        return np.flatnonzero(self._areas_m2())

    def _areas_m2(self) -> Array:
        """(nodes of the whole grid,): 0 where there is no material."""
        along, across = self.whole.shape
        cells_m2 = np.outer(np.diff(self.whole.s_m), np.diff(self.whole.y_m))
        cells_m2 *= self.hole_of_cell() < 0
        areas_m2 = np.zeros((2 * along + 1, 2 * across + 1))
        for i, one in enumerate(SIMPSON):
            for j, other in enumerate(SIMPSON):
                areas_m2[i : i + 2 * along : 2, j : j + 2 * across : 2] += one * other * cells_m2
        return areas_m2.ravel()

    def interpolation(self, coordinates_m: Array) -> csr_array:
        """Shape functions (n, nodes) at ``coordinates_m`` (n, 2), and in holes those of two places
        on their sides, by distance; ValueError outside the grid."""
        low_m, high_m, share = self._sides(coordinates_m)
        low = self.whole.interpolation(low_m).multiply(1.0 - share[:, None])
        high = self.whole.interpolation(high_m).multiply(share[:, None])
        return csr_array((low + high).tocsc()[:, self._there()])

    def _sides(self, coordinates_m: Array) -> tuple[Array, Array, Array]:
        """Two places (n, 2) on material for each point, and how far (n,) it is from the first to
        the second.  Both are its own unless it is in a hole."""
        breaks_m = (self.whole.s_m, self.whole.y_m)
        slack_m = 1e-9 * float(np.ptp(self.whole.s_m))
        at = [snapped(x, v, slack_m) for x, v in zip(breaks_m, coordinates_m.T, strict=True)]
        cell = tuple(_cell(x, v) for x, v in zip(breaks_m, at, strict=True))
        hole_m = np.concatenate([self.holes_m, NOWHERE])[self.hole_of_cell()[cell]]
        point, low, high = np.column_stack(at), hole_m[:, 0], hole_m[:, 1]
        inside = ((point > low) & (point < high)).all(axis=1)
        shorter = np.argmin(high - low, axis=1)
        across = inside[:, None] & (np.arange(2) == shorter[:, None])
        first, second = np.where(across, low, point), np.where(across, high, point)
        gap_m = np.where(inside, (second - first).sum(axis=1), 1.0)
        return first, second, (point - first).sum(axis=1) / gap_m

    def numbers_of(self, coordinates_m: Array) -> Indices:
        """As ``Grid.numbers_of``."""
        return numbers_at_nodes(self.interpolation(coordinates_m[:, :2]))
