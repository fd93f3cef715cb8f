"""Adhesion in the case: checks, softening, the mapping of sjkr, the step."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from orchestrator.case.bed.adhesion import adhesive_step_s, planned_adhesion, sticky_contacts
from orchestrator.case.bed.contact_times import contact_moduli, reduced_modulus_Pa, shortest_rayleigh_s
from orchestrator.case.solver_plans import material_numbers, particle_step_s
from orchestrator.case.tables.case import Case
from orchestrator.ports.plans import Jkr, Sjkr
from orchestrator.preflight.judgement.catalogue import find_left_out
from tests.cases import complaints, loaded, only_complaint

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
    one, two = (contact_moduli(given.materials[name], None) for name in ("PU", "coal"))
    gaps_m = [
        0.75 * (math.pi**2 * w**2 * radius_m / e_star_Pa**2) ** (1 / 3)
        for w, radius_m, e_star_Pa in (
            (0.1, 0.010, reduced_modulus_Pa(one, two)),
            (0.2, 0.005, reduced_modulus_Pa(two, two)),
        )
    ]
    assert plan.largest_stretch == pytest.approx(max(gaps_m) / 0.010, rel=1e-6)


@pytest.mark.parametrize("rule", ["sticking", "pull-off"])
def test_softening(tmp_path: Path, rule: str) -> None:
    """Kept are  w^5 / E*^2,  hence the sticking speed, or w, hence the pull-off force."""
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
    assert "particles that stick" in only_complaint(tmp_path, *WET, step)
    assert not complaints(tmp_path, step)
    assert not complaints(tmp_path, *WET)


def test_adhesion_asked_for_without_work(tmp_path: Path) -> None:
    said = only_complaint(tmp_path, 'particles.adhesion="jkr"')
    assert "every work of adhesion is zero" in said
    assert not complaints(tmp_path)


def test_negative_and_absurd_works(tmp_path: Path) -> None:
    assert "contacts.0.work_of_adhesion_J_per_m2" in only_complaint(
        tmp_path, "contacts.0.work_of_adhesion_J_per_m2=-1"
    )
    said = only_complaint(tmp_path, "contacts.0.work_of_adhesion_J_per_m2=7750")
    assert "looks like mJ/m2" in said


def test_a_neck_wider_than_half_the_radius(tmp_path: Path) -> None:
    fine = ("bed.particles.ball.diameter_m=0.0002", "contacts.1.work_of_adhesion_J_per_m2=40")
    assert "neck as wide as" in only_complaint(tmp_path, *fine)


def test_a_pull_of_a_million_weights(tmp_path: Path) -> None:
    dust = (
        "bed.particles.ball.diameter_m=0.00002",
        "contacts.1.work_of_adhesion_J_per_m2=12",
        "materials.coal.youngs_modulus_Pa=1e11",
        "coupling.sync_interval_s=1e-6",
    )
    assert "times their weight" in only_complaint(tmp_path, *dust)


def test_sjkr_wants_a_material_of_its_own_for_surfaces(tmp_path: Path) -> None:
    same = ('bed.particles.ball.material="PU"', *WET, 'particles.adhesion="sjkr"')
    pu = 'contacts.1.between=["PU", "PU"]'
    assert any("cannot tell them apart" in said for said in complaints(tmp_path, *same, pu))
    key = "particles.sjkr_diameter_m=0.003"
    assert "no meaning" in only_complaint(tmp_path, *WET, key)
