"""Adhesion in the case: checks, softening, the mapping of sjkr, the step, Bond numbers."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from orchestrator.case.bed.adhesion import (
    PullOff,
    adhesive_step_s,
    planned_adhesion,
    pull_offs,
    sticky_contacts,
)
from orchestrator.case.bed.contact_times import contact_moduli, reduced_modulus_Pa, shortest_rayleigh_s
from orchestrator.case.bed.grains import material_numbers
from orchestrator.case.bed.size_distribution import median_size_m, size_class
from orchestrator.case.file.errors import CaseError
from orchestrator.case.solver_plans import particle_step_s
from orchestrator.case.tables.case import Case
from orchestrator.cli.overview import overview
from orchestrator.output.records.run_folder import resolved_case
from orchestrator.ports.plans import Jkr, Sjkr
from orchestrator.preflight.check import warnings
from orchestrator.preflight.effects.adhesion import EFFECT
from orchestrator.preflight.judge import load_judged
from orchestrator.preflight.judgement.catalogue import find_left_out
from orchestrator.preflight.scene.scene import scene
from tests.cases import (
    BLOCK,
    CASE,
    case_folder,
    complaints,
    keys_and_kinds,
    kinds,
    load_case,
    loaded,
    only_complaint,
)

WET = ("contacts.0.work_of_adhesion_J_per_m2=0.1", "contacts.1.work_of_adhesion_J_per_m2=0.2")


def case(folder: Path, *overrides: str) -> Case:
    return loaded(folder, overrides).case


def adhesion(folder: Path, *overrides: str) -> Jkr | Sjkr | None:
    given = case(folder, *overrides)
    return planned_adhesion(given, material_numbers(given))


def test_without_work_nothing_is_planned(tmp_path: Path) -> None:
    assert adhesion(tmp_path) is None
    assert adhesion(tmp_path, *WET, 'particles.adhesion="none"') is None
    assert "adhesion" in find_left_out(case(tmp_path, *WET, 'particles.adhesion="none"'))
    assert "adhesion" not in find_left_out(case(tmp_path, *WET))


def test_works_by_pair_of_materials_and_the_widest_stretch(tmp_path: Path) -> None:
    """Materials are PU, coal; the stretch is the gap at separation of the coal on PU or on coal,
    3/4 (pi^2 w^2 R / E*^2)^(1/3), as a share of the particle's radius, 10 mm."""
    plan = adhesion(tmp_path, *WET)
    assert isinstance(plan, Jkr)
    np.testing.assert_allclose(plan.work_J_per_m2, [[0.0, 0.1], [0.1, 0.2]], rtol=1e-12)
    given = case(tmp_path, *WET)
    first, second = (contact_moduli(given.materials[name], None) for name in ("PU", "coal"))
    gaps_m = [
        0.75 * (math.pi**2 * w**2 * radius_m / e_star_Pa**2) ** (1 / 3)
        for w, radius_m, e_star_Pa in (
            (0.1, 0.010, reduced_modulus_Pa(first, second)),
            (0.2, 0.005, reduced_modulus_Pa(second, second)),
        )
    ]
    assert plan.largest_stretch == pytest.approx(max(gaps_m) / 0.010, rel=1e-6)


@pytest.mark.parametrize("rule", ["sticking", "pull-off"])
def test_softening(tmp_path: Path, rule: str) -> None:
    """Softening keeps w^5 / E*^2, hence the sticking speed, or w, hence the pull-off force."""
    hard = (*WET, "materials.coal.youngs_modulus_Pa=1e9", f"particles.softened_adhesion={rule}")
    soft = (*hard, "particles.largest_youngs_modulus_Pa=1e7")
    for before, after in zip(
        sticky_contacts(case(tmp_path, *hard)), sticky_contacts(case(tmp_path, *soft)), strict=True
    ):
        assert after.reduced_Pa < before.reduced_Pa
        if rule == "sticking":
            kept = after.work_J_per_m2**5 / after.reduced_Pa**2
            assert kept == pytest.approx(before.work_J_per_m2**5 / before.reduced_Pa**2)
        else:
            assert after.pull_off_N == pytest.approx(before.pull_off_N)


