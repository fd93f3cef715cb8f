"""Archard's wear of the surface: closed forms for every particle solver, and one against another.

Archard, J. F., Journal of Applied Physics 24, 1953, 981-988, doi 10.1063/1.1721448.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from dataclasses import replace

import numpy as np
import pytest

from orchestrator.ports.geometry import TriangleSurface
from orchestrator.ports.plans import GrainMaterial, Jkr, ParticlesPlan
from tests.particles.contract import (
    LIGGGHTS_ALONE,
    WEIGHTLESS,
    Run,
    particles,
    plan,
    plate,
    solver_adapter,
    table,
)
from tests.reference import spheres

ASKED = LIGGGHTS_ALONE

Build = Callable[[ParticlesPlan], Run]

RATE_M3_PER_N_M = 3e-10
MASS_KG = 1430.0 * np.pi / 6.0 * 0.01**3
WEIGHT_N = 9.81 * MASS_KG


def wearing(given: ParticlesPlan) -> ParticlesPlan:
    k = len(given.materials)
    return replace(given, wear_m3_per_N_m=np.full((k, k), RATE_M3_PER_N_M))


def worn_m3(run: Run) -> float:
    return float(run.solver.worn_m3().sum())


def track(surface: TriangleSurface, run: Run) -> tuple[float, float]:
    """Mean place of the worn volume in the plane of the surface."""
    worn = run.solver.worn_m3()
    return tuple(worn @ surface.position_m[:, :2] / worn.sum())


def test_a_smooth_sphere_wears_by_force_times_way(build: Build) -> None:
    """k F s, with the force's impulse as handed over: to rounding, over 30 facets."""
    surface = plate(0.05, 30)
    run = build(wearing(plan(surface, particles([-0.02, 0.001, 0.00495]), sliding_friction=table(0.0))))
    run.velocity_m_per_s = np.array([-0.4, 0.0, 0.0])  # the sphere stays, the surface goes below it
    run.advance(100)
    way_N_m = 0.4 * float(-run.given_N_s[2])
    assert worn_m3(run) == pytest.approx(RATE_M3_PER_N_M * way_N_m, rel=1e-9)
    # and the impulse is the weight's but for what the sphere has kept of its bounce: 2 %
    assert worn_m3(run) == pytest.approx(RATE_M3_PER_N_M * WEIGHT_N * 0.04, rel=0.02)
    place = track(surface, run)  # from -0.02 to 0.02, in the surface's own places
    np.testing.assert_allclose(place, [0.0, 0.001], atol=1e-3)


def test_a_sphere_that_is_thrown_wears_until_it_rolls(build: Build) -> None:
    """Friction mu m g slows it and turns it: its point of contact comes to rest after
    v^2 / (7 mu g), whatever the spring between; then it rolls and wears no more."""
    speed_m_per_s, friction = 0.5, 0.3
    start = particles([-0.1, 0.0, 0.005 - sag_m()], [speed_m_per_s, 0.0, 0.0])
    run = build(wearing(plan(plate(0.2, 4), start, sliding_friction=table(friction))))
    run.advance(40)  # 49 ms until it rolls
    before = worn_m3(run)
    run.advance(60)
    after = worn_m3(run)
    run.advance(20)
    slid_m = speed_m_per_s**2 / (7.0 * friction * 9.81)
    assert before < 0.99 * after
    # 0.2 %: the tangential spring still swings a little when the contact starts to roll
    assert after == pytest.approx(RATE_M3_PER_N_M * WEIGHT_N * slid_m, rel=2e-3)
    assert worn_m3(run) == pytest.approx(after, rel=1e-6)


def sag_m() -> float:
    """Hertz's overlap under the weight: 4/3 E* sqrt(r) overlap^1.5 = F."""
    e_star_Pa = 1e7 / (2.0 * (1.0 - 0.3**2))
    return float((0.75 * WEIGHT_N / (e_star_Pa * np.sqrt(0.005))) ** (2.0 / 3.0))


