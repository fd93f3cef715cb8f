"""Effects between particles: each deciding number against a value worked out by hand, and what
follows from it."""

from __future__ import annotations

import math
import re
from pathlib import Path

import pytest

from orchestrator.case.bed.contact_times import hertz_overlap_m
from orchestrator.cli.overview import rolling_lines
from orchestrator.preflight.check import warnings
from orchestrator.preflight.effects.opening_depth import is_deep, thin_rims
from orchestrator.preflight.scene.scene import scene
from tests.cases import BLOCK, CASE, FEED, load_case, loaded
from tests.effects.verdicts import (
    APERTURES,
    BARE,
    DEEP,
    STILL_CASE,
    TILTED,
    by_name,
    of_driven,
    set_contact,
    verdict,
)


def test_friction_against_the_slope(tmp_path: Path) -> None:
    """0.47 / tan 20 deg = 1.291."""
    judged = verdict(tmp_path, "sliding-friction", TILTED)
    assert judged.verdict.value == pytest.approx(0.47 / 0.363970, rel=1e-5)
    assert (judged.present, judged.verdict.matters) == (True, True)


@pytest.mark.parametrize("friction", [0.4, 0.09, 0.03])
@pytest.mark.parametrize("case", [STILL_CASE, CASE])
def test_rolling_friction_matters_on_a_slope(tmp_path: Path, friction: float, case: str) -> None:
    """The effect matters where a lone sphere does not stop, with or without a throw; and where it does."""
    row = set_contact(f"sliding_friction=0.47, rolling_friction={friction}")
    judged = by_name(load_case(tmp_path, case, [TILTED, row]))["rolling-friction"]
    assert judged.verdict.value == pytest.approx(friction / 0.363970, rel=1e-5)
    assert (judged.present, judged.verdict.matters, judged.is_spare) == (True, True, False)
    assert ("a lone sphere does not stop" in judged.verdict.why) == (friction < 0.363970)


@pytest.mark.parametrize(("slope", "matters"), [("screen.inclination_deg=0", False), (TILTED, True)])
def test_no_rolling_friction_is_lacking_on_a_slope_alone(tmp_path: Path, slope: str, matters: bool) -> None:
    judged = verdict(tmp_path, "rolling-friction", slope)
    assert (judged.verdict.value, judged.verdict.matters, judged.is_lacking) == (0.0, matters, matters)


def test_rolling_friction_left_out_by_its_law_is_lacking(tmp_path: Path) -> None:
    row = set_contact("sliding_friction=0.47, rolling_friction=0.09")
    given = [TILTED, row, "particles.rolling=none"]
    assert by_name(load_case(tmp_path, STILL_CASE, given))["rolling-friction"].is_lacking


def test_bond_number_by_hand(tmp_path: Path) -> None:
    """20 mm on the panel: 1.5 pi * 7.75 * 0.01 / (1430 * 4/3 pi * 1e-6 * 9.81) = 6.215 weights;
    nothing shakes."""
    row = set_contact("sliding_friction=0.47, rolling_friction=0, work_of_adhesion_J_per_m2=7.75")
    judged = by_name(load_case(tmp_path, STILL_CASE, [row]))["adhesion"]
    assert judged.verdict.value == pytest.approx(6.215, rel=1e-3)
    assert (judged.present, judged.verdict.matters) == (True, True)


def test_adhesion_is_measured_against_the_throw(tmp_path: Path) -> None:
    """The driven panel's middle is thrown with 80^2 * 11.03 mm / g = 7.19."""
    row = set_contact("sliding_friction=0.47, rolling_friction=0, work_of_adhesion_J_per_m2=7.75")
    sag_m = 2 / math.pi * math.sqrt(0.3e-3)
    judged = of_driven(tmp_path, "adhesion", row)
    assert judged.verdict.value == pytest.approx(6.215 / (1 + 6400 * sag_m / 9.81), rel=1e-3)
    assert of_driven(tmp_path, "adhesion", row, "particles.adhesion=none").is_lacking


def test_dry_material_needs_no_adhesion(tmp_path: Path) -> None:
    judged = verdict(tmp_path, "adhesion")
    assert (judged.present, judged.verdict.matters, judged.verdict.value) == (False, False, 0.0)


def test_coarse_particles_do_not_change_the_bond_number(tmp_path: Path) -> None:
    row = set_contact("sliding_friction=0.47, rolling_friction=0, work_of_adhesion_J_per_m2=7.75")
    given = [FEED, row]
    fine = by_name(load_case(tmp_path, BARE, given))
    coarse = by_name(load_case(tmp_path, BARE, [*given, "particles.coarse_graining=2"]))
    bond = fine["adhesion"].verdict.value
    assert coarse["adhesion"].verdict.value == pytest.approx(bond, rel=1e-9)
    assert "single-particles" not in fine
    assert not coarse["single-particles"].present


