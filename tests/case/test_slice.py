"""A slice: what is cut, what is shared, and what it refuses."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from orchestrator.case.deck.panels import walls
from orchestrator.case.file.slice import cut_triangles, share
from orchestrator.case.solver_plans import panel_plans, particles_plan
from orchestrator.preflight.check import warnings
from orchestrator.preflight.effects.full_width import left_out
from orchestrator.preflight.judge import load_judged
from tests.cases import BLOCK, FEED, kinds, loaded
from tests.runs.outside import ROOT

# the test case's deck is 0.2 m wide, from y = 0; its ball is at y = 0.1
SLICE = ("slice.width_m=0.1", "particles.solver=liggghts")
PERIODIC = 'slice={width_m=0.1, sides="periodic"}'
CHUTE = 'screen.surfaces.chute={{frame="driving", material="PU", corner_m={}, edges_m={}}}'


def test_extensive_quantities_take_their_share(tmp_path: Path) -> None:
    whole = loaded(tmp_path).case
    case = loaded(tmp_path, SLICE).case
    assert share(case.whole_machine) == pytest.approx(0.5)
    assert share(whole) == 1.0
    part, full = case.screen.frames["driving"], whole.screen.frames["driving"]
    assert part.mass_kg == pytest.approx(0.5 * full.mass_kg)
    np.testing.assert_allclose(part.inertia_kg_m2, 0.5 * np.array(full.inertia_kg_m2))
    spring, springs = case.screen.bushings["isolation"], whole.screen.bushings["isolation"]
    np.testing.assert_allclose(spring.stiffness_N_per_m, 0.5 * np.array(springs.stiffness_N_per_m))
    assert spring.positions_m == springs.positions_m
    assert case.screen.exciters["shaft"].mass_moment_kg_m == pytest.approx(0.175)
    panel = panel_plans(case)[0].rectangle
    assert panel.width_m == pytest.approx(0.1)
    np.testing.assert_allclose(panel.corner_m, [0.0, 0.05, 0.0])


def test_a_motor_and_bearings_take_their_share(tmp_path: Path) -> None:
    """Half of the width has half of the unbalance: the shaft then turns, and the bearings last, as long."""
    motor = (
        "rated_power_W=15e3, synchronous_speed_rad_per_s=80.0, rated_slip=0.03, moment_of_inertia_kg_m2=2.0, "
        "bearing_loss_N_m_s=0.6"
    )
    given = [f"screen.exciters.shaft.motor={{{motor}}}", "frames.solver=exudyn"]
    given += ["screen.exciters.shaft.bearings={dynamic_rating_N=4e5, count=4}"]
    shaft = loaded(tmp_path, [*SLICE, *given]).case.screen.exciters["shaft"]
    assert shaft.motor is not None
    assert shaft.motor.rated_power_W == pytest.approx(7500.0)
    assert shaft.motor.moment_of_inertia_kg_m2 == pytest.approx(1.0)
    assert shaft.motor.bearing_loss_N_m_s == pytest.approx(0.3)
    assert (shaft.motor.synchronous_speed_rad_per_s, shaft.motor.rated_slip) == (80.0, 0.03)
    assert shaft.bearings is not None
    assert (shaft.bearings.dynamic_rating_N, shaft.bearings.count) == (pytest.approx(2e5), 4)


def test_margins_of_openings_are_solid_in_a_slice(tmp_path: Path) -> None:
    """18 pitches of 9 mm between margins of 15 mm on 200 mm: 38 mm are solid, 19 % of any slice's width."""
    pattern = OPENINGS.replace("margin_along_m", "margin_across_m=0.015, margin_along_m")
    case = loaded(tmp_path, [*SLICE, pattern, "slice.width_m=0.09"]).case
    apertures = case.screen.panels["deck"].apertures
    assert apertures is not None
    assert apertures.margin_across_m == 0.0
    assert apertures.margin_share == pytest.approx(0.19)
    solid = pattern.replace("margin_along", "margin_share=0.1, margin_along")  # and a tenth of the rest
    case = loaded(tmp_path, [*SLICE, solid, "slice.width_m=0.09"]).case
    apertures = case.screen.panels["deck"].apertures
    assert apertures is not None
    assert apertures.margin_share == pytest.approx(1 - 0.9 * 0.81)


def test_the_bed_is_cut_and_shared(tmp_path: Path) -> None:
    block = BLOCK.replace("count=1", "count=10").replace("0.1, 0.1, 0.2", "0.1, 0.2, 0.2")
    case = loaded(tmp_path, [*SLICE, block, FEED]).case
    assert case.bed.blocks["coal"].count == 5
    assert case.bed.blocks["coal"].box_m == ((0.0, 0.05, 0.1), (0.1, pytest.approx(0.15), 0.2))
    assert case.bed.feeds["chute"].rate_kg_per_s == pytest.approx(0.5)
    assert case.bed.feeds["chute"].box_m[1][1] == pytest.approx(0.1)