SOFT = ("materials.coal.youngs_modulus_Pa=5e7", "particles.largest_youngs_modulus_Pa=1e6")


def test_a_case_by_bond_number_or_moisture_keeps_the_pull_off_force(tmp_path: Path) -> None:
    """Bond 3 of two grains of 20 mm is 3 weights in contacts of 5e7 and of 1e6 Pa.  In J/m2, or where the
    case says so, the sticking speed is kept: 3 (1/50)^0.4 = 0.627 weights, which is warned of."""
    pair = "contacts.1.bond_number=3"
    (kept,) = pull_offs(case(tmp_path, pair, *SOFT))
    assert (kept.asked, kept.run) == pytest.approx((3.0, 3.0))
    assert loaded(tmp_path, [pair, *SOFT]).case.particles.softened_adhesion == "pull-off"
    work_J_per_m2 = case(tmp_path, pair).contacts[1].work_of_adhesion_J_per_m2
    by_work = f"contacts.1.work_of_adhesion_J_per_m2={work_J_per_m2!r}"
    for given in ((by_work,), (pair, "particles.softened_adhesion=sticking")):
        (pull_off,) = pull_offs(case(tmp_path, *given, *SOFT))
        assert pull_off.asked == pytest.approx(3.0)
        assert pull_off.run == pytest.approx(3.0 * 0.02**0.4)
        (warning,) = [
            line for line in warnings(loaded(tmp_path, [*given, *SOFT])) if "pull-off force" in line
        ]
        assert "0.627 times the weight of a grain of 20 mm, 3 asked for" in warning
        assert any(pull_off.in_words in line for line in overview(loaded(tmp_path, [*given, *SOFT])))
        verdict = EFFECT.judge(scene(case(tmp_path, *given, *SOFT)))
        assert "the pull-off force is 0.627 weights" in verdict.why
    assert not [line for line in warnings(loaded(tmp_path, [pair, *SOFT])) if "pull-off force" in line]


def test_a_pull_off_force_counts_for_real_grains_and_by_the_law_of_the_run(tmp_path: Path) -> None:
    """A block of 4 to 16 mm: sjkr pulls right at the geometric mean, and half as strong at 4 mm."""
    block = (
        'bed.blocks.coal={material="coal", box_m=[[0.05, 0.05, 0.05], [0.25, 0.15, 0.3]], count=40, sizes='
    )
    block += "[{smallest_m=0.004, largest_m=0.016, mass_fraction=1.0}]}"
    text = CASE[: CASE.index("[bed.particles.ball]")] + CASE[CASE.index("[probes.middle]") :]

    def pull_off(*overrides: str) -> PullOff:
        bond = ("contacts.1.bond_number=3", "contacts.1.bond_diameter_m=0.004")
        (pair,) = pull_offs(load_case(tmp_path, text, (block, *bond, *overrides)).case)
        return pair

    for real in (pull_off(), pull_off("particles.coarse_graining=1.5")):
        assert (real.size_m, real.asked, real.run) == pytest.approx((0.004, 3.0, 3.0))
    cheap = pull_off('particles.adhesion="sjkr"')
    assert (cheap.asked, cheap.run) == pytest.approx((3.0, 1.5))


