"""Surface points that stand on nodes: the mapping has the node alone, to the last bit."""

from __future__ import annotations

import numpy as np
import pytest

from adapters.panel.common.grid import ElementGrid


def test_points_on_nodes_move_with_the_node_alone() -> None:
    """Rounding of their coordinates does not matter; a point between two nodes of a line has three."""
    grid = ElementGrid(np.linspace(0.0, 0.33, 8), np.linspace(0.0, 0.05, 4))
    nodes_m = grid.nodes_m()
    inside = (nodes_m > 0.0).all(axis=1) & (nodes_m < [0.33, 0.05]).all(axis=1)
    rounded_m = nodes_m[inside] * (1.0 + 3e-16)
    functions = grid.values(rounded_m)
    assert functions.nnz == len(rounded_m)
    assert np.all(functions.data == 1.0)
    assert np.array_equal(functions.indices, np.flatnonzero(inside))
    between = grid.values(np.array([[0.01, nodes_m[1, 1]]]))
    assert between.nnz == 3
    assert between.sum() == pytest.approx(1.0, abs=1e-15)
