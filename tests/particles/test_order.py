"""Order of the particles' time step, cause by cause (docs/theory/spheres.md)."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import closing
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from orchestrator.ports import Array, HermitePath, Motion
from orchestrator.ports.clock import Interval
from orchestrator.ports.plans import ParticlesPlan
from tests.particles.contract import WEIGHTLESS, particles, plan, plate, table

RADIUS_M, SPEED_M_S = 0.005, 0.5
MASS_KG = 1430.0 * np.pi / 6.0 * (2 * RADIUS_M) ** 3
E_STAR_PA = 1e7 / (2.0 * (1.0 - 0.3**2))
LENGTH_S = 1e-4  # of an interval; the impact lasts 13 to 16
Height = Callable[[float], tuple[float, float]]  # and velocity, of the plate at a time


def still(_: float) -> tuple[float, float]:
    return 0.0, 0.0


def shaken(time_s: float) -> tuple[float, float]:
    amplitude_m, omega_1_s = 2e-4, 2.0 * np.pi * 150.0
    phase = omega_1_s * time_s
    return amplitude_m * np.sin(phase), amplitude_m * omega_1_s * np.cos(phase)


def at(given: ParticlesPlan, height_m: float, velocity_m_per_s: float) -> Motion:
    """The plate."""
    up = np.broadcast_to([0.0, 0.0, 1.0], given.surface.position_m.shape)
    return Motion(given.surface.position_m + height_m * up, velocity_m_per_s * up)


def following(given: ParticlesPlan, height: Height, intervals: int) -> list[HermitePath]:
    motions = [at(given, *height(index * LENGTH_S)) for index in range(intervals + 1)]
    return [HermitePath(start, end, LENGTH_S) for start, end in pairwise(motions)]


def carried(module: Any, given: ParticlesPlan, paths: Iterable[HermitePath]) -> tuple[Array, Array]:
    """Heights and velocities of the spheres after the plate went along."""
    with closing(module.build(given)) as opened:
        for index, path in enumerate(paths):
            opened.advance(Interval(index, LENGTH_S), path)
        now = opened.snapshot()
    return now.position_m[:, 2], now.velocity_m_per_s[:, 2]


def dropped(restitution: float, steps: int) -> ParticlesPlan:
    """Twenty-five spheres that begin to touch at as many instants of a step."""
    row_m = 0.012 * np.arange(-2, 3) + 0.001
    x, y = (k.ravel() for k in np.meshgrid(row_m, row_m + 0.002))
    z = RADIUS_M + np.linspace(1e-5, 6e-5, 25, endpoint=False)
    return plan(
        plate(0.05, 1),
        particles(np.stack([x, y, z], axis=1), [0.0, 0.0, -SPEED_M_S]),
        restitution=table(restitution),
        gravity_m_per_s2=WEIGHTLESS,
        step_s=LENGTH_S / steps,
        sync_interval_s=LENGTH_S,
    )


@pytest.mark.parametrize("height", [still, shaken])
def test_without_dampers_it_is_of_second_order(module: Any, height: Height) -> None:
    """The order is measured inside the contact, against a fine step."""
    places_m = []
    for steps in (4, 8, 16, 128):
        given = dropped(1.0, steps)
        places_m.append(carried(module, given, following(given, height, 8))[0])
    error_m = [np.sqrt(np.mean((place - places_m[-1]) ** 2)) for place in places_m[:-1]]
    np.testing.assert_allclose(np.log2(np.divide(error_m[:-1], error_m[1:])), 2.0, atol=0.2)


def rebound_m_per_s(restitution: float, late_s: float) -> float:
    """Return the rebound of Hertz's spring with Tsuji's damper, whose force is that of the velocity
    ``late_s`` ago: c (v - late a), as if the mass were m - c late."""
    log_e = np.log(restitution)
    damping = 2.0 * np.sqrt(5.0 / 6.0) * -log_e / np.hypot(log_e, np.pi)

    def rates(_: float, at: Array) -> list[float]:
        stiffness = 2.0 * E_STAR_PA * np.sqrt(RADIUS_M * max(at[0], 0.0))
        damper = damping * np.sqrt(stiffness * MASS_KG)
        force_N = -2.0 / 3.0 * stiffness * at[0] - damper * at[1]
        return [at[1], force_N / (MASS_KG - damper * late_s)]

    def parted(_: float, at: Array) -> float:
        return float(at[0])

    parted.terminal, parted.direction = True, -1.0  # type: ignore[attr-defined]
    solution = solve_ivp(
        rates, (0.0, 1e-2), [0.0, SPEED_M_S], "DOP853", events=parted, rtol=1e-10, atol=1e-14
    )
    return -float(solution.y[1, -1])


def test_dampers_go_by_the_end_of_the_step(module: Any) -> None:
    """Verlet's velocities are those of the step's middle while forces are evaluated.  Dampers that went
    by them would be half a step late and change the rebound e v at first order in the step; what is left is
    less than a tenth of that in the mean of spheres that begin to touch at any time of a step."""
    exact_m_per_s = 0.34 * SPEED_M_S
    assert rebound_m_per_s(0.34, 0.0) == pytest.approx(exact_m_per_s, rel=1e-3)
    for steps in (8, 16, 32):
        given = dropped(0.34, steps)
        found_m_per_s = carried(module, given, following(given, still, 22))[1]
        late_m_per_s = rebound_m_per_s(0.34, LENGTH_S / steps / 2.0)
        assert abs(np.mean(found_m_per_s) - exact_m_per_s) < 0.1 * abs(late_m_per_s - exact_m_per_s)


def single(place_m: float, restitution: float, steps: int) -> ParticlesPlan:
    return plan(
        plate(0.02, 1),
        particles([0.001, 0.0, place_m]),
        restitution=table(restitution),
        gravity_m_per_s2=WEIGHTLESS,
        step_s=LENGTH_S / steps,
        sync_interval_s=LENGTH_S,
    )


def test_a_sphere_rests_on_a_plate_that_accelerates(module: Any) -> None:
    """The overlap at 50 g is Hertz's under 50 times its weight, whatever the step and the damper: both
    velocities that the damper compares are those of the middle of the step."""
    acceleration_m_per_s2 = 490.0
    overlap_m = (0.75 * MASS_KG * acceleration_m_per_s2 / (E_STAR_PA * RADIUS_M**0.5)) ** (2.0 / 3.0)

    def pushed(time_s: float) -> tuple[float, float]:
        return acceleration_m_per_s2 * time_s**2 / 2.0, acceleration_m_per_s2 * time_s

    given = single(RADIUS_M - overlap_m, 0.34, 2)
    (place_m,), _ = carried(module, given, following(given, pushed, 40))
    found_m = RADIUS_M - (place_m - pushed(40 * LENGTH_S)[0])
    assert found_m == pytest.approx(overlap_m, rel=1e-8)


def test_a_jump_of_the_surface_is_felt_at_once(module: Any) -> None:
    """A plate jumps into a sphere by d; Hertz's energy, 8/15 E* sqrt(r) d^(5/2), throws it off.  The half
    step that follows goes by the force after the jump, so that the order is two."""
    jump_m = 6e-5
    energy_J = 8.0 / 15.0 * E_STAR_PA * RADIUS_M**0.5 * jump_m**2.5
    speed_m_per_s = np.sqrt(2.0 * energy_J / MASS_KG)
    steps, places_m = np.array([8, 16, 32, 64]), []
    for n in steps:
        given = single(RADIUS_M, 1.0, n)
        before, after = (at(given, height_m, 0.0) for height_m in (0.0, jump_m))
        paths = [HermitePath(before, before, LENGTH_S), *[HermitePath(after, after, LENGTH_S)] * 19]
        (place_m,), (found_m_per_s,) = carried(module, given, paths)
        assert found_m_per_s == pytest.approx(speed_m_per_s, rel=2e-3)
        places_m.append(place_m)
    earlier_s = np.diff(places_m) / speed_m_per_s  # than with steps twice as long
    np.testing.assert_allclose(np.log2(earlier_s[:-1] / earlier_s[1:]), 2.0, atol=0.3)
    assert earlier_s[0] < 0.01 * LENGTH_S / steps[0] / 4.0