def test_sjkr_pulls_as_jkr_at_its_diameter(tmp_path: Path) -> None:
    """Numbers of coal, d = 3 mm, w = 12.86 (pair) and 7.75 J/m2 (on PU), E = 9.9e8 Pa:
    1.05e7 and 9.6e5 J/m3, of Hertz less 2 pi k R* overlap with its least force at -1.5 pi w R*
    found numerically."""
    plan = adhesion(
        tmp_path,
        "contacts.0.work_of_adhesion_J_per_m2=7.75",
        "contacts.1.work_of_adhesion_J_per_m2=12.86",
        "materials.coal.youngs_modulus_Pa=9.9e8",
        'particles.adhesion="sjkr"',
        "particles.sjkr_diameter_m=0.003",
    )
    assert isinstance(plan, Sjkr)
    assert plan.energy_density_J_per_m3[1, 1] == pytest.approx(1.05e7, rel=5e-3)
    assert plan.energy_density_J_per_m3[0, 1] == pytest.approx(9.6e5, rel=5e-3)
    e_star_Pa, radius_m = 9.9e8 / 2 / (1 - 0.3**2), 0.75e-3
    overlap_m = np.linspace(0.0, 0.02 * radius_m, 1_000_000)
    force_N = 4 / 3 * e_star_Pa * np.sqrt(radius_m) * overlap_m**1.5
    force_N -= 2 * math.pi * plan.energy_density_J_per_m3[1, 1] * radius_m * overlap_m
    assert force_N.min() == pytest.approx(-1.5 * math.pi * 12.86 * radius_m, rel=1e-6)


def test_the_step_resolves_sticky_contacts(tmp_path: Path) -> None:
    """The half period on the neck from the numerical slope of the curve at zero force."""
    (on_panel, pair) = sticky_contacts(case(tmp_path, *WET))
    neck_m = np.array([1.0 - 1e-6, 1.0 + 1e-6]) * pair.neck_m
    pulled_m = np.sqrt(2 * math.pi * pair.work_J_per_m2 * neck_m / pair.reduced_Pa)
    force_N = 4 / 3 * pair.reduced_Pa * neck_m**3 / pair.reduced_m
    force_N -= 2 * pair.reduced_Pa * neck_m * pulled_m
    slope_N_per_m = np.ptp(force_N) / np.ptp(neck_m**2 / pair.reduced_m - pulled_m)
    expected_s = math.pi * math.sqrt(pair.reduced_kg / slope_N_per_m)
    assert pair.half_period_s == pytest.approx(expected_s, rel=1e-5)
    limit_s = adhesive_step_s(case(tmp_path, *WET))
    assert limit_s <= min(pair.half_period_s, on_panel.half_period_s) / 20
    assert particle_step_s(case(tmp_path, *WET)) <= limit_s
    assert adhesive_step_s(case(tmp_path)) == math.inf


def test_a_step_too_long_for_sticky_contacts(tmp_path: Path) -> None:
    given = case(tmp_path, *WET)
    step_s = 0.19 * shortest_rayleigh_s(given)
    assert step_s > adhesive_step_s(given)
    step = f"particles.step_s={step_s}"
    assert kinds(tmp_path, *WET, step) == ["particles.step_s: out-of-range"]
    assert not complaints(tmp_path, step)
    assert not complaints(tmp_path, *WET)


def test_adhesion_asked_for_without_work(tmp_path: Path) -> None:
    assert kinds(tmp_path, 'particles.adhesion="jkr"') == ["particles.adhesion: conflict"]
    assert not complaints(tmp_path)


def test_negative_and_absurd_works(tmp_path: Path) -> None:
    assert "contacts.0.work_of_adhesion_J_per_m2" in only_complaint(
        tmp_path, "contacts.0.work_of_adhesion_J_per_m2=-1"
    )
    complaint = only_complaint(tmp_path, "contacts.0.work_of_adhesion_J_per_m2=7750")
    assert "looks like mJ/m2" in complaint


def test_a_neck_wider_than_half_the_radius(tmp_path: Path) -> None:
    fine = ("bed.particles.ball.sieve_size_m=0.0002", "contacts.1.work_of_adhesion_J_per_m2=40")
    assert kinds(tmp_path, *fine) == ["contacts.1.work_of_adhesion_J_per_m2: out-of-range"]


