"""Parts that need no solver: the grid's shape functions, and what a missing solver says."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from adapters.panel.common.grid import ElementGrid
from tests.panel.elastic_plans import plan

GRID = ElementGrid.of(plan().rectangle, (7, 3))


def test_reproduces_biquadratic_fields():
    """Exact for polynomials up to s^2 y^2: rounding only."""
    rng = np.random.default_rng(3)
    points = rng.uniform([-0.02, 0.0], [0.35, 0.05], (200, 2))

    def field(at):
        s, y = at.T
        return 1 + s - 3 * y + 40 * s**2 * y - 7 * s**2 * y**2

    H = GRID.values(points)
    np.testing.assert_allclose(H @ field(GRID.nodes_m()), field(points), rtol=1e-13)
    np.testing.assert_allclose(H.sum(axis=1), 1.0, rtol=1e-14)


def test_nodes_are_found_by_their_coordinates():
    shuffled = np.random.default_rng(4).permutation(len(GRID.nodes_m()))
    points = GRID.nodes_m()[shuffled]
    np.testing.assert_array_equal(points[GRID.numbers_of(points)], GRID.nodes_m())


@pytest.mark.parametrize("point", [(0.36, 0.01), (-0.03, 0.01), (0.1, 0.06), (np.nan, 0.01)])
def test_refuses_points_outside(point):
    with pytest.raises(ValueError, match="outside"):
        GRID.values(np.array([point]))


def test_a_hinge_has_no_cells_under_the_clamp():
    hinged = ElementGrid.of(plan(clamp_m=0.0).rectangle, (7, 3))
    assert hinged.shape == (7, 3)
    assert GRID.shape == (9, 3)


@pytest.mark.parametrize("solver", ["sheet", "solid"])
def test_missing_package_says_what_to_install(solver):
    script = (
        "import sys; sys.modules['dolfinx'] = None\n"
        f"from adapters.panel import {solver}; {solver}.ADAPTER.load()"
    )
    failed = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, encoding="utf-8", check=False
    )
    assert failed.returncode == 1
    assert "SolverMissing: " in failed.stderr
    assert f"'{solver}'" in failed.stderr.splitlines()[-1]
    assert "need DOLFINx 0.5 or 0.9" in failed.stderr