def test_periodic_sides_are_the_domains(tmp_path: Path) -> None:
    case = loaded(tmp_path, SLICE).case
    nothing = np.empty((0, 3))
    from orchestrator.ports.geometry import TriangleSurface

    surface = TriangleSurface(nothing, nothing.astype(int), nothing[:, 0].astype(int))
    plan = particles_plan(case, surface)
    assert plan is not None
    assert plan.periodic_y
    np.testing.assert_allclose(plan.domain_m[:, 1], [0.05, 0.15])
    with_walls = loaded(tmp_path, ['slice={width_m=0.1, sides="walls"}']).case
    plan = particles_plan(with_walls, surface)
    assert plan is not None
    assert not plan.periodic_y
    np.testing.assert_allclose(plan.domain_m[:, 1], [-1.0, 1.0])


def test_the_panel_that_points_the_other_way(tmp_path: Path) -> None:
    turned = [
        "screen.panels.deck.across=[0, -1, 0]",
        "screen.panels.deck.along=[-1, 0, 0]",
        "screen.panels.deck.corner_m=[0.3, 0.2, 0]",
    ]
    panel = panel_plans(loaded(tmp_path, [*SLICE, *turned]).case)[0].rectangle
    np.testing.assert_allclose(panel.corner_m, [0.3, 0.15, 0.0])
    assert panel.width_m == pytest.approx(0.1)


def test_a_chute_is_cut_and_side_walls_are_left_out_or_moved_in(tmp_path: Path) -> None:
    sets = [
        CHUTE.format("[-0.5, -0.1, 0.5]", "[[0.2, 0, 0], [0, 0.4, 0]]"),
        CHUTE.replace("chute", "left").format("[0, -0.01, 0.1]", "[[0.2, 0, 0], [0, 0, 0.1]]"),
        CHUTE.replace("chute", "right").format("[0, 0.2, 0.1]", "[[0.2, 0, 0], [0, 0, 0.1]]"),
    ]
    case = loaded(tmp_path, [*SLICE, *sets]).case
    (chute,) = walls(case, tmp_path)
    np.testing.assert_allclose(np.ptp(chute.position_m, axis=0), [0.2, 0.1, 0.0], atol=1e-12)
    np.testing.assert_allclose(chute.position_m.min(axis=0), [-0.5, 0.05, 0.5])
    assert area_m2(chute.position_m[chute.triangles]) == pytest.approx(0.02)
    case = loaded(tmp_path, [*sets, 'slice={width_m=0.1, sides="walls"}']).case
    _, left, right = walls(case, tmp_path)
    np.testing.assert_allclose(left.position_m[:, 1], 0.04)
    np.testing.assert_allclose(right.position_m[:, 1], 0.15)
    assert len(walls(case.whole_machine, tmp_path)[0].triangles) == 2


def area_m2(corners_m: np.ndarray) -> float:
    a, b, c = corners_m.transpose(1, 0, 2)
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2.0)


def test_a_cut_keeps_area_orientation_and_neighbours() -> None:
    random = np.random.default_rng(3)
    position_m = random.uniform(-1.0, 1.0, (30, 3))
    triangles = np.array([[3 * k, 3 * k + 1, 3 * k + 2] for k in range(10)])
    parts = [
        cut_triangles(position_m, triangles, between, None)
        for between in ((-1.0, -0.3), (-0.3, 0.4), (0.4, 1.0))
    ]
    areas = [area_m2(place[numbers]) for place, numbers in parts]
    assert sum(areas) == pytest.approx(area_m2(position_m[triangles]), rel=1e-9)
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
    place, numbers = cut_triangles(square, np.array([[0, 1, 2], [0, 2, 3]]), (0.2, 0.7), None)
    a, b, c = place[numbers].transpose(1, 0, 2)
    assert (np.cross(b - a, c - a)[:, 2] > 0).all()
    assert len(place) == 6  # four corners, and where the diagonal leaves


def test_the_whole_case_is_what_is_written(tmp_path: Path) -> None:
    case = loaded(tmp_path, SLICE).case
    assert case.whole_machine.screen.panels["deck"].width_m == 0.2
    assert case.whole_machine.slice is not None


def test_a_level_says_that_it_leaves_out_width(tmp_path: Path) -> None:
    from tests.cases import CASE, case_folder

    narrow = 'without = ["full-width"]\n[slice]\nwidth_m = 0.1\n'
    judged = load_judged(case_folder(tmp_path, CASE, narrow=narrow), "narrow")
    assert judged.left_out.keys() == {"full-width", "grain-shape"}