def test_a_pull_of_a_million_weights(tmp_path: Path) -> None:
    dust = (
        "bed.particles.ball.sieve_size_m=0.00002",
        "contacts.1.work_of_adhesion_J_per_m2=12",
        "materials.coal.youngs_modulus_Pa=1e11",
        "coupling.sync_interval_s=1e-6",
    )
    assert kinds(tmp_path, *dust) == ["contacts.1.work_of_adhesion_J_per_m2: out-of-range"]


def test_sjkr_wants_a_material_of_its_own_for_surfaces(tmp_path: Path) -> None:
    same = ('bed.particles.ball.material="PU"', *WET, 'particles.adhesion="sjkr"')
    pu = 'contacts.1.between=["PU", "PU"]'
    assert any("cannot tell them apart" in complaint for complaint in complaints(tmp_path, *same, pu))
    key = "particles.sjkr_diameter_m=0.003"
    assert kinds(tmp_path, *WET, key) == ["particles.sjkr_diameter_m: conflict"]


BOND_COAL, BOND_ON_PU = "contacts.1.bond_number=5", "contacts.0.bond_number=5"
G_M_PER_S2 = 9.80665


def works(folder: Path, *overrides: str) -> tuple[float, float]:
    """The works of adhesion of coal on polyurethane and of coal on coal."""
    on_panel, pair = case(folder, *overrides).contacts
    return on_panel.work_of_adhesion_J_per_m2, pair.work_of_adhesion_J_per_m2


def test_bond_number_of_equal_spheres_and_of_a_sphere_on_a_plane(tmp_path: Path) -> None:
    """w = Bo m g / (3/2 pi R*) is  4/9 Bo rho g d^2  for R* = d/4 and half of it for R* = d/2."""
    scale_J_per_m2 = 5 * 1430.0 * G_M_PER_S2 * 0.02**2
    on_panel, pair = works(tmp_path, BOND_COAL, BOND_ON_PU)
    assert pair == pytest.approx(4 / 9 * scale_J_per_m2, rel=1e-12)
    assert on_panel == pytest.approx(2 / 9 * scale_J_per_m2, rel=1e-12)
    for contact in sticky_contacts(case(tmp_path, BOND_COAL, BOND_ON_PU)):
        weight_N = 1430.0 * math.pi / 6 * 0.02**3 * G_M_PER_S2
        assert contact.pull_off_N == pytest.approx(5 * weight_N, rel=1e-12)


def test_bond_number_of_a_stated_grain(tmp_path: Path) -> None:
    of_5_mm = works(tmp_path, BOND_COAL, "contacts.1.bond_diameter_m=0.005")[1]
    assert of_5_mm == pytest.approx(4 / 9 * 5 * 1430.0 * G_M_PER_S2 * 0.005**2, rel=1e-12)


def test_bond_number_of_two_materials_weighs_the_lighter_grain(tmp_path: Path) -> None:
    """A ball of polyurethane of 10 mm with one of coal of 20 mm: 1/R* = 2/0.01 + 2/0.02."""
    second = 'bed.particles.soft={position_m=[0.2, 0.1, 0.05], sieve_size_m=0.01, material="PU"}'
    weight_N = 1150.0 * math.pi / 6 * 0.01**3 * G_M_PER_S2
    on_pu, _ = works(tmp_path, BOND_ON_PU, second)
    assert on_pu == pytest.approx(5 * weight_N * 300 / (1.5 * math.pi), rel=1e-12)


