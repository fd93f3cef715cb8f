"""The solid's cells around openings: what needs no solver."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from adapters.panel.common.solid_grid import bearable_grid, size, solid_grid
from orchestrator.ports.geometry import AperturePattern
from tests.panel.elastic_plans import plan

SLOTS = AperturePattern("rectangle", 0.020, 0.003, 0.025, 0.006, 0.0, 0.030, 0.004)
STAGGERED = replace(SLOTS, stagger=0.4)


def given(pattern=SLOTS, cells=(10, 2)):
    return plan(length_m=0.3, width_m=0.04, cells=cells, apertures=pattern)


@pytest.mark.parametrize("pattern", [SLOTS, STAGGERED], ids=["rows", "staggered"])
def test_cells_cover_the_material_exactly(pattern):
    """Their area is the panel's less the openings', to rounding, and so is the nodes'."""
    chosen = given(pattern)
    grid, rectangle = solid_grid(chosen), chosen.rectangle
    whole_m2 = (rectangle.length_m + 2 * rectangle.clamp_m) * rectangle.width_m
    openings = len(pattern.centres_m(rectangle))
    wanted_m2 = whole_m2 - openings * pattern.opening_m2
    assert openings == {0.0: 45, 0.4: 41}[pattern.stagger]
    areas_m2 = np.outer(np.diff(grid.whole.s_m), np.diff(grid.whole.y_m))
    assert areas_m2[grid.hole_of_cell() < 0].sum() == pytest.approx(wanted_m2, rel=1e-12)
    assert grid.node_areas_m2().sum() == pytest.approx(wanted_m2, rel=1e-12)
    assert len(grid.node_areas_m2()) == len(grid.nodes_m())


@pytest.mark.parametrize("pattern", [SLOTS, STAGGERED], ids=["rows", "staggered"])
def test_cells_are_no_longer_than_asked_for_nor_than_half_a_land(pattern):
    grid = solid_grid(given(pattern))
    free = (grid.whole.s_m >= 0.0) & (grid.whole.s_m <= 0.3)
    assert np.diff(grid.whole.s_m[free]).max() <= 0.3 / 10 + 1e-12
    assert np.diff(grid.whole.y_m).max() <= 0.04 / 2 + 1e-12
    along_m = grid.whole.s_m[(grid.whole.s_m > 0.0575) & (grid.whole.s_m < 0.0625)]  # a land of 5 mm
    assert along_m == pytest.approx([0.06])
    across_m = grid.whole.y_m[(grid.whole.y_m > 0.0065) & (grid.whole.y_m < 0.0335)]
    limit_m = 0.0015 if pattern.stagger else 0.003  # lands of one row are openings of the next
    assert np.diff(across_m).max() <= limit_m + 1e-12


def test_finer_cells_where_the_plan_asks_for_them():
    coarse, fine = (solid_grid(given(cells=cells)) for cells in ((10, 2), (300, 80)))
    assert np.diff(coarse.whole.s_m).max() > 0.005
    assert np.diff(fine.whole.s_m[1:-1]).max() <= 0.001 + 1e-12
    assert np.diff(fine.whole.y_m).max() <= 0.0005 + 1e-12


@pytest.mark.parametrize("pattern", [SLOTS, STAGGERED], ids=["rows", "staggered"])
def test_values_on_material_and_across_openings(pattern):
    """The values on material are s^2 y^2 to rounding, on rims, too; in an opening they are linear between
    its rims."""
    chosen = given(pattern)
    grid = solid_grid(chosen)

    def field(at_m):
        s, y = 100 * at_m.T
        return 1 + s - 3 * y + 0.1 * s**2 * y - 0.7 * s**2 * y**2

    centres_m = pattern.centres_m(chosen.rectangle)
    rng = np.random.default_rng(1)
    somewhere_m = rng.uniform([-0.02, 0.0], [0.32, 0.04], (2000, 2))
    half_m = np.array([pattern.length_m, pattern.width_m]) / 2
    inside = (np.abs(somewhere_m[:, None] - centres_m) < half_m).all(axis=2).any(axis=1)
    rims_m = (centres_m[:, None] + half_m * np.array([[1, 1], [1, -0.3], [0.2, -1]])).reshape(-1, 2)
    material_m = np.vstack([somewhere_m[~inside], rims_m])
    nodal = field(grid.nodes_m())
    seen = grid.values(material_m)
    assert seen @ nodal == pytest.approx(field(material_m), rel=1e-11, abs=1e-11)
    assert inside.sum() > 300
    across = grid.values(somewhere_m[inside])
    assert across @ grid.nodes_m() == pytest.approx(somewhere_m[inside], abs=1e-15)
    rims = grid.values(np.array([[0, -0.0015], [0, 0.0015]]) + centres_m[0])
    middle = grid.values(centres_m[:1])
    assert middle @ nodal == pytest.approx((rims @ nodal).mean(), rel=1e-13)
    for H in (seen, across):
        assert H.sum(axis=1) == pytest.approx(np.ones(H.shape[0]), abs=1e-14)


def test_each_node_is_found_by_its_coordinates():
    grid = solid_grid(given())
    shuffled_m = np.random.default_rng(4).permutation(grid.nodes_m())
    assert (shuffled_m[grid.numbers_of(shuffled_m)] == grid.nodes_m()).all()


def test_openings_at_the_clamps_and_at_the_sides():
    """Half a land from either, without margins: as many cells as between openings."""
    pattern = AperturePattern("rectangle", 0.02, 0.004, 0.03, 0.008)
    grid = solid_grid(given(pattern))
    assert grid.whole.s_m[:4] == pytest.approx([-0.02, 0.0, 0.005, 0.025])
    assert grid.whole.y_m[:4] == pytest.approx([0.0, 0.002, 0.006, 0.008])


def test_size_before_the_mesh_is_made():
    """The lightest node is the middle of the rim's corners between two cells of 10 x 1.5 mm."""
    predicted, grid = size(given()), solid_grid(given())
    assert predicted.cells == (grid.hole_of_cell() < 0).sum()
    assert predicted.nodes == 3 * len(grid.nodes_m())
    lightest_kg = 2 / 3 * 1200 * 0.004 * grid.node_areas_m2().min()
    assert predicted.lightest_kg == pytest.approx(lightest_kg)


def test_round_ends_are_refused():
    with pytest.raises(ValueError, match='"rectangle"'):
        solid_grid(given(replace(SLOTS, shape="slot")))


def test_refused_when_no_machine_carries_the_mesh():
    """Cells of 0.3 x 0.07 mm: 171 GiB."""
    with pytest.raises(ValueError, match=r"\b171\b.*\b64\b"):
        bearable_grid(given(cells=(1000, 600)))