def test_layers_of_coarse_particles_by_hand(tmp_path: Path) -> None:
    """0.1 kg of feed on 0.0604 m2 is 1.656 kg/m2, less than one layer of 40 mm (29.95 kg/m2),
    as which it counts: one layer."""
    given = [FEED, "particles.coarse_graining=2"]
    judged = by_name(load_case(tmp_path, BARE, given))["single-particles"]
    assert judged.verdict.value == pytest.approx(1.0, rel=1e-9)
    assert judged.is_lacking
    long = by_name(load_case(tmp_path, BARE, [*given, "duration_s=20"]))
    assert long["single-particles"].verdict.value == pytest.approx(20 / 0.0604 / 29.95, rel=1e-3)
    assert long["single-particles"].verdict.matters is False


@pytest.mark.parametrize(
    ("modulus_Pa", "poisson", "density", "overlap_m"),
    [(48e9, 0.2, 2800.0, 274.11e-6), (20e9, 0.25, 2500.0, 368.30e-6)],
)
def test_overlap_of_two_spheres(modulus_Pa: float, poisson: float, density: float, overlap_m: float) -> None:
    """Chung and Ooi, Granular Matter 13, 2011, 643, test 1: r = 10 mm, 10 m/s each."""
    mass_kg = 4 / 3 * math.pi * 1e-6 * density / 2
    reduced_Pa = modulus_Pa / (2 * (1 - poisson**2))
    found_m = hertz_overlap_m(mass_kg, 0.005, reduced_Pa, 20.0)
    assert found_m == pytest.approx(overlap_m, rel=1e-4)


def test_overlap_with_the_duration_of_the_contact() -> None:
    """Duration 2.87 (m^2 / (R E*^2 v))^(1/5) = 2.943 overlap / v: Johnson 1985, section 11.4."""
    overlap_m = hertz_overlap_m(0.01, 0.02, 1e7, 1.5)
    scale = math.pow(0.01**2 * 1.5**4 / (0.02 * 1e7**2), 0.2)
    assert overlap_m == pytest.approx(0.9745 * scale, rel=1e-4)
    assert 2.9433 * overlap_m / scale == pytest.approx(2.87, rel=1e-3)


def test_overlap_over_radius_by_hand(tmp_path: Path) -> None:
    """Coal of 1e7 Pa on PU (21 MPa, nu 0.4983) at 80 * 11.03 mm = 0.88, so 1 m/s: 1 / E* =
    0.91 / 1e7 + 0.7517 / 20.96e6, 15/16 * 4/3 pi * 1430 / E* to the power 0.4 = 0.0568."""
    judged = of_driven(tmp_path, "contact-stiffness")
    reduced_Pa = 1 / (0.91 / 1e7 + (1 - 0.49825**2) / 20.963e6)
    on_panel = (15 / 16 * 4 / 3 * math.pi * 1430 / reduced_Pa) ** 0.4
    half = 1e7 / 1.82
    pair = (15 / 16 * 2 / 3 * math.pi * 1430 / math.sqrt(0.5) / half) ** 0.4
    assert judged.verdict.value == pytest.approx(max(on_panel, pair), rel=1e-3)
    assert (judged.present, judged.verdict.matters) == (True, False)


def test_softened_too_much(tmp_path: Path) -> None:
    """Overlaps go with E^-0.4: a hundredth of the stiffness, 6.3 times the overlap."""
    judged = of_driven(tmp_path, "contact-stiffness", "particles.largest_youngs_modulus_Pa=1e5")
    assert judged.verdict.value > 0.3
    assert judged.is_lacking


def test_stiffness_at_openings_is_the_mass_that_passes_by_overlap(tmp_path: Path) -> None:
    """Openings of 12 mm let pass what is finer than 12 mm and, by an overlap of e radii on both
    sides, than 12 (1 + e) mm: of sizes from 10 to 20 mm, by mass, (d^4 - 10^4) / (20^4 - 10^4)."""
    assert verdict(tmp_path, "stiffness-at-openings", APERTURES).verdict.value == 0.0
    given = (APERTURES, BLOCK)
    near = verdict(tmp_path, "stiffness-at-openings", *given)
    radii = verdict(tmp_path, "contact-stiffness", *given).verdict.value
    assert radii is not None
    more = (1 + radii) ** 4 * 12**4 - 12**4
    assert near.verdict.value == pytest.approx(more / (12**4 - 10**4), rel=1e-6)
    assert near.verdict.matters is None, "only those that strike it overlap so much"
    soft = verdict(tmp_path, "stiffness-at-openings", *given, "particles.largest_youngs_modulus_Pa=1e3")
    assert soft.verdict.matters is True, "they sink through by their weight"