def test_default_grain_is_the_median_by_mass_of_what_is_fed(tmp_path: Path) -> None:
    """Two feeds at 1 and 3 kg/s of grains of 4 and 8 mm: three quarters of the mass are of 8 mm.  The
    block of 20 mm and the ball do not count, and neither does where the computation is cut off."""
    box = "box_m=[[0, 0, {0}], [0.1, 0.1, {1}]], velocity_m_per_s=[0, 0, -1]"
    feeds = [
        f'bed.feeds.{name}={{material="coal", rate_kg_per_s={rate}, {box.format(low, low + 0.1)}, '
        f"sizes=[{{smallest_m={size}, largest_m={size}, mass_fraction=1}}]}}"
        for name, rate, size, low in (("fine", 1, 0.004, 0.1), ("coarse", 3, 0.008, 0.3))
    ]
    for cut in ((), ("bed.feeds.coarse.smallest_fed_m=0.005",)):
        pair = works(tmp_path, BOND_COAL, BLOCK, *feeds, *cut)[1]
        assert pair == pytest.approx(4 / 9 * 5 * 1430.0 * G_M_PER_S2 * 0.008**2, rel=1e-12)


def test_default_grain_of_particles_that_the_case_takes_over(tmp_path: Path) -> None:
    """Five grains of 4 mm have less mass than one of 8 mm; they stand for grains half as large."""
    heights_m = [0.05 + 0.01 * number for number in range(6)]
    rows = [f"0.1,0.1,{z:g},{0.004 if z < 0.1 else 0.008},coal" for z in heights_m]
    (tmp_path / "grains.csv").write_text("\n".join(["x_m,y_m,z_m,sieve_size_m,material", *rows]))
    table = "bed.table=grains.csv"
    pair = works(tmp_path, BOND_COAL, table)[1]
    assert pair == pytest.approx(4 / 9 * 5 * 1430.0 * G_M_PER_S2 * 0.008**2, rel=1e-12)
    coarse = case(tmp_path, BOND_COAL, table, "particles.coarse_graining=2").original
    assert coarse.contacts[1].work_of_adhesion_J_per_m2 == pytest.approx(pair / 4, rel=1e-12)


def test_a_bed_that_is_taken_over_does_not_change_the_grain_of_blocks(tmp_path: Path) -> None:
    """The material left on a deck is coarser than what the case describes; the contacts stay those of the
    case."""
    block = 'bed.blocks.coal={material="coal", box_m=[[0.05, 0.05, 0.05], [0.2, 0.15, 0.2]], count=40, sizes='
    block += "[{smallest_m=0.004, largest_m=0.004, mass_fraction=1.0}]}"
    (tmp_path / "grains.csv").write_text("x_m,y_m,z_m,sieve_size_m,material\n0.1,0.1,0.1,0.008,coal\n")
    described = works(tmp_path, BOND_COAL, block)[1]
    assert works(tmp_path, BOND_COAL, block, "bed.table=grains.csv")[1] == pytest.approx(described, rel=1e-12)
    assert described == pytest.approx(4 / 9 * 5 * 1430.0 * G_M_PER_S2 * 0.004**2, rel=1e-12)


def test_median_diameter_by_mass() -> None:
    """Diameters of a class are even by number, so that the mass below d is (d^4 - a^4) / (b^4 - a^4)."""
    whole = [size_class(0.002, 0.004, 1.0)]
    assert median_size_m(whole) == pytest.approx(((0.002**4 + 0.004**4) / 2) ** 0.25, rel=1e-12)
    assert median_size_m([size_class(0.001, 0.001, 0.7), size_class(0.002, 0.002, 0.3)]) == 0.001
    parts = [size_class(0.001, 0.002, 0.2), size_class(0.003, 0.004, 0.8)]
    share = 0.3 / 0.8
    assert median_size_m(parts) == pytest.approx(
        (0.003**4 + share * (0.004**4 - 0.003**4)) ** 0.25, rel=1e-12
    )


