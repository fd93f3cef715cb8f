"""The panel that has gone through a surface: found from where all is drawn and where it is now."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from orchestrator.case.deck.triangle_grid import grid
from orchestrator.ports import Array
from orchestrator.ports.geometry import Rectangle, RigidVertices, shares_in, tetrahedron_m
from orchestrator.ports.penetration import (
    Penetration,
    Penetrations,
    ProbedPanel,
    SurfaceBody,
    pairs_that_meet,
)

THICK_M = 0.004
FLAT = Rectangle(np.zeros(3), np.eye(3)[0], np.eye(3)[1], 0.3, 0.3, 0.2, 0.019)
CELLS = grid(FLAT, (12, 4))
DRAWN_M = FLAT.mounted(CELLS.coordinates_m)
FREE = np.flatnonzero((CELLS.coordinates_m[:, 0] > 0) & (CELLS.coordinates_m[:, 0] < 0.3))
LEVEL = ((0.05, 0.02), (0.2, 0.16))  # lowest corner and sides of a plate in the plane of x and y


def hanging_m(sag_m: float, drawn_m: Array = DRAWN_M) -> Array:
    """The panel with a sag that is a half sine along it."""
    along = np.clip(CELLS.coordinates_m[:, 0] / 0.3, 0.0, 1.0)
    return np.asarray(drawn_m - np.outer(sag_m * np.sin(np.pi * along), [0, 0, 1]))


def plate_m(height_m: float) -> Array:
    (x, y), (along_m, across_m) = LEVEL
    corners = np.array([[0, 0], [along_m, 0], [along_m, across_m], [0, across_m]])
    corners = corners + np.array([x, y])
    return np.column_stack([corners, np.full(4, height_m)])


def search(plate_drawn_m: Array, drawn_m: Array = DRAWN_M) -> Penetrations:
    plate = SurfaceBody("plate", np.array([[0, 1, 2], [0, 2, 3]]) + len(drawn_m))
    panel = ProbedPanel(0, np.column_stack([FREE, FREE]), THICK_M)
    all_drawn_m = np.vstack([drawn_m, plate_drawn_m])
    return Penetrations(all_drawn_m, [SurfaceBody("deck", CELLS.triangles), plate], [panel])


def deepest_in(
    now_m: Array, plate_now_m: Array, plate_drawn_m: Array | None = None, drawn_m: Array = DRAWN_M
) -> Penetration | None:
    drawn_plate_m = plate_now_m if plate_drawn_m is None else plate_drawn_m
    return search(drawn_plate_m, drawn_m).deepest(np.vstack([now_m, plate_now_m]))


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_panel_hangs_through_a_plate_as_deep_as_it_hangs_beyond_it(side: float) -> None:
    """39 mm of sag, 20 mm from the plate: 19 mm; from below as from above."""
    deepest = deepest_in(hanging_m(side * 0.039), plate_m(-side * 0.02))
    assert deepest is not None
    assert (deepest.panel, deepest.surface) == ("deck", "plate")
    assert deepest.depth_m == pytest.approx(0.019, rel=1e-12)
    assert deepest.thicknesses == pytest.approx(0.019 / THICK_M, rel=1e-12)


def test_a_plate_that_four_points_carry_is_gone_through_alike() -> None:
    """The plate sinks and turns; places to rounding."""
    plate_drawn_m = plate_m(-0.02)
    corners_m = tetrahedron_m(plate_drawn_m)
    share = shares_in(corners_m, plate_drawn_m)
    points, turn = len(DRAWN_M), Rotation.from_rotvec([0.02, 0.03, 0.0])
    plate = SurfaceBody("plate", np.array([[0, 1, 2], [0, 2, 3]]) + points + 4)
    panel = ProbedPanel(0, np.column_stack([FREE, FREE]), THICK_M)
    carried = Penetrations(
        np.vstack([DRAWN_M, corners_m]),
        [SurfaceBody("deck", CELLS.triangles), plate],
        [panel],
        RigidVertices(np.full(4, points), share),
    )
    plain = search(plate_drawn_m)
    for sag_m, up_m in ((0.0, 0.0), (0.039, 0.0), (0.039, 0.01), (0.005, -0.02)):
        deepest, expected = (
            looked.deepest(np.vstack([hanging_m(sag_m), turn.apply(points_m) + np.array([0, 0, up_m])]))
            for looked, points_m in ((carried, corners_m), (plain, plate_drawn_m))
        )
        assert (deepest is None) == (expected is None)
        if deepest is not None and expected is not None:
            assert deepest.depth_m == pytest.approx(expected.depth_m, rel=1e-9)
    assert carried.deepest(np.vstack([hanging_m(0.039), corners_m])) is not None


def test_it_is_found_however_large_or_small_the_plates_triangles() -> None:
    """A plate of 0.2 m in triangles of 10 mm; one of a kilometre."""
    for size_m, cells in ((0.2, 20), (1e3, 1)):
        wide = Rectangle(np.array([0.05, 0.02, -0.02]), *np.eye(3)[:2], size_m, size_m, size_m, 0.0)
        fine = grid(wide, (cells, cells))
        points_m = wide.mounted(fine.coordinates_m) - (size_m > 1) * np.array([500, 500, 0])
        bodies = [SurfaceBody("deck", CELLS.triangles), SurfaceBody("plate", fine.triangles + len(DRAWN_M))]
        panel = ProbedPanel(0, np.column_stack([FREE, FREE]), THICK_M)
        looked = Penetrations(np.vstack([DRAWN_M, points_m]), bodies, [panel])
        deepest = looked.deepest(np.vstack([hanging_m(0.039), points_m]))
        assert deepest is not None
        assert deepest.depth_m == pytest.approx(0.019, rel=1e-9)


def test_a_plate_above_beside_or_below_the_panel_is_not_gone_through() -> None:
    for height_m in (0.001, -0.04):
        assert deepest_in(hanging_m(0.039), plate_m(height_m)) is None
    assert deepest_in(hanging_m(0.039), plate_m(-0.02) + np.array([0.0, 0.3, 0.0])) is None


def test_what_moves_together_goes_through_nothing() -> None:
    """The whole machine turned by a right angle and carried off, the panel sagging by 10 mm."""
    turn, away_m = np.array([[0, 0, 1], [0, 1, 0], [-1, 0, 0]], float), np.array([3.0, 1.0, 2.0])
    now_m, plate_now_m = (m @ turn + away_m for m in (hanging_m(0.01), plate_m(-0.02)))
    assert deepest_in(now_m, plate_now_m, plate_m(-0.02)) is None
    deep = deepest_in(hanging_m(0.03) @ turn + away_m, plate_now_m, plate_m(-0.02))
    assert deep is not None
    assert deep.depth_m == pytest.approx(0.01, rel=1e-9)


def test_a_plate_that_comes_through_a_panel() -> None:
    """The plate is drawn 2 mm below the flat panel and goes 5 mm up."""
    deepest = deepest_in(DRAWN_M, plate_m(0.003), plate_m(-0.002))
    assert deepest is not None
    assert deepest.depth_m == pytest.approx(0.003, rel=1e-9)


@pytest.mark.parametrize("across_m", [0.0, 0.013, 0.2])
def test_a_side_plate_at_the_edge_or_through_the_panel_as_drawn_is_taken_as_meant(across_m: float) -> None:
    """The plate stands upright along the panel, which moves up and down along it."""
    upright = np.array([[-0.1, 0, -0.1], [0.4, 0, -0.1], [0.4, 0, 0.1], [-0.1, 0, 0.1]])
    for sag_m in (0.05, -0.05):
        assert deepest_in(hanging_m(sag_m), upright + np.array([0.0, across_m, 0.0])) is None


@pytest.mark.parametrize("above_m", [0.0, -1e-6])
def test_a_plate_in_the_panels_plane_has_no_side(above_m: float) -> None:
    assert deepest_in(hanging_m(0.01), plate_m(above_m)) is None


def test_a_triangle_that_turns_far_aside_of_a_point_is_not_gone_through() -> None:
    """The point stays at y = 2 and the triangle below -1; only the triangle's own sight leads through it."""
    drawn_m = np.array([[-1, 2, -1], [-1, -1, 2], [-2, -1, 2], [0, -2, -2]], dtype=float)
    now_m = np.array([[2, 2, 1], [-1, -2, 1], [2, -1, -2], [-1, -1, -1]], dtype=float)
    bodies = [
        SurfaceBody("deck", np.empty((0, 3), dtype=np.int64)),
        SurfaceBody("plate", np.array([[1, 2, 3]])),
    ]
    looked = Penetrations(drawn_m, bodies, [ProbedPanel(0, np.array([[0, 0]]), 4.0)])  # nothing is too far
    assert looked.deepest(now_m) is None


