"""Rectangular grids in material coordinates (s, y), and one of quadratic cells.

Its nodes stand at the corners, edge middles and centres of the cells and are numbered with y running
fastest; values between them follow the biquadratic Lagrange shape functions.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from orchestrator.ports import Array, Indices, Interpolation
from orchestrator.ports.geometry import Rectangle

if TYPE_CHECKING:
    from scipy.sparse import csr_array


ROUNDING = 1e-9  # of a cell
NODE_SLOPES = np.array([[-3.0, 4.0, -1.0], [-1.0, 0.0, 1.0], [1.0, -4.0, 3.0]])
"""The slopes of the quadratic shape functions (columns) at the nodes (rows) of a cell of length 1."""


def _with_middles(breaks_m: Array) -> Array:
    nodes = np.empty(2 * len(breaks_m) - 1)
    nodes[::2] = breaks_m
    nodes[1::2] = 0.5 * (breaks_m[:-1] + breaks_m[1:])
    return nodes


def _breaks_m(length_m: float, cells: int, margin_m: float) -> Array:
    """Return the borders of ``cells`` cells, two of them at ``margin_m`` from the ends if that is not near
    an end or the middle."""
    outside = round(cells * margin_m / length_m)
    if outside == 0 or 2 * outside >= cells:
        return np.linspace(0.0, length_m, cells + 1)
    at = [0, outside, cells - outside, cells]
    return np.interp(np.arange(cells + 1), at, [0.0, margin_m, length_m - margin_m, length_m])


def clamped_rows_m(rectangle: Rectangle, free_m: Array) -> Array:
    """Return the rows ``free_m`` of the free length, and one more under each clamp that has a depth."""
    under_m = np.array([rectangle.clamp_m] if rectangle.clamp_m > 0.0 else [])
    return np.concatenate([-under_m, free_m, rectangle.length_m + under_m])


def locate(breaks_m: Array, value_m: Array, slack_m: float) -> tuple[Indices, Array]:
    """Return the cell (n,) between increasing ``breaks_m`` that holds each value, and how far (n,) into it,
    0 ... 1, the value is; ValueError for values that are outside by more than ``slack_m``."""
    outside = (value_m < breaks_m[0] - slack_m) | (value_m > breaks_m[-1] + slack_m)
    if outside.any() or not np.isfinite(value_m).all():
        worst = value_m[outside | ~np.isfinite(value_m)][0]
        raise ValueError(
            f"material coordinate {worst} m lies outside the panel's {breaks_m[0]} ... {breaks_m[-1]} m"
        )
    cell = np.clip(np.searchsorted(breaks_m, value_m, side="right") - 1, 0, len(breaks_m) - 2)
    return cell, (value_m - breaks_m[cell]) / (breaks_m[cell + 1] - breaks_m[cell])


def tensor_product(
    row: Indices, along: Array, column: Indices, across: Array, size: tuple[int, int]
) -> csr_array:
    """Return shape functions (n, nodes) on a grid of ``size`` nodes along and across, y running fastest.

    ``along`` (n, a) are those of the nodes from ``row`` (n,) on, ``across`` (n, b) from ``column`` on.
    """
    from scipy.sparse import csr_array

    nodes = (row[:, None, None] + np.arange(along.shape[1])[:, None]) * size[1] + (
        column[:, None, None] + np.arange(across.shape[1])
    )
    values = along[:, :, None] * across[:, None, :]
    starts = np.arange(len(row) + 1) * along.shape[1] * across.shape[1]
    functions = csr_array((values.ravel(), nodes.ravel(), starts), shape=(len(row), size[0] * size[1]))
    functions.eliminate_zeros()  # of points that stand on nodes or on lines between them: often most
    return functions


def _quadratic(t: Array) -> Array:
    """Return the three shape functions (n, 3) at places 0 ... 1 in a cell; a place that is a node's but for
    rounding counts as the node's, so that the other two functions are zero there."""
    node = np.round(2.0 * t) / 2.0
    t = np.where(np.abs(t - node) < ROUNDING, node, t)
    return np.stack(((1 - t) * (1 - 2 * t), 4 * t * (1 - t), t * (2 * t - 1)), axis=1)


