"""The sheet of a machine: its supports, its power, its deck, and what check and new say of it."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from orchestrator.case.tables.bed import SizeClass
from orchestrator.case.tables.quantities import GROUND
from orchestrator.cli.proposal.deck_size import deck_m2_of, needed_m2_of, with_enough_panels
from orchestrator.cli.proposal.propose import find_refusals
from orchestrator.cli.proposal.wishes import read_wishes
from orchestrator.preflight.check import given_rates_kg_per_s, warnings
from orchestrator.preflight.judge import load_judged
from orchestrator.preflight.scene.frame_motion import frame_motions, spatial_shakings
from orchestrator.preflight.scene.scene import scene
from orchestrator.preflight.sheet.feed_shares import shares_at
from orchestrator.preflight.sheet.sheet import bed_depth_m, duty_of, sheet, too_small_decks
from orchestrator.preflight.sheet.supports import power_W, support_forces
from tests.cases import keys_and_kinds, loaded

CASES = Path(__file__).parents[2] / "cases"
COAL = {"feed": "0-50 mm", "cut": "6 mm", "material": "coal", "throughput": "250 t/h", "width": "2.4 m"}


def test_supports_carry_the_weight_and_follow_their_own_ends() -> None:
    """Each end of a bushing moves by x + rotation x arm; the force is (k + i w c) times that."""
    moved = scene(load_judged(CASES / "ffs0827-empty").case)
    forces = {force.name: force for force in support_forces(moved)}
    weight_N = 9.81 * sum(body.mass_kg for body in moved.plan.bodies)
    weight_N += 9.81 * sum(spring.mass_kg for spring in moved.springs)
    assert sum(force.static_N for force in forces.values()) == pytest.approx(weight_N, rel=1e-3)
    ((shaking,), _) = spatial_shakings(moved)
    centres_m = {body.name: body.center_of_mass_m for body in moved.plan.bodies}
    for bushing in (row for row in moved.plan.bushings if GROUND in row.bodies):
        (name,) = set(bushing.bodies) - {GROUND}
        arm_m = bushing.position_m - centres_m[name]
        end_m = shaking.amplitude_m[name] + np.cross(shaking.angle_rad[name], arm_m)
        stiffness = bushing.stiffness_N_per_m + 1j * shaking.speed_rad_per_s * bushing.damping_N_s_per_m
        force_N = stiffness * (bushing.axes @ end_m)
        turns = np.exp(1j * np.linspace(0.0, 2 * np.pi, 20001))
        largest_N = np.linalg.norm((force_N[:, None] * turns).real, axis=0).max()
        assert forces[bushing.name].dynamic_N == pytest.approx(largest_N, rel=1e-6)


def test_power_is_what_the_dampers_take() -> None:
    """Half of w^2 c |x|^2 over all bushings, against half of the force times the velocity in phase."""
    moved = scene(load_judged(CASES / "ffs0827-empty").case)
    lost_W = 0.0
    for shaking in moved.shaken:
        for bushing in moved.plan.bushings:
            stretch_m = bushing.axes @ shaking.relative_m(bushing.bodies)
            lost_W += shaking.speed_rad_per_s**2 / 2 * bushing.damping_N_s_per_m @ np.abs(stretch_m) ** 2
    assert power_W(moved) == pytest.approx(lost_W, rel=1e-9)


def test_stroke_angle() -> None:
    """FFS0827: the driven frame moves along the deck, the driving one nearly normal to it."""
    moved = scene(load_judged(CASES / "ffs0827-empty").case)
    angles_deg = {motion.frame: motion.angle_deg for motion in frame_motions(moved)}
    assert abs(angles_deg["driven"] or 90.0) < 10.0
    assert abs(angles_deg["driving"] or 0.0) > 75.0


def test_shares_of_a_feed() -> None:
    """Mass spread evenly over the fourth power of the diameter, half of it in each class."""
    rows = [
        SizeClass(smallest_m=1e-3, largest_m=2e-3, mass_fraction=0.5),
        SizeClass(smallest_m=4e-3, largest_m=8e-3, mass_fraction=0.5),
    ]
    shares = shares_at(rows, 4e-3)
    assert (shares.oversize, shares.half_size) == pytest.approx((0.5, 0.5))
    assert shares.near_mesh == pytest.approx(0.5 * (5**4 - 4**4) / (8**4 - 4**4))


def test_bed_depth_is_that_of_the_handbook() -> None:
    """VSMA: depth in inches = short tons an hour x 20 / (5 x feet a minute x feet of width) at 100 lb/ft3."""
    ton, foot = 907.18474 / 3600, 0.3048
    bulk = 100 * 0.45359237 / foot**3
    found_m = bed_depth_m(45 * ton, 6 * foot, 75 * foot / 60, bulk)
    assert found_m == pytest.approx(45 * 20 / (5 * 75 * 6) * 0.0254, rel=1e-9)


def test_some_twenty_panels_for_raw_coal() -> None:
    wishes = with_enough_panels(read_wishes("flip-flow", COAL))
    needed_m2 = needed_m2_of(wishes)
    assert needed_m2 is not None
    assert wishes.opening_m == wishes.cut_m == 0.006
    assert 18 <= wishes.panels <= 25
    assert deck_m2_of(replace(wishes, panels=wishes.panels - 1)) < needed_m2 <= deck_m2_of(wishes)


def test_wishes_for_panels_or_a_length_are_kept() -> None:
    assert with_enough_panels(read_wishes("flip-flow", {**COAL, "panels": "12"})).panels == 12
    assert with_enough_panels(read_wishes("flip-flow", {**COAL, "length": "6 m"})).panels == 4
    assert with_enough_panels(read_wishes("flip-flow", {})).panels == 4
    assert with_enough_panels(read_wishes("banana", {})).panels == 6
    assert with_enough_panels(read_wishes("test-rig", {})).panels == 1


@pytest.mark.parametrize(
    ("answers", "area_m2", "options"),
    [
        ({"throughput": "400 t/h", "width": "0.9 m", "panels": "10"}, "2.7", {"--panels", "--width"}),
        ({"throughput": "200 t/h", "width": "1 m", "opening": "1 mm", "feed": "0-10 mm"}, "12", {"--width"}),
        ({**COAL, "length": "1.4 m"}, "3", {"--length", "--panels", "--width"}),
    ],
)
def test_a_deck_far_too_small_is_refused(answers: dict[str, str], area_m2: str, options: set[str]) -> None:
    (refusal,) = find_refusals("flip-flow", answers)
    assert (refusal.file, refusal.kind) == ("--throughput", "out-of-range")
    assert area_m2 in refusal.what.split()
    assert {*re.findall(r"--\w+", refusal.hint)} == options


def test_what_a_refusal_of_a_small_deck_offers_is_accepted() -> None:
    answers = {"throughput": "400 t/h", "width": "0.9 m", "panels": "10"}
    (refusal,) = find_refusals("flip-flow", answers)
    panels = str(refusal).split("take ")[1].split(" --panels")[0]
    assert find_refusals("flip-flow", {**answers, "panels": panels}) == []


def test_check_warns_of_a_small_deck_at_the_case_s_own_rate() -> None:
    """The deck of FFS0827 has a tenth of the area, also at its draft, which feeds less."""
    judged = load_judged(CASES / "ffs0827", "draft")
    rates = given_rates_kg_per_s(judged)
    duty = duty_of(judged.case.original, rates)
    assert duty is not None
    assert duty.fed_kg_per_s == pytest.approx(40.0)
    (warning,) = too_small_decks(duty)
    assert "the deck is too small: 144 t/h need" in warning
    assert warning in warnings(judged)
    lines = {line.name: line for line in sheet(scene(judged.case.original), rates)}
    assert lines["required area"].values["area_m2"] == pytest.approx(1.92)
    assert 1.8e-3 < lines["Karra's model"].values["d50_m"] < 2.0e-3
    assert all(line.source for line in lines.values())


def test_the_sheet_is_of_the_rate_that_set_gives() -> None:
    judged = load_judged(CASES / "ffs0827", "draft", ["bed.feeds.coal.rate_kg_per_s=20 t/h"])
    duty = duty_of(judged.case.original, given_rates_kg_per_s(judged))
    assert duty is not None
    assert duty.fed_kg_per_s == pytest.approx(20 / 3.6)


def test_the_bulk_of_two_feeds_fills_the_sum_of_their_volumes(tmp_path: Path) -> None:
    """1 kg/s of 1500 kg/m3 and 3 kg/s of 3000 kg/m3, of which a bed has 0.6: 4 kg in 1/900 + 3/1800 m3."""
    feed = (
        'bed.feeds.{0}={{material="{0}", rate_kg_per_s={1}, box_m=[[{2}, 0, 0.1], [{3}, 0.1, 0.2]], '
        "velocity_m_per_s=[0, 0, -1], sizes=[{{smallest_m=0.001, largest_m=0.02, mass_fraction=1}}]}}"
    )
    ore = "{density_kg_per_m3=3000, youngs_modulus_Pa=1e7, poisson_ratio=0.3}"
    sets = ["materials.coal.density_kg_per_m3=1500", f"materials.ore={ore}"]
    sets += [feed.format("coal", 1, 0.0, 0.1), feed.format("ore", 3, 0.1, 0.2)]
    openings = "{length_m=0.01, width_m=0.01, pitch_along_m=0.015, pitch_across_m=0.015}"
    duty = duty_of(loaded(tmp_path, [*sets, f"screen.panels.deck.apertures={openings}"]).case)
    assert duty is not None
    assert duty.bulk_kg_per_m3 == pytest.approx(4.0 / (1.0 / 900.0 + 3.0 / 1800.0))


def test_the_bed_at_the_discharge_has_what_did_not_pass() -> None:
    """85 % of what is finer than the openings has passed by then (the sheet's efficiency)."""
    lines = {line.name: line.values for line in sheet(scene(load_judged(CASES / "ffs0827").case.original))}
    undersize = 1.0 - lines["feed"]["oversize"]
    depth = lines["bed depth"]
    assert 0.1 < undersize < 1.0
    assert depth["discharge_m"] / depth["feed_m"] == pytest.approx(1.0 - 0.85 * undersize)


def test_bearings_of_an_exciter(tmp_path: Path) -> None:
    sets = ["screen.exciters.shaft.bearings={dynamic_rating_N=4e5, count=2}"]
    moved = scene(load_judged(CASES / "ffs0827-empty", None, sets).case)
    (line,) = (line for line in sheet(moved) if line.name == "bearings shaft")
    exciter = moved.case.screen.exciters["shaft"]
    load_N = exciter.mass_moment_kg_m * exciter.speed_rad_per_s**2 / 2
    per_h = exciter.speed_rad_per_s / (2 * math.pi) * 3600
    assert line.values["L10_h"] == pytest.approx(1e6 / per_h * (4e5 / load_N) ** (10 / 3))


@pytest.mark.parametrize(
    ("given", "kind"), [("stop_s=0.05", "stop_s: out-of-range"), ("run_down_s=2.0", "run_down_s: conflict")]
)
def test_a_stop_before_the_run_up_ends_is_refused(given: str, kind: str) -> None:
    from orchestrator.preflight.check import find_problems

    judged = load_judged(CASES / "ffs0827-empty", None, [f"screen.exciters.shaft.{given}"])
    assert f"screen.exciters.shaft.{kind}" in keys_and_kinds(find_problems(judged))