@pytest.mark.parametrize("youngs_modulus_Pa", [1e9, 1e7])
def test_an_oblique_impact_wears_the_same_however_stiff(build: Build, youngs_modulus_Pa: float) -> None:
    """Sliding throughout, the contact slows down by 3.5 mu times the normal impulse J over the
    mass: worn is k (J v - 7/4 mu J^2 / m), with J = (1 + e) m times the normal speed."""
    normal_m_per_s, along_m_per_s, friction, restitution = 0.5, 2.0, 0.2, 0.6
    surface, hard = plate(0.05, 10), youngs_modulus_Pa > 1e8
    given = plan(
        surface,
        particles([0.0, 0.001, 0.00501], [along_m_per_s, 0.0, -normal_m_per_s]),
        materials=(GrainMaterial("m", youngs_modulus_Pa, 0.3),),
        sliding_friction=table(friction),
        restitution=table(restitution),
        gravity_m_per_s2=WEIGHTLESS,
        step_s=5e-7 if hard else 5e-6,
        sync_interval_s=1e-4,
    )
    run = build(wearing(given))
    run.until_clear()
    impulse_N_s = float(-run.given_N_s[2])
    assert impulse_N_s == pytest.approx((1 + restitution) * MASS_KG * normal_m_per_s, rel=0.01)
    rubbed_J = impulse_N_s * along_m_per_s - 1.75 * friction * impulse_N_s**2 / MASS_KG
    # half the overlap shortens the lever on which friction turns the sphere: 2 % of the soft
    # one's radius, of a term that is a tenth; damping near the end pulls: |F| for F
    assert worn_m3(run) == pytest.approx(RATE_M3_PER_N_M * rubbed_J, rel=0.01)


@pytest.mark.parametrize("adhesion", [None, Jkr(table(0.05), 1e-2)], ids=["dry", "sticky"])
def test_a_contact_that_sticks_wears_nothing(build: Build, adhesion: Jkr | None) -> None:
    """The contact wears nothing however soft it is: the spring gives way by 1 um and comes back."""
    start = particles([0.0, 0.0, 0.005 - sag_m()])
    given = plan(plate(0.02, 3), start, sliding_friction=table(0.5), adhesion=adhesion)
    run = build(wearing(given))
    for _ in range(20):
        run.velocity_m_per_s = -run.velocity_m_per_s if run.velocity_m_per_s.any() else np.array([1e-3, 0, 0])
        run.advance(1)
    assert run.solver.snapshot().velocity_m_per_s[0, 0] != 0.0  # it was dragged along
    assert worn_m3(run) < 1e-12 * RATE_M3_PER_N_M * 0.5 * WEIGHT_N * 1e-6  # it would, if it slid by 1 um


def test_only_the_pair_with_a_rate_wears(build: Build) -> None:
    given = particles([[-0.02, 0.0, 0.00495], [0.02, 0.0, 0.00495]])
    given.grains.material[:] = [0, 1]
    surface = plate(0.05, 4)
    surface.material[:] = 2
    table = np.full((3, 3), 0.5)
    grain = GrainMaterial("m", 1e7, 0.3)
    rate = np.zeros((3, 3))
    rate[1, 2] = rate[2, 1] = RATE_M3_PER_N_M
    run = build(
        plan(
            surface,
            given,
            materials=(grain, grain, grain),
            restitution=table,
            sliding_friction=0.0 * table,
            rolling_friction=0.0 * table,
            wear_m3_per_N_m=rate,
        )
    )
    run.velocity_m_per_s = np.array([0.0, 0.1, 0.0])
    run.advance(20)
    place_m = track(surface, run)
    assert worn_m3(run) > 0.0
    assert place_m[0] == pytest.approx(0.02, abs=1e-9)


@pytest.mark.solver
@pytest.mark.parametrize("adhesion", [None, Jkr(table(0.2), 1e-2)], ids=["dry", "sticky"])
def test_two_codes_wear_alike(adhesion: Jkr | None) -> None:
    """Eighteen spheres with rolling resistance on a moving plate, point by point."""
    liggghts = solver_adapter("liggghts")
    place_m = 0.011 * np.stack(np.meshgrid([-1, 0, 1], [-1, 0, 1], [1, 2], indexing="ij"), -1)
    place_m = place_m.reshape(-1, 3) - np.array([0.0, 0.0, 0.0055])
    velocity_m_per_s = np.random.default_rng(1).normal(0.0, 0.3, (18, 3))
    given = wearing(
        plan(
            plate(0.05, 7),
            particles(place_m, velocity_m_per_s, [5.0, -9.0, 3.0]),
            rolling_friction=table(0.05),
            adhesion=adhesion,
        )
    )
    worn_by_code_m3 = []
    for module in (spheres, liggghts):
        with closing(module.build(given)) as solver:
            run = Run(solver, given, np.array([0.1, 0.05, -0.02]))
            run.advance(25)
            worn_by_code_m3.append(solver.worn_m3())
    assert worn_by_code_m3[0].max() > 0.0
    # the same sums in another order, before chaos sets in
    np.testing.assert_allclose(
        worn_by_code_m3[0], worn_by_code_m3[1], rtol=0.0, atol=1e-8 * worn_by_code_m3[0].max()
    )