@pytest.mark.parametrize(
    ("overrides", "ratio", "matters"),
    [
        ((), 1.0, None),
        ((BLOCK,), 2.0, None),
        ((BLOCK, "bed.particles.ball.sieve_size_m=0.14"), 14.0, True),
        ((BLOCK, APERTURES), 2.0, True),
    ],
)
def test_size_ratio(tmp_path: Path, overrides: tuple[str, ...], ratio: float, matters: bool | None) -> None:
    judged = verdict(tmp_path, "size-distribution", *overrides)
    assert judged.verdict.value == pytest.approx(ratio)
    assert judged.verdict.matters is matters


def test_wear_without_a_rate_is_unknown(tmp_path: Path) -> None:
    judged = verdict(tmp_path, "wear")
    assert judged.verdict.matters is None
    assert judged.verdict.value is None
    assert "no contact has specific wear" in judged.verdict.why


@pytest.mark.parametrize(("rate", "matters"), [(1e-11, True), (1e-14, False)])
def test_wear_by_hand(tmp_path: Path, rate: float, matters: bool) -> None:
    """One ball of 20 mm: pi/6 rho d of weight per area, on 4 mm of panel, 1000 hours at 0.34 m/s
    and 2/pi of the driven frame's 80 rad/s times 3 mm."""
    row = f"contacts.0.specific_wear_m3_per_N_m={rate}"
    judged = of_driven(tmp_path, "wear", row)
    pressure_Pa = math.pi / 6 * 1430.0 * 0.02 * 9.81
    way_m = (0.34 + 2 / math.pi * 80.0 * 0.003) * 3.6e6
    assert judged.verdict.value == pytest.approx(rate * pressure_Pa * way_m / 0.004, rel=1e-3)
    assert judged.verdict.matters is matters
    assert judged.present


def test_wear_left_out_by_its_law_is_lacking(tmp_path: Path) -> None:
    judged = of_driven(tmp_path, "wear", "contacts.0.specific_wear_m3_per_N_m=1e-11", "particles.wear=none")
    assert judged.is_lacking


@pytest.mark.parametrize(
    ("size_mm", "terminal_m_per_s", "matters"),
    [(0.5, 2.57, True), (1.0, 4.82, None), (2.0, 8.40, False), (20.0, 26.57, False)],
)
def test_air_drag_by_the_throw_over_the_terminal_speed(
    tmp_path: Path, size_mm: float, terminal_m_per_s: float, matters: bool | None
) -> None:
    """At 1 m/s.  20 mm fall by Newton's law with (4 rho g d / (3 * 0.44 * 1.204))^(1/2), the finer
    ones as the balance that tests/particles/test_air.py solves.  Lacking where it matters without any air."""
    assert math.sqrt(4 * 1430 * 9.81 * 0.02 / (3 * 0.44 * 1.204)) == pytest.approx(26.573, rel=1e-4)
    size = f"bed.particles.ball.sieve_size_m={size_mm / 1000}"
    judged = by_name(load_case(tmp_path, STILL_CASE, [size]))["air-drag"]
    assert judged.verdict.value == pytest.approx(1 / terminal_m_per_s, rel=2e-3)
    assert judged.verdict.matters is matters
    assert (judged.present, judged.is_lacking) == (False, matters is True)
    airy = by_name(load_case(tmp_path, STILL_CASE, [size, "air={}"]))["air-drag"]
    assert (airy.present, airy.is_lacking, airy.is_spare) == (True, False, matters is False)


def test_coarse_particles_do_not_change_the_drag_of_air(tmp_path: Path) -> None:
    fine = by_name(load_case(tmp_path, BARE, [FEED]))["air-drag"].verdict
    coarse = by_name(load_case(tmp_path, BARE, [FEED, "particles.coarse_graining=2"]))["air-drag"].verdict
    assert coarse.value == pytest.approx(fine.value, rel=1e-9)


def test_air_drag_left_out_by_its_law(tmp_path: Path) -> None:
    judged = verdict(tmp_path, "air-drag", "air={}", "particles.air_drag=none")
    assert not judged.present
    assert not judged.can_go


