"""An exciter that runs down: the peak while it passes a resonance, with every solver that forces move."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from orchestrator.case import solvers
from orchestrator.ports import Array, Load
from orchestrator.ports.clock import Interval
from orchestrator.ports.plans import FramesPlan
from tests.frames.contract import CASES
from tests.frames.machines import ACROSS, ALONG, body, bushing, exciter, two_bodies

STIFFNESS_N_PER_M, MASS_KG, MOMENT_KG_M = 4 * 225e3, 764.0, 3.5
OWN_RAD_PER_S = np.sqrt(STIFFNESS_N_PER_M / MASS_KG)  # 34.3
LOSS, SPEED_RAD_PER_S, RUN_UP_S = 0.1, 78.5, 0.4
INTERVAL_S = 2.5e-4
SOLVERS = sorted({case.solver for case in CASES.values()} - {"prescribed"})  # all that forces move


def single(stop_s: float, run_down_s: float) -> FramesPlan:
    """One body on four bushings, which two counter-rotating unbalances shake along x only."""
    shakers = tuple(
        exciter(
            SPEED_RAD_PER_S,
            RUN_UP_S,
            axis=axis,
            start=ALONG,
            mass_moment_kg_m=MOMENT_KG_M / 2,
            stop_s=stop_s,
            run_down_s=run_down_s,
        )
        for axis in (ACROSS, -ACROSS)
    )
    plan = two_bodies(shakers, interval_s=INTERVAL_S, step_s=INTERVAL_S)
    places = [np.array([x, y, 0.0]) for x in (-0.9, 0.9) for y in (-0.4, 0.4)]
    return replace(
        plan,
        bodies=(body("driving"),),
        bushings=tuple(bushing(("ground", "driving"), p, (225e3,) * 3, LOSS) for p in places),
        carrier=("driving",) * 4,
        gravity_m_per_s2=np.zeros(3),
    )


def moved_m(solver: str, plan: FramesPlan, until_s: float) -> Array:
    frames = solvers.adapter("frames", solver).build(plan)
    rows = round(until_s / INTERVAL_S)
    along_m = [
        frames.advance(Interval(number, INTERVAL_S), Load.zero(4)).position_m[0, 0] for number in range(rows)
    ]
    frames.close()
    return np.array(along_m) - plan.points_m[0, 0]


def integrated_m(stop_s: float, run_down_s: float, until_s: float) -> Array:
    """m x'' + c x' + k x = u (phi'^2 cos(phi) + phi'' sin(phi)), with phi integrated beside x."""
    damping_N_s_per_m = LOSS * STIFFNESS_N_PER_M / 78.5

    def speed_and_growth(time_s: float) -> tuple[float, float]:
        if time_s <= stop_s:
            share = np.pi * min(time_s, RUN_UP_S) / RUN_UP_S
            rate = np.pi / RUN_UP_S * np.sin(share) if time_s < RUN_UP_S else 0.0
            return SPEED_RAD_PER_S / 2 * (1 - np.cos(share)), SPEED_RAD_PER_S / 2 * rate
        share = np.pi * min(time_s - stop_s, run_down_s) / run_down_s
        rate = np.pi / run_down_s * np.sin(share)
        return SPEED_RAD_PER_S / 2 * (1 + np.cos(share)), -SPEED_RAD_PER_S / 2 * rate

    def rates(time_s: float, state: Array) -> list[float]:
        x_m, v_m_per_s, phi = state
        speed, growth = speed_and_growth(time_s)
        push_N = MOMENT_KG_M * (speed**2 * np.cos(phi) + growth * np.sin(phi))
        pull_N = damping_N_s_per_m * v_m_per_s + STIFFNESS_N_PER_M * x_m
        return [v_m_per_s, (push_N - pull_N) / MASS_KG, speed]

    at_s = INTERVAL_S * np.arange(1, round(until_s / INTERVAL_S) + 1)
    solution = solve_ivp(
        rates, (0.0, until_s), [0.0, 0.0, 0.0], t_eval=at_s, rtol=1e-9, atol=1e-12, max_step=5e-3
    )
    return np.asarray(solution.y[0])


@pytest.mark.parametrize("solver", SOLVERS)
def test_the_peak_while_passing_a_resonance(solver: str) -> None:
    """The peak is met within 0.5 %: the trapezoidal rule of exudyn has an error of phase w t (w h)^2 / 12
    of 1e-3."""
    stop_s, run_down_s, until_s = 0.9, 2.0, 3.4
    found_m, expected_m = (
        moved_m(solver, single(stop_s, run_down_s), until_s),
        integrated_m(stop_s, run_down_s, until_s),
    )
    running = slice(round(0.8 / INTERVAL_S), round(0.9 / INTERVAL_S))
    peak_m = np.abs(expected_m).max()
    assert peak_m > 2.0 * np.abs(expected_m[running]).max()  # the run-down is what shakes it most
    assert np.abs(expected_m).argmax() * INTERVAL_S > stop_s
    assert np.abs(found_m).max() == pytest.approx(peak_m, rel=5e-3)
    assert found_m == pytest.approx(expected_m, abs=5e-3 * peak_m)


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("run_down_s", [0.0, 0.1])
def test_it_stands_still_in_the_end(solver: str, run_down_s: float) -> None:
    """A shaft that stands still does no work on a frame that still swings."""
    plan = replace(single(0.5, run_down_s), sync_interval_s=2e-3, step_s=2e-3)
    frames = solvers.adapter("frames", solver).build(plan)
    books_J, along_m = [], []
    for number in range(400):
        motion = frames.advance(Interval(number, 2e-3), Load.zero(4))
        along_m.append(motion.position_m[0, 0] - plan.points_m[0, 0])
        books_J.append(sum(frames.account().supplied_J.values()))
    frames.close()
    assert np.ptp(along_m[310:]) > 1e-3
    assert np.ptp(books_J[310:]) < 1e-9 * np.ptp(books_J[:250])
