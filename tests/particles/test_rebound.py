"""Restitution over the speed of impacts: closed forms, books, and both codes beside each other."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from typing import Any

import numpy as np
import pytest

from adapters.particles.liggghts.input import input_text
from orchestrator.case.solver_plans import particles_plan
from orchestrator.ports.plans import GrainMaterial, Jkr, ParticlesPlan, Rebound
from tests.cases import BLOCK, kinds, loaded
from tests.particles.contract import (
    WEIGHTLESS,
    Run,
    energy_defect_J,
    particles,
    plan,
    plate,
    solver_adapter,
    table,
)
from tests.particles.liggghts_bed import bed_plan, wave
from tests.particles.liggghts_plans import travel
from tests.particles.restored_bed import hesitating, resumed
from tests.particles.test_contract import MASS_KG

Build = Callable[[ParticlesPlan], Run]

IMPACT_M_PER_S, RESTITUTION = np.array([0.2, 1.0, 3.0]), np.array([0.9, 0.6, 0.4])
"""At 0.1 and 5 m/s it is that of the nearest point, at 0.5 m/s 0.9 - 3 / 8 * 0.3 = 0.7875."""
EXPECTED = {0.1: 0.9, 0.5: 0.7875, 1.0: 0.6, 2.0: 0.5, 5.0: 0.4}
STIFF = GrainMaterial("stiff", 1e9, 0.3)
FALLING = {"gravity_m_per_s2": WEIGHTLESS, "step_s": 2e-7, "sync_interval_s": 2e-5, "materials": (STIFF,)}


def rebound(first: int = 0, second: int = 0) -> dict[str, Any]:
    return {"rebounds": (Rebound((first, second), IMPACT_M_PER_S, RESTITUTION),), "restitution": table(0.9)}


@pytest.mark.parametrize("speed_m_per_s", EXPECTED)
def test_a_sphere_rebounds_from_the_surface_as_the_points_say(build: Build, speed_m_per_s: float) -> None:
    """To 1 %: the contact ends at no overlap, after a short pull.  Momentum and energy are booked."""
    given = particles([0.001, 0.002, 0.00501], [0, 0, -speed_m_per_s])
    run = build(plan(plate(0.02, 3), given, **rebound(), **FALLING))
    before = run.solver.account()
    run.until_clear()
    after = run.solver.account()
    rebound_m_per_s = run.solver.snapshot().velocity_m_per_s[0, 2]
    assert rebound_m_per_s / speed_m_per_s == pytest.approx(EXPECTED[speed_m_per_s], rel=0.01)
    gained = after.momentum_kg_m_per_s - before.momentum_kg_m_per_s
    np.testing.assert_allclose(gained + run.given_N_s, 0.0, atol=1e-11 * MASS_KG)
    kinetic_J = 0.5 * MASS_KG * speed_m_per_s**2
    lost_J = kinetic_J * (1 - EXPECTED[speed_m_per_s] ** 2)
    assert after.lost_J["contact_dissipation"] == pytest.approx(lost_J, abs=0.02 * kinetic_J)
    assert energy_defect_J(before, after) == pytest.approx(0.0, abs=1e-3 * kinetic_J)


@pytest.mark.parametrize("speed_m_per_s", EXPECTED)
def test_two_spheres_part_as_the_points_say(build: Build, speed_m_per_s: float) -> None:
    """Head-on, by the speed with which they close in."""
    given = particles([[-0.00501, 0, 0.5], [0.00501, 0, 0.5]], [[speed_m_per_s, 0, 0], [0, 0, 0]])
    run = build(plan(plate(0.01, 1), given, **rebound(), **FALLING))
    before = run.solver.account()
    run.advance(60)
    after, now = run.solver.account(), run.solver.snapshot()
    first, second = now.velocity_m_per_s[:, 0]
    assert (second - first) / speed_m_per_s == pytest.approx(EXPECTED[speed_m_per_s], rel=0.01)
    np.testing.assert_allclose(after.momentum_kg_m_per_s, before.momentum_kg_m_per_s, atol=1e-11 * MASS_KG)
    assert after.angular is not None
    assert before.angular is not None
    turned = after.angular.momentum_kg_m2_per_s - before.angular.momentum_kg_m2_per_s
    np.testing.assert_allclose(turned, 0.0, atol=1e-12 * MASS_KG)


def test_a_moving_surface_counts(build: Build) -> None:
    """A sphere at rest that a surface of 1 m/s meets leaves it with 0.6 of that, besides its own."""
    run = build(plan(plate(0.02, 3), particles([0.001, 0.002, 0.00501]), **rebound(), **FALLING))
    run.velocity_m_per_s = np.array([0.0, 0.0, 1.0])
    run.until_clear()
    assert run.solver.snapshot().velocity_m_per_s[0, 2] == pytest.approx(1.6, rel=0.01)


def test_every_contact_has_a_speed_of_its_own(build: Build) -> None:
    """Two drops at once, of 1 and 2 m/s."""
    given = particles([[-0.01, 0, 0.00501], [0.01, 0, 0.00501]], [[0, 0, -1.0], [0, 0, -2.0]])
    run = build(plan(plate(0.03, 3), given, **rebound(), **FALLING))
    run.until_clear()
    up_m_per_s = run.solver.snapshot().velocity_m_per_s[:, 2]
    np.testing.assert_allclose(up_m_per_s, [0.6, 1.0], rtol=0.01)


def test_bodies_that_meet_again_count_anew(build: Build) -> None:
    """Between two plates: e of 2 m/s is 0.5, that of what is left, 1 m/s, 0.6."""
    low, high = plate(0.02, 1), plate(0.02, 1)
    high.position_m[:, 2] += 0.0105
    both = type(low)(
        np.concatenate([low.position_m, high.position_m]),
        np.concatenate([low.triangles, high.triangles + len(low.position_m)]),
        np.concatenate([low.material, high.material]),
    )
    run = build(plan(both, particles([0.001, 0.002, 0.0052], [0, 0, -2.0]), **rebound(), **FALLING))
    run.until_clear()
    run.until_clear()
    assert run.solver.snapshot().velocity_m_per_s[0, 2] == pytest.approx(-0.6, rel=0.015)


def test_a_pair_that_meets_again_counts_anew(build: Build) -> None:
    """A sphere of 2 m/s hits another one, which comes back from a wall; the pair never parts by 0.5 mm.

    e(2) = 0.5 leaves 0.5 and 1.5 m/s; the wall turns 1.5 into -0.55 * 1.5 = -0.825; the two close in with
    1.325, where e = 0.5675, and part with 0.752 about their mean of -0.1625 m/s."""
    wall = plate(0.02, 1)
    wall.position_m[:] = wall.position_m[:, [2, 0, 1]]
    given = particles([[-0.0154, 0.001, 0.002], [-0.0052, 0.001, 0.002]], [[2.0, 0, 0], [0, 0, 0]])
    run = build(plan(wall, given, **rebound(), **FALLING))
    run.advance(60)
    first_m_per_s = run.solver.snapshot().velocity_m_per_s[0, 0]  # the second one has met the wall again
    assert first_m_per_s == pytest.approx(-0.1625 - 0.376, abs=0.01)


def test_only_the_pair_with_points_has_them(build: Build) -> None:
    materials = (STIFF, GrainMaterial("plate", 1e9, 0.3))
    table, surface = np.full((2, 2), 0.7), plate(0.02, 3)
    of_grains = {"rebounds": (Rebound((0, 0), IMPACT_M_PER_S, RESTITUTION),), "restitution": table}
    surface.material[:] = 1
    laws = {"materials": materials, "sliding_friction": 0 * table, "rolling_friction": 0 * table}
    given = particles([0.001, 0.002, 0.00501], [0, 0, -2.0])
    run = build(plan(surface, given, **FALLING | laws | of_grains))
    run.until_clear()
    assert run.solver.snapshot().velocity_m_per_s[0, 2] == pytest.approx(0.7 * 2.0, rel=0.01)


def with_points(layers: int = 1, **changes: Any) -> ParticlesPlan:
    """The thrown bed with restitutions of both pairs over speed."""
    points = tuple(
        Rebound(pair, np.array([0.02, 0.2, 0.6]), np.array(values))
        for pair, values in (((0, 0), [0.9, 0.6, 0.3]), ((0, 1), [0.8, 0.5, 0.4]))
    )
    return bed_plan(layers=layers, rebounds=points, **changes)


@pytest.mark.solver
@pytest.mark.parametrize("adhesion", [None, Jkr(np.full((2, 2), 0.5), 1e-2)], ids=["dry", "sticky"])
def test_two_codes_rebound_alike(adhesion: Jkr | None) -> None:
    """Grains among each other and on a moving sheet, with friction; before chaos sets in."""
    some = {"adhesion": adhesion, "feed": None, "step_s": 2e-6}
    ends = []
    for name in ("spheres", "liggghts"):
        wanted = with_points(**some)
        with closing(solver_adapter(name).build(wanted)) as solver:
            travel(solver, wave, range(60))
            ends.append(solver.snapshot().velocity_m_per_s)
    assert np.abs(ends[0] - ends[1]).max() < 1e-6


@pytest.mark.solver
@pytest.mark.parametrize("adhesion", [None, Jkr(np.full((2, 2), 0.5), 1e-2)], ids=["dry", "sticky"])
@pytest.mark.parametrize("smooth", [False, True], ids=["rough", "smooth"])
def test_liggghts_goes_on_and_steps_back_bit_for_bit(adhesion: Jkr | None, smooth: bool) -> None:
    some: dict[str, Any] = {"adhesion": adhesion, "step_s": 2e-6, "layers": 4}
    if smooth:
        some |= {"sliding_friction": 0.0, "rolling_friction": 0.0}
    assert resumed("liggghts", with_points(**some), 37, 70) == []
    assert hesitating("liggghts", with_points(**some), 60) == []


def test_spheres_go_on_bit_for_bit() -> None:
    assert resumed("spheres", with_points(), 12, 27) == []


@pytest.mark.solver
def test_one_point_is_the_constant() -> None:
    """The same restitution as a number and as a point: to the bit."""
    ends = []
    point = (
        Rebound((0, 1), np.array([1.0]), np.array([0.5])),
        Rebound((0, 0), np.array([1.0]), np.array([0.5])),
    )
    for points in ((), point):
        with closing(solver_adapter("liggghts").build(bed_plan(rebounds=points))) as solver:
            travel(solver, wave, range(60))
            ends.append(solver.snapshot().velocity_m_per_s)
    np.testing.assert_array_equal(ends[0], ends[1])


POINTS = "[{impact_m_per_s=0.5, restitution=0.8}, {impact_m_per_s='2000 mm/s', restitution=0.04}]"


def test_a_case_gives_a_number_or_points(tmp_path: Any) -> None:
    case = loaded(tmp_path, [f"contacts.0.restitution={POINTS}".replace("'", '"'), BLOCK]).case
    given = particles_plan(case, plate(0.1, 1))
    assert given is not None
    (curve,) = given.rebounds
    np.testing.assert_array_equal(curve.speed_m_per_s, [0.5, 2.0])
    np.testing.assert_array_equal(curve.restitution, [0.8, 0.04])
    names = [material.name for material in given.materials]
    assert {names[number] for number in curve.materials} == {"PU", "coal"}
    assert given.restitution[curve.materials] == 0.8
    assert [case.contacts[0].restitution_at(speed) for speed in (0.1, 1.25, 9.0)] == pytest.approx(
        [0.8, 0.42, 0.04]
    )
    assert "0.8" in input_text(given)


@pytest.mark.parametrize(
    ("value", "problem"),
    [
        ("1.2", "contacts.0.restitution: out-of-range"),
        ("0.05", "contacts.0.restitution: out-of-range"),
        ('"bouncy"', "contacts.0.restitution: wrong-type"),
        ("[]", "contacts.0.restitution: missing"),
        ("[0.5]", "contacts.0.restitution.0: wrong-type"),
        ("[{impact_m_per_s=1, restitution=0}]", "contacts.0.restitution.0.restitution: out-of-range"),
        ("[{impact_m_per_s=1, restitution=1.1}]", "contacts.0.restitution.0.restitution: out-of-range"),
        ("[{impact_m_per_s=0, restitution=0.5}]", "contacts.0.restitution.0.impact_m_per_s: out-of-range"),
        ("[{impact_m_per_s=1}]", "contacts.0.restitution.0.restitution: missing"),
        (
            "[{impact_m_per_s=2, restitution=0.5}, {impact_m_per_s=1, restitution=0.6}]",
            "contacts.0.restitution.1.impact_m_per_s: conflict",
        ),
        ("[{impact_m_per=1, restitution=0.5}]", "contacts.0.restitution.0.impact_m_per: unknown-key"),
    ],
)
def test_mistakes_in_points_have_one_message_each(tmp_path: Any, value: str, problem: str) -> None:
    assert kinds(tmp_path, f"contacts.0.restitution={value}") == [problem]