@pytest.mark.parametrize(("moisture", "times"), [("dry", 0), ("moist", 1), ("wet", 3), ("sticky", 10)])
def test_moist_contacts_pull_as_a_bridge_of_water(tmp_path: Path, moisture: str, times: int) -> None:
    """A small bridge pulls two wetted spheres with 4 pi gamma R*, which is 2 pi gamma R for equal ones,
    and a sphere on a plane with 4 pi gamma R."""
    overrides = [f"contacts.{k}.moisture={moisture}" for k in (0, 1)]
    pulls_N = [contact.pull_off_N for contact in sticky_contacts(case(tmp_path, *overrides))]
    assert pulls_N == pytest.approx([times * force * math.pi * 0.072 * 0.01 for force in (4, 2) if times])


def test_the_resolved_case_has_the_work_and_is_read_as_the_same_case(tmp_path: Path) -> None:
    given = loaded(tmp_path, [BOND_COAL, "contacts.1.bond_diameter_m=0.005", "contacts.0.moisture=moist"])
    table = resolved_case(given)
    for row in table["contacts"]:
        assert row["work_of_adhesion_J_per_m2"] > 0
        assert not {"bond_number", "bond_diameter_m", "moisture"} & row.keys()
    assert load_case(tmp_path, table).case == given.case


def test_a_later_layer_may_give_adhesion_in_another_way(tmp_path: Path) -> None:
    wet = CASE.replace("restitution = 0.13", "restitution = 0.13\nbond_number = 5")
    literal = "[contacts.1]\nwork_of_adhesion_J_per_m2 = 12.86\n"
    folder = case_folder(tmp_path, wet, literal=literal, bond="[contacts.1]\nbond_number = 10\n")
    assert load_judged(folder, "literal").case.contacts[1].work_of_adhesion_J_per_m2 == 12.86
    by_level = load_judged(folder, "bond").case
    by_set = load_judged(folder, "literal", ["contacts.1.bond_number=10"]).case
    assert by_level.contacts == by_set.contacts
    assert by_level.contacts[1].work_of_adhesion_J_per_m2 > 0


def test_a_level_that_leaves_out_adhesion_by_bond_number_must_say_so(tmp_path: Path) -> None:
    wet = CASE.replace("restitution = 0.13", "restitution = 0.13\nbond_number = 5")
    folder = case_folder(tmp_path, wet, draft='[particles]\nadhesion = "none"\n')
    with pytest.raises(CaseError, match='"adhesion"') as refused:
        load_judged(folder, "draft")
    assert keys_and_kinds(refused.value.problems) == ["without: conflict"]


@pytest.mark.parametrize(
    ("keys", "wanted"),
    [
        ("work_of_adhesion_J_per_m2=1, bond_number=5", "contacts.0.bond_number: conflict"),
        ("bond_number=5, moisture='wet'", "contacts.0.moisture: conflict"),
        ("bond_diameter_m=0.002", "contacts.0.bond_diameter_m: conflict"),
        ("bond_number=-1", "contacts.0.bond_number: out-of-range"),
        ("moisture='moyst'", "contacts.0.moisture: unknown-name"),
        ("bond_number=500000, bond_diameter_m=0.01", "contacts.0.bond_number: out-of-range"),
    ],
)
def test_wrong_bond_numbers_and_moistures(tmp_path: Path, keys: str, wanted: str) -> None:
    row = f'between=["coal", "coal"], restitution=0.2, sliding_friction=0, rolling_friction=0, {keys}'
    on_panel = 'between=["coal", "PU"], restitution=0.2, sliding_friction=0, rolling_friction=0'
    assert kinds(tmp_path, f"contacts=[{{{row}}}, {{{on_panel}}}]".replace("'", '"')) == [wanted]


def test_a_bond_number_without_any_grain_stays(tmp_path: Path) -> None:
    """A case in which nothing can stick has nothing to weigh; it can still be given a bed."""
    empty = CASE.partition("[bed.particles.ball]")[0].replace(
        "restitution = 0.13", "restitution = 0.13\nbond_number = 5"
    )
    assert load_case(tmp_path, empty).case.contacts[1].bond_number == 5
