"""Drag of still air on falling and thrown spheres, against the balance of forces and SciPy's integration."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from orchestrator.case.solver_plans import particles_plan
from orchestrator.ports import Array
from orchestrator.ports.physics import sphere_drag_N
from orchestrator.ports.plans import AirPlan, ParticlesPlan
from tests.cases import CASE, FEED, load_case
from tests.effects.verdicts import BARE
from tests.particles.contract import G_M_PER_S2, WEIGHTLESS, Run, energy_defect_J, particles, plan, plate
from tests.particles.test_contract import MASS_KG, UP, OneEachTime, exit_box

Build = Callable[[ParticlesPlan], Run]

AIR = AirPlan(1.204, 1.82e-5)
COAL_KG_PER_M3 = 1430.0
FREE = {
    "domain_m": np.array([[-999.0] * 3, [999.0] * 3]),
    "step_s": 5e-5,
    "sync_interval_s": 1e-2,
    "air": AIR,
}


def drag_coefficient(reynolds: float) -> float:
    """Schiller and Naumann 1933, written down here once more, with Newton's 0.44 as the least."""
    return max(24.0 / reynolds * (1.0 + 0.15 * reynolds**0.687), 0.44)


def drag_N(diameter_m: float, velocity_m_per_s: Array) -> Array:
    speed = float(np.linalg.norm(velocity_m_per_s))
    if speed == 0.0:
        return np.zeros(3)
    reynolds = AIR.density_kg_per_m3 * speed * diameter_m / AIR.viscosity_Pa_s
    front_m2 = math.pi / 4.0 * diameter_m**2
    return -drag_coefficient(reynolds) * front_m2 * AIR.density_kg_per_m3 / 2.0 * speed * velocity_m_per_s


def mass_kg(diameter_m: float) -> float:
    return COAL_KG_PER_M3 * math.pi / 6.0 * diameter_m**3


def thrown(diameter_m: float, velocity_m_per_s: Array, duration_s: float) -> tuple[Array, Array, float]:
    """Place, velocity and the energy that the air took after a throw from the origin, to 1e-9."""

    def rate(_: float, state: Array) -> Array:
        force_N = drag_N(diameter_m, state[3:6])
        taken_W = -float(force_N @ state[3:6])
        return np.array([*state[3:6], *(force_N / mass_kg(diameter_m) + G_M_PER_S2), taken_W])

    start = np.array([*np.zeros(3), *velocity_m_per_s, 0.0])
    end = solve_ivp(rate, (0.0, duration_s), start, rtol=1e-10, atol=1e-14).y[:, -1]
    return end[:3], end[3:6], float(end[6])


@pytest.mark.parametrize(
    ("diameter_m", "about_m_per_s"), [(5e-5, 0.100), (5e-4, 2.6), (1e-3, 4.8), (2e-3, 8.4), (0.02, 26.6)]
)
def test_a_grain_falls_with_its_terminal_speed(build: Build, diameter_m: float, about_m_per_s: float) -> None:
    """The speed whose drag is the weight, to 0.1 %; 50 um are nearly Stokes's, 20 mm Newton's."""

    def surplus_N(speed_m_per_s: float) -> float:
        return float(drag_N(diameter_m, -speed_m_per_s * UP)[2]) - mass_kg(diameter_m) * 9.81

    terminal_m_per_s = brentq(surplus_N, 1e-6, 1e3)
    assert terminal_m_per_s == pytest.approx(about_m_per_s, rel=0.02)
    slows_s = terminal_m_per_s / 9.81
    given = particles([0, 0, 900.0], -0.9 * terminal_m_per_s * UP, diameter_m=diameter_m)
    steps = {"step_s": slows_s / 200, "sync_interval_s": slows_s / 10}
    run = build(plan(plate(0.001, 1), given, **FREE | steps))
    run.advance(60)  # six times the time in which it slows down: a tenth becomes 0.02 %
    fallen_m_per_s = -run.solver.snapshot().velocity_m_per_s[0, 2]
    assert fallen_m_per_s == pytest.approx(terminal_m_per_s, rel=1e-3)


@pytest.mark.parametrize("diameter_m", [5e-4, 2e-3, 0.02])
def test_a_thrown_grain_flies_and_loses_what_scipy_integrates(build: Build, diameter_m: float) -> None:
    """Drag goes by the speed of half a step ago: to the step over the time in which a grain slows down."""
    start_m_per_s = np.array([3.0, 0.5, 2.5])
    given = particles([0, 0, 0.5], start_m_per_s, [7.0, 0.0, 3.0], diameter_m=diameter_m)
    run = build(plan(plate(0.001, 1), given, **FREE))
    before = run.solver.account()
    run.advance(20)
    now, after = run.solver.snapshot(), run.solver.account()
    flown_m, velocity_m_per_s, air_J = thrown(diameter_m, start_m_per_s, 0.2)
    np.testing.assert_allclose(now.position_m[0] - [0, 0, 0.5], flown_m, rtol=0.0, atol=5e-5)
    np.testing.assert_allclose(now.velocity_m_per_s[0], velocity_m_per_s, rtol=0.0, atol=5e-4)
    np.testing.assert_array_equal(now.spin_rad_per_s[0], [7.0, 0.0, 3.0])
    assert after.lost_J["air_drag"] == pytest.approx(air_J, rel=5e-4)
    assert air_J > 0.01 * before.stored_J["kinetic"]
    # what Verlet leaves over of its first and last half step, dt^2 (f_1^2 - f_0^2) / (8 m)
    assert after.lost_J["contact_dissipation"] == pytest.approx(0.0, abs=1e-7 * before.stored_J["kinetic"])