OPENINGS = (
    "screen.panels.deck.apertures={length_m=0.006, width_m=0.006, pitch_along_m=0.009, pitch_across_m=0.009, "
    "margin_along_m=0.03}"
)


@pytest.mark.parametrize(
    ("overrides", "wanted"),
    [
        (["slice.width_m=0.3"], "slice.width_m: out-of-range"),
        (["slice.width_m=0.05"], "slice.width_m: out-of-range"),
        (["slice.width_m=0.054", OPENINGS], "slice.width_m: out-of-range"),
        (["slice.width_m=0.1", "particles.solver=spheres"], "slice.sides: solver"),
        (["slice.width_m=0.1", "gravity_m_per_s2=[0, 1, -9]"], "gravity_m_per_s2: conflict"),
        (
            ["slice.width_m=0.1", "bed.particles.ball.position_m.1=0.04"],
            "bed.particles.ball.position_m: misplaced",
        ),
        (
            ["slice.width_m=0.1", BLOCK.replace("0.1, 0.1, 0.2", "0.1, 0.03, 0.2")],
            "bed.blocks.coal.box_m: misplaced",
        ),
        (
            ["slice.width_m=0.1", "screen.panels.deck.across=[0, 0.6, 0.8]"],
            "screen.panels.deck.across: conflict",
        ),
        (
            [
                "slice.width_m=0.1",
                'screen.panels.low={material="PU", frames=["driving", "ground"], width_m=0.3, '
                "corner_m=[0, 0, -0.5], length_m=0.3, thickness_m=0.004, tension_m=0}",
            ],
            "screen.panels.low.width_m: conflict",
        ),
    ],
)
def test_a_slice_that_makes_no_sense_is_refused(tmp_path: Path, overrides: list[str], wanted: str) -> None:
    assert kinds(tmp_path, *overrides) == [wanted]


def test_a_slice_of_just_three_diameters_is_accepted(tmp_path: Path) -> None:
    """Three times 0.012 is more than 0.036 as a computer multiplies."""
    small = "bed.particles.ball.sieve_size_m=0.012"
    solver = "particles.solver=liggghts"
    assert kinds(tmp_path, small, solver, "slice.width_m=0.036") == []
    assert kinds(tmp_path, small, solver, "slice.width_m=0.0359") == ["slice.width_m: out-of-range"]


def test_a_narrow_slice_and_open_sides_are_warned_of(tmp_path: Path) -> None:
    keys = {}
    for given in ("{width_m=0.15}", "{width_m=0.08}", '{width_m=0.15, sides="walls"}'):
        lines = [line for line in warnings(loaded(tmp_path, [f"slice={given}"])) if line.startswith("slice.")]
        keys[given] = [line.split()[0] for line in lines]
        if keys[given] == ["slice.width_m"]:
            assert "4" in lines[0].split()  # diameters of 20 mm in 80 mm
    assert [*keys.values()] == [[], ["slice.width_m"], ["slice.sides"]]


def test_a_slice_with_more_openings_than_its_part_of_the_width_is_warned_of() -> None:
    """Margins of 30 mm on both sides of 800 mm: 740 mm have what 800 mm have in the slice."""
    case = load_judged(ROOT / "cases/ffs0827-slice", "draft")
    lines = [line for line in warnings(case) if "openings" in line]
    assert len(lines) == 1
    assert "8.1 % more openings" in lines[0]


@pytest.mark.parametrize(
    ("widths_over_lengths", "sets", "expected"),
    [
        (4, ["panel.solver=sheet"], "up to 8 % stiffer"),  # 4/3 over 1.236
        (4, ["panel.solver=sheet", 'slice={width_m=0.02, sides="walls"}'], "up to 19 % softer"),
        (4, ["panel.solver=strip"], ""),
        (1, ["panel.solver=sheet"], "up to 6 % softer"),  # its sides are free
        (0.1, ["panel.solver=sheet"], ""),
    ],
)
def test_what_a_slice_does_to_the_stiffness_of_sheets_is_told(
    tmp_path: Path, widths_over_lengths: float, sets: list[str], expected: str
) -> None:
    length_m = loaded(tmp_path).case.screen.panels["deck"].length_m
    width_m = widths_over_lengths * length_m
    wide = [
        f"screen.panels.deck.width_m={width_m}",
        f"bed.particles.ball.position_m=[0.15, {width_m / 2}, 0.1]",
    ]
    text = left_out(loaded(tmp_path, ["slice.width_m=0.02", *wide, *sets]).case)
    assert (expected in text) if expected else text.endswith("middle of the width")