@pytest.mark.parametrize("friction", [0.09, 0.36, 0.37, 0.5])
def test_a_lone_sphere_below_the_tangent_of_the_slope_runs_ever_faster(
    tmp_path: Path, friction: float
) -> None:
    """tan 20 deg = 0.363970; a ball of 20 mm is one layer.  The run has spheres, whatever they stand for."""
    row = set_contact(f"sliding_friction=0.47, rolling_friction={friction}")
    case = load_case(tmp_path, STILL_CASE, [TILTED, row])
    judged = by_name(case)["grain-shape"]
    assert judged.verdict.value == pytest.approx(friction / 0.363970, rel=1e-5)
    assert judged.verdict.matters is (True if friction < 0.363970 else None)
    assert judged.is_lacking == (friction < 0.363970)
    assert not judged.present
    assert "particles are spheres" in case.left_out["grain-shape"]
    lines = [line for line in warnings(case) if "may never reach a steady speed" in line]
    assert len(lines) == (friction < 0.363970)
    assert all("give materials.coal a shape" in line for line in lines)


def test_spheres_on_the_level_and_in_a_thick_bed_hold_each_other(tmp_path: Path) -> None:
    """20 s of the feed are 33 kg/m2 of grains of 20 mm, and a layer is 15.0."""
    row = set_contact("sliding_friction=0.47, rolling_friction=0.09")
    level = by_name(load_case(tmp_path, STILL_CASE, [row]))["grain-shape"]
    assert (level.verdict.value, level.verdict.matters) == (None, None)
    given = [FEED, row, TILTED]
    for seconds, matters in ((1, True), (20, None)):
        bed = load_case(tmp_path, BARE, [*given, f"duration_s={seconds}"])
        assert by_name(bed)["grain-shape"].verdict.matters is matters
        assert any("may never reach a steady speed" in line for line in warnings(bed)) == bool(matters)


def test_no_shape_without_particles_or_a_deck(tmp_path: Path) -> None:
    bare = load_case(tmp_path, BARE, [TILTED])
    assert "grain-shape" not in by_name(bare)
    assert "grain-shape" not in bare.left_out


def test_spheres_without_their_law_of_rolling_run_ever_faster(tmp_path: Path) -> None:
    row = set_contact("sliding_friction=0.47, rolling_friction=0.5")
    given = [TILTED, row, "particles.rolling=none"]
    assert by_name(load_case(tmp_path, STILL_CASE, given))["grain-shape"].verdict.value == 0.0


def test_check_tells_shapes_and_rolling_frictions(tmp_path: Path) -> None:
    row = set_contact("sliding_friction=0.47, rolling_friction=0.09")
    (plain,) = rolling_lines(load_case(tmp_path, STILL_CASE, [row]).case)
    assert re.findall(r"([\d.]+) on (\w+)", plain) == [("0.09", "PU"), ("0", "coal")]
    shaped = next(rolling_lines(load_case(tmp_path, STILL_CASE, [row, "materials.coal.shape=angular"]).case))
    assert {"angular;", "0.09"} <= {*shaped.split()}


def test_opening_depth_by_the_mass_that_walls_can_clamp(tmp_path: Path) -> None:
    """A mat that is stretched by 2 % lets in, besides what overlaps let in, sizes up to 12.24 mm: of sizes
    from 10 to 20 mm, by mass, (d^4 - 12^4) / (12^4 - 10^4) over those that pass."""
    judged = verdict(tmp_path, "opening-depth", APERTURES, BLOCK)
    assert not judged.present
    radii = verdict(tmp_path, "contact-stiffness", APERTURES, BLOCK).verdict.value
    assert radii is not None
    strain = scene(loaded(tmp_path, [APERTURES, BLOCK]).case).panels[0].strain
    more = (1 + radii + strain) ** 4 * 12**4 - 12**4
    assert judged.verdict.value == pytest.approx(more / (12**4 - 10**4), rel=1e-6)
    deep = verdict(tmp_path, "opening-depth", DEEP, BLOCK)
    assert deep.present
    assert deep.can_go
    coarse = verdict(tmp_path, "opening-depth", DEEP)
    assert (coarse.verdict.value, coarse.verdict.matters) == (0.0, False)
    assert "opening-depth" not in by_name(load_case(tmp_path, STILL_CASE))


def test_opening_depth_is_left_out_by_thin_rims(tmp_path: Path) -> None:
    case = loaded(tmp_path, [DEEP, BLOCK]).case
    assert thin_rims(case)["screen"]["panels"]["deck"]["apertures"]["rims"] == "thin"
    without = load_case(tmp_path, CASE, [DEEP, BLOCK, "effects=[]"])
    assert not any(is_deep(row) for row in without.case.screen.panels.values())