@dataclass(frozen=True)
class ElementGrid:
    """Cell borders along and across in m, both increasing."""

    s_m: Array
    y_m: Array

    @staticmethod
    def of(rectangle: Rectangle, cells: tuple[int, int], region_m: Array | None = None) -> ElementGrid:
        """Make ``cells`` cells along the free length and across, and one more column under each clamp (none
        where ``clamp_m`` is 0: such an edge is held at its points only, a hinge).

        They are equal, or, with the lowest and highest (s, y) of a region in the middle, (2, 2),
        equal inside and outside of it, unless its border is nearer than half a cell to the edge.
        """
        if min(cells) < 1:
            raise ValueError(f"a panel needs at least one cell along and across, got {cells}")
        margin_m = np.zeros(2) if region_m is None else region_m[0]
        free = _breaks_m(rectangle.length_m, cells[0], margin_m[0])
        return ElementGrid(
            clamped_rows_m(rectangle, free), _breaks_m(rectangle.width_m, cells[1], margin_m[1])
        )

    @property
    def shape(self) -> tuple[int, int]:
        """The numbers of cells along and across."""
        return len(self.s_m) - 1, len(self.y_m) - 1

    def nodes_m(self) -> Array:
        """Return the material coordinates (nodes, 2)."""
        s, y = np.meshgrid(_with_middles(self.s_m), _with_middles(self.y_m), indexing="ij")
        return np.column_stack((s.ravel(), y.ravel()))

    def interpolation(self, coordinates_m: Array) -> Interpolation:
        """Return the interpolation at ``coordinates_m`` (n, 2), or (n, 3) with offsets.  Raises ValueError
        outside the grid."""
        return Interpolation.of(coordinates_m, self.values, self.slopes)

    def values(self, coordinates_m: Array) -> csr_array:
        """Return shape functions (n, nodes) at ``coordinates_m`` (n, 2); ValueError outside the grid."""
        slack_m = 1e-9 * (self.s_m[-1] - self.s_m[0])
        row, s = locate(self.s_m, coordinates_m[:, 0], slack_m)
        column, y = locate(self.y_m, coordinates_m[:, 1], slack_m)
        size = 2 * len(self.s_m) - 1, 2 * len(self.y_m) - 1
        return tensor_product(2 * row, _quadratic(s), 2 * column, _quadratic(y), size)

    def slopes(self, coordinates_m: Array) -> tuple[csr_array, csr_array]:
        """Return the slopes along and across (n, nodes) in 1/m at ``coordinates_m`` (n, 2).

        They are those at the nodes, and between them as other values, so that the normal has no jumps from
        cell to cell.
        """
        H = self.values(coordinates_m)
        along, across = nodal_slopes(self, np.ones(self.shape, dtype=np.bool_))
        return H @ along, H @ across

    def shares(self, coordinates_m: Array) -> csr_array:
        """Return the shares (n, nodes) of loads at ``coordinates_m`` (n, 2) that the nearest nodes take.

        Up to four nodes share a load bilinearly, so that no share is negative, as those of the quadratic
        shape functions would be.  Raises ValueError outside of the grid.
        """
        s_m, y_m = _with_middles(self.s_m), _with_middles(self.y_m)
        row, s = locate(s_m, coordinates_m[:, 0], 0.0)
        column, y = locate(y_m, coordinates_m[:, 1], 0.0)
        along, across = (np.stack((1 - into, into), axis=1) for into in (s, y))
        return tensor_product(row, along, column, across, (len(s_m), len(y_m)))

    def numbers_of(self, coordinates_m: Array) -> Indices:
        """Return for each node, (nodes,), the number of the point of ``coordinates_m`` (nodes, 2 or more)
        that stands there."""
        return numbers_at_nodes(self.values(coordinates_m[:, :2]))


def nodal_slopes(grid: ElementGrid, material: npt.NDArray[np.bool_]) -> tuple[csr_array, csr_array]:
    """Return the matrices (nodes, nodes) of the slopes along and across in 1/m at the nodes.

    A node has the mean of the slopes in its cells with ``material`` (cells along, cells across), and a node
    at the inner edge of a clamp that of the cell under the clamp, which is rigid.  Rows of nodes without such
    a cell are empty.
    """
    from scipy.sparse import csr_array

    cell = np.nonzero(material)
    last = np.array(grid.shape) - 1
    weight = np.ones((len(cell[0]), 3))  # of a cell at its first, middle and last nodes along
    if grid.s_m[0] < 0.0:
        weight[cell[0] == 1, 0] = weight[cell[0] == last[0] - 1, 2] = 0.0
    first = 2 * np.stack(cell, axis=1)
    i, j, other = np.mgrid[:3, :3, :3].reshape(3, -1)
    columns, nodes = 2 * grid.shape[1] + 1, np.prod(2 * np.array(grid.shape) + 1)

    def number(a: Indices, b: Indices) -> Indices:
        return (first[:, :1] + a) * columns + first[:, 1:] + b

    def means(other_node: Indices, derivative: Array, sizes_m: Array, weight: Array) -> csr_array:
        entry = derivative * weight / sizes_m[:, None]
        node = number(i, j)
        sums = csr_array((entry.ravel(), (node.ravel(), other_node.ravel())), shape=(nodes, nodes))
        weights = np.bincount(node.ravel(), weight.ravel() / 3, nodes)  # three entries of each cell
        return csr_array(sums.multiply(1.0 / np.where(weights > 0.0, weights, 1.0)[:, None]))

    along_m, across_m = np.diff(grid.s_m)[cell[0]], np.diff(grid.y_m)[cell[1]]
    along = means(number(other, j), NODE_SLOPES[i, other], along_m, weight[:, i])
    return along, means(number(i, other), NODE_SLOPES[j, other], across_m, np.ones((len(weight), 27)))


def numbers_at_nodes(interpolation: csr_array) -> Indices:
    """Return for each node, (nodes,), the row of ``interpolation`` (nodes, nodes) that is at it."""
    at = interpolation.tocoo()
    there = at.data > 0.5
    numbers = np.empty(interpolation.shape[1], dtype=np.int64)
    numbers[at.col[there]] = at.row[there]
    return numbers