def test_a_list_has_what_may_meet_before_it_is_made_anew() -> None:
    """Panel and plate, 7 mm apart as drawn, both move by 3.9 mm: by less than the skin of a thickness."""
    lasting = search(plate_m(-0.007))
    assert lasting.deepest(np.vstack([DRAWN_M, plate_m(-0.007)])) is None
    listed = lasting._pairs
    through = lasting.deepest(np.vstack([hanging_m(0.0039), plate_m(-0.0031)]))
    assert lasting._pairs is listed
    assert through is not None
    assert through.depth_m == pytest.approx(0.0008, abs=1e-9)


def test_one_panel_through_another() -> None:
    """Two decks 30 mm apart: the upper one sags by 40 mm, the lower one by 5 mm; then the lower
    one is thrown up by 35 mm."""
    lower_m, points = DRAWN_M - (0, 0, 0.03), len(DRAWN_M)
    bodies = [SurfaceBody("upper", CELLS.triangles), SurfaceBody("lower", CELLS.triangles + points)]
    pairs = np.column_stack([FREE, FREE])
    panels = [ProbedPanel(0, pairs, THICK_M), ProbedPanel(1, pairs + points, THICK_M)]
    looked = Penetrations(np.vstack([DRAWN_M, lower_m]), bodies, panels)
    for upper_sag_m, lower_sag_m, depth_m in ((0.04, 0.005, 0.005), (0.0, -0.035, 0.005)):
        now_m = np.vstack([hanging_m(upper_sag_m), hanging_m(lower_sag_m, lower_m)])
        deepest = looked.deepest(now_m)
        assert deepest is not None
        assert {deepest.panel, deepest.surface} == {"upper", "lower"}
        assert deepest.depth_m == pytest.approx(depth_m, rel=0.05)
    assert looked.deepest(np.vstack([hanging_m(0.03), hanging_m(0.03, lower_m)])) is None