def test_books_close_while_grains_fly_hit_feed_and_leave(build: Build) -> None:
    """Momentum and angular momentum to rounding, with an air a thousand times as dense as ours."""
    place_m = 0.011 * np.stack(np.meshgrid([-1, 0, 1], [-1, 0, 1], [1, 2], indexing="ij"), -1)
    place_m = place_m.reshape(-1, 3) - np.array([0.0, 0.0, 0.0055])
    velocity_m_per_s = np.random.default_rng(1).normal(0.0, 0.3, (18, 3))
    given = particles(place_m, velocity_m_per_s, [5.0, -9.0, 3.0])
    thick = {"air": AirPlan(1204.0, 0.0182), "exits": (exit_box([0, 0, 0.2], [0.3, 0.4, 0.09]),)}
    run = build(plan(plate(0.03, 5), given, feed=OneEachTime(), **thick))
    before = run.solver.account()
    run.advance(60)
    after, gone = run.solver.account(), run.solver.removed()
    assert len(gone.id) > 10
    assert abs(run.given_N_s[2]) > 1e-2 * MASS_KG  # there were impacts
    assert after.lost_J["air_drag"] > 0.1 * after.supplied_J["feed"]
    outside_N_s = after.outside_impulse_N_s - before.outside_impulse_N_s
    gained_N_s = after.momentum_kg_m_per_s - before.momentum_kg_m_per_s - outside_N_s
    np.testing.assert_allclose(gained_N_s + run.given_N_s, 0.0, atol=1e-11 * MASS_KG)
    was, now = before.angular, after.angular
    assert was is not None
    assert now is not None
    gained = now.momentum_kg_m2_per_s - was.momentum_kg_m2_per_s
    outside = now.outside_impulse_N_m_s - was.outside_impulse_N_m_s
    received = now.received_N_m_s["surface"] - was.received_N_m_s["surface"]
    np.testing.assert_allclose(gained - outside - received, 0.0, atol=1e-12 * MASS_KG)
    assert energy_defect_J(before, after) == pytest.approx(0.0, abs=2e-3 * after.lost_J["air_drag"])


def test_without_air_nothing_is_booked_for_it(build: Build) -> None:
    run = build(plan(plate(0.001, 1), particles([0, 0, 0.5]), gravity_m_per_s2=WEIGHTLESS))
    assert set(run.solver.account().lost_J) == {"contact_dissipation"}


@pytest.mark.parametrize("reynolds", [1e-3, 0.5, 30.0, 900.0, 1e4, 1e5])
def test_the_drag_coefficient_is_schiller_and_naumann_s(reynolds: float) -> None:
    """And Newton's 0.44 from some 990 on; 2 % of what Clift, Grace and Weber tabulate at 1 (27.1 / Re)."""
    density, viscosity, diameter_m = 1.2, 1.8e-5, 1e-3
    speed = reynolds * viscosity / (density * diameter_m)
    pressure_N = density / 2.0 * speed**2 * math.pi / 4.0 * diameter_m**2
    force_N = float(sphere_drag_N(np.array(diameter_m), np.array(speed), density, viscosity))
    assert force_N / pressure_N == pytest.approx(drag_coefficient(reynolds), rel=1e-12)
    assert drag_coefficient(1.0) == pytest.approx(27.1, rel=0.02)


def test_coarse_grains_slow_down_as_real_ones(tmp_path: Path) -> None:
    """k^3 times the force, at every speed: air of k times the density and k^2 times the viscosity."""
    plans = []
    for k in (1, 2):
        overrides = [
            "air={density_kg_per_m3=1.1, viscosity_Pa_s=2e-5}",
            f"particles.coarse_graining={k}",
            FEED,
        ]
        case = load_case(tmp_path, BARE, overrides).case
        given = particles_plan(case, plate(0.1, 1))
        assert given is not None
        plans.append(given.air)
    real, coarse = plans
    speed = np.geomspace(1e-3, 30.0, 9)
    of_real_N, of_coarse_N = (
        sphere_drag_N(k * np.array(2e-3), speed, air.density_kg_per_m3, air.viscosity_Pa_s)
        for k, air in ((1, real), (2, coarse))
    )
    assert real == AirPlan(1.1, 2e-5)
    np.testing.assert_allclose(of_coarse_N, 8.0 * of_real_N, rtol=1e-12)


def test_the_law_none_leaves_the_air_out(tmp_path: Path) -> None:
    case = load_case(tmp_path, CASE, ["air={}", "particles.air_drag=none"]).case
    given = particles_plan(case, plate(0.1, 1))
    assert given is not None
    assert given.air is None