def test_a_search_finds_what_a_new_one_finds_whatever_it_has_seen_before() -> None:
    """A panel and a plate below it that sink, rise and drift, in steps within the skin of a list and beyond
    it; the second place is the one of a list, from which the panel goes through the plate at once."""
    lasting, lists, depths = search(plate_m(-0.02)), [], []
    for sag_m, up_m, aside_m in (
        *((0.0, 0.0, 0.0), (0.015, 0.0, 0.0), (0.039, 0.0, 0.0), (0.03, 0.002, 0.01), (0.025, 0.01, 0.03)),
        *((0.03, -0.015, 0.0), (-0.02, 0.0, 0.0), (0.3, 0.0, 0.1), (0.019, 0.0, 0.0), (0.021, 0.0, 0.0)),
    ):
        now_m = np.vstack([hanging_m(sag_m), plate_m(-0.02 + up_m) + np.array([aside_m, 0, 0])])
        before = getattr(lasting, "_pairs", None)
        through = lasting.deepest(now_m)
        assert through == search(plate_m(-0.02)).deepest(now_m)
        lists.append(lasting._pairs is not before)
        depths.append(through.depth_m if through else 0.0)
    assert lists[:3] == [True, True, False]
    assert lists[-3:] == [True, True, True]  # after the throw no list lasts
    assert np.array(depths) == pytest.approx([0, 0, 0.019, 0.012, 0.015, 0, 0, 0.28, 0, 0.001], abs=1e-9)


@pytest.mark.parametrize(("points", "boxes"), [(40, 30), (1, 1), (7, 0)])
def test_pairs_that_meet_are_those_of_all_pairs_that_no_side_parts_twice(points: int, boxes: int) -> None:
    """The reference is the comparison of each with each; some points and boxes share coordinates."""
    random = np.random.default_rng(4)
    points_m = random.integers(0, 12, (2, points, 3)).astype(float)
    corners_m = random.integers(0, 12, (2, boxes, 1, 3)) + random.integers(0, 4, (2, boxes, 2, 3))
    boxes_m = np.sort(corners_m.astype(float), axis=2)
    at_m, low_m, high_m = points_m[:, :, None], boxes_m[:, None, :, 0], boxes_m[:, None, :, 1]
    parted = ((at_m < low_m).all(axis=0) | (at_m > high_m).all(axis=0)).any(axis=-1)
    row, column = pairs_that_meet(points_m, boxes_m)
    assert [row.tolist(), column.tolist()] == [part.tolist() for part in np.nonzero(~parted)]
