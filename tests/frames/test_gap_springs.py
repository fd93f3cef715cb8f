"""Piecewise linear bushings: free vibration against closed forms, the force of a stop, and the preload."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import ellipk

from adapters.frames.common.gap_springs import GapSprings
from orchestrator.case import solvers
from orchestrator.ports import Array, Load
from orchestrator.ports.clock import Interval
from orchestrator.ports.frames import find_element_forces_N, find_frame_loads
from orchestrator.ports.plans import CharacteristicPlan, FramesPlan
from tests.frames.machines import ALONG, GRAVITY, UP, body, bushing

SOLVERS = ("two-mass", "planar", pytest.param("exudyn", marks=pytest.mark.solver))
every_solver = pytest.mark.parametrize("solver", SOLVERS)
MASS_kg, SPRING_N_per_m, GAP_m, STOP_N_per_m = 764.0, 4e5, 4e-3, 3e6


def stops(axis: int = 0, elastic_N_per_m: float = SPRING_N_per_m) -> CharacteristicPlan:
    """A spring with a stop on each side."""
    return CharacteristicPlan(
        axis, elastic_N_per_m, np.array([1.0, -1.0]), np.full(2, GAP_m), np.full(2, STOP_N_per_m)
    )


def one_body(law: CharacteristicPlan, step_s: float = 0.0, gravity: bool = False) -> FramesPlan:
    """A body on one bushing whose law is along ``law.axis``."""
    held = bushing(("ground", "block"), np.zeros(3), (SPRING_N_per_m,) * 3, 0.0)
    return FramesPlan(
        bodies=(body("block", MASS_kg),),
        bushings=(replace(held, characteristics=(law,)),),
        exciters=(),
        drives=(),
        gravity_m_per_s2=GRAVITY if gravity else np.zeros(3),
        points_m=np.zeros((1, 3)),
        carrier=("block",),
        reaction_N=np.zeros((1, 3)),
        drawn_at_rest=gravity,
        step_s=step_s,
        sync_interval_s=step_s or 1e-3,
    )


def kicked(solver: str, plan: FramesPlan, speed_m_per_s: float, end_s: float) -> tuple[Array, Array, Array]:
    """Times, places along x and whole energies of the body, which a blow of one interval sets going.  Time
    counts from the blow's end, at which the body has its speed and is still at zero but for 1e-9 m."""
    frames = solvers.adapter("frames", solver).build(plan)
    step_s, blow_s = plan.sync_interval_s, 1e-9
    blow_N = MASS_kg * speed_m_per_s / blow_s
    motion = frames.advance(Interval(0, blow_s), Load(blow_N * ALONG[None]))
    assert motion.velocity_m_per_s[0, 0] == pytest.approx(speed_m_per_s, rel=1e-6)
    rows = [(0.0, motion.position_m[0, 0], sum(frames.account().stored_J.values()))]
    for index in range(round(end_s / step_s)):
        motion = frames.advance(Interval(index, step_s), Load.zero(1))
        rows.append(((index + 1) * step_s, motion.position_m[0, 0], sum(frames.account().stored_J.values())))
    time_s, place_m, energy_J = np.array(rows).T
    return time_s, place_m, energy_J


def period_s(time_s: Array, place_m: Array) -> float:
    """Mean time between upward passages of zero, from the second on, by a parabola through three rows."""
    up = np.flatnonzero((place_m[:-1] < 0) & (place_m[1:] >= 0))[1:-1]
    passed_s = []
    for row in up:
        near = slice(row - 1, row + 3)
        roots = np.roots(np.polyfit(time_s[near] - time_s[row], place_m[near], 3))
        passed_s.append(time_s[row] + float(min(roots[abs(roots.imag) < 1e-9].real, key=abs)))
    return float((passed_s[-1] - passed_s[0]) / (len(passed_s) - 1))


def gap_period_s(speed_m_per_s: float) -> tuple[float, float]:
    """Period and amplitude of a spring between two stops, by energy.

    Up to the gap the motion is a sine of the spring's frequency w.  Beyond it, both springs are one of
    k + K about the place where its force would be zero, K g / (k + K), with the frequency W.
    """
    k, stiff = SPRING_N_per_m, SPRING_N_per_m + STOP_N_per_m
    w, fast = np.sqrt(k / MASS_kg), np.sqrt(stiff / MASS_kg)
    at_gap_m_per_s = np.sqrt(speed_m_per_s**2 - (w * GAP_m) ** 2)
    rest_m = STOP_N_per_m * GAP_m / stiff
    beyond_m = np.hypot(GAP_m - rest_m, at_gap_m_per_s / fast)
    free_s = np.arcsin(w * GAP_m / speed_m_per_s) / w
    stopped_s = np.arccos((GAP_m - rest_m) / beyond_m) / fast
    return float(4 * (free_s + stopped_s)), float(rest_m + beyond_m)


@every_solver
def test_the_period_between_two_stops(solver: str) -> None:
    """Period and amplitude within 2e-4: second order in steps of a 350th of the period."""
    speed_m_per_s = 0.3
    expected_s, amplitude_m = gap_period_s(speed_m_per_s)
    time_s, place_m, energy_J = kicked(solver, one_body(stops(), 4e-4), speed_m_per_s, 12 * expected_s)
    assert expected_s < 0.7 * 2 * np.pi * np.sqrt(MASS_kg / SPRING_N_per_m)
    assert period_s(time_s, place_m) == pytest.approx(expected_s, rel=2e-4)
    assert np.abs(place_m).max() == pytest.approx(amplitude_m, rel=2e-4)
    assert energy_J == pytest.approx(MASS_kg * speed_m_per_s**2 / 2, rel=1e-9)


@every_solver
def test_the_error_of_the_period_is_of_second_order(solver: str) -> None:
    speed_m_per_s = 0.3
    expected_s, _ = gap_period_s(speed_m_per_s)
    errors = []
    for step_s in (8e-4, 2e-4):
        time_s, place_m, _ = kicked(solver, one_body(stops(), step_s), speed_m_per_s, 12 * expected_s)
        errors.append(abs(period_s(time_s, place_m) / expected_s - 1))
    assert errors[1] < errors[0] / 8


@every_solver
def test_the_period_of_a_hardening_spring(solver: str) -> None:
    """Duffing's oscillator  m x'' + k x + c x^3 = 0  of amplitude A has the period  4 K(m) / W  with  W^2 =
    (k + c A^2) / m  and the parameter  m = c A^2 / 2 (k + c A^2)  (Kovacic and Brennan, The Duffing Equation,
    2011, section 2.2).  The characteristic is a table of 160 steps, which is within 1e-4 of the cubic's
    force; 3e-4 with the step's error."""
    cubic_N_per_m3, amplitude_m = 1.2e10, 1e-2
    place_m = np.linspace(0, 1.25e-2, 161)
    slope = np.diff(SPRING_N_per_m * place_m + cubic_N_per_m3 * place_m**3) / np.diff(place_m)
    gap_m, more = place_m[1:-1], np.diff(slope)
    law = CharacteristicPlan(
        0, float(slope[0]), np.repeat([1.0, -1.0], len(gap_m)), np.tile(gap_m, 2), np.tile(more, 2)
    )
    energy_J = SPRING_N_per_m * amplitude_m**2 / 2 + cubic_N_per_m3 * amplitude_m**4 / 4
    speed_m_per_s = float(np.sqrt(2 * energy_J / MASS_kg))
    steepest = SPRING_N_per_m + cubic_N_per_m3 * amplitude_m**2
    expected_s = 4 * ellipk(cubic_N_per_m3 * amplitude_m**2 / (2 * steepest)) / np.sqrt(steepest / MASS_kg)
    time_s, moved_m, stored_J = kicked(solver, one_body(law, 5e-4), speed_m_per_s, 8 * expected_s)
    assert expected_s < 0.6 * 2 * np.pi * np.sqrt(MASS_kg / SPRING_N_per_m)
    assert period_s(time_s, moved_m) == pytest.approx(expected_s, rel=3e-4)
    assert np.abs(moved_m).max() == pytest.approx(amplitude_m, rel=3e-4)
    assert stored_J == pytest.approx(energy_J, rel=1e-4)


@every_solver
def test_the_force_of_a_stop(solver: str) -> None:
    """A push of 9 kN along x, held by a damper until it rests: k x + K (x - g) = F.  Spring and stop, the
    recorded forces of elements, and the load on the body agree."""
    plan = one_body(stops())
    damped = replace(plan.bushings[0], damping_N_s_per_m=np.full(3, 4e4))
    frames = solvers.adapter("frames", solver).build(replace(plan, bushings=(damped,)))
    for index in range(2000):
        motion = frames.advance(Interval(index, 1e-3), Load(9e3 * ALONG[None]))
    expected_m = (9e3 + STOP_N_per_m * GAP_m) / (SPRING_N_per_m + STOP_N_per_m)
    assert motion.position_m[0, 0] == pytest.approx(expected_m, rel=1e-9)
    element_N = find_element_forces_N(frames)
    assert element_N is not None
    assert element_N[0, 0] == pytest.approx(STOP_N_per_m * (expected_m - GAP_m), rel=1e-8)
    if (loads := find_frame_loads(frames)) is not None:
        assert loads.bushing_N[0, 0] == pytest.approx(9e3, rel=1e-8)
        assert loads.acceleration_m_per_s2[0, 0] == pytest.approx(0, abs=1e-6)


@every_solver
def test_a_frame_drawn_at_rest_stands_beyond_the_gap(solver: str) -> None:
    """The weight of 7495 N compresses the spring by 5.75 mm, more than the gap: it stands at  k e + K (e - g)
    = m g, there it swings with the stiffness of both, and its energy is kept."""
    plan = one_body(stops(axis=2), gravity=True)
    frames = solvers.adapter("frames", solver).build(plan)
    for index in range(50):
        motion = frames.advance(Interval(index, 1e-3), Load.zero(1))
    assert motion.position_m == pytest.approx(np.zeros((1, 3)), abs=1e-14)
    push_N, before_J = 100.0, sum(frames.account().stored_J.values())
    for index in range(50, 250):
        motion = frames.advance(Interval(index, 1e-3), Load(push_N * UP[None]))
    speed = np.sqrt((SPRING_N_per_m + STOP_N_per_m) / MASS_kg)
    stretch_m = push_N / (SPRING_N_per_m + STOP_N_per_m)
    assert motion.position_m[0, 2] == pytest.approx(stretch_m * (1 - np.cos(speed * 0.2)), rel=0.02)
    account = frames.account()
    gained_J = sum(account.stored_J.values()) - before_J
    assert gained_J == pytest.approx(account.received_J["reaction"], rel=1e-9)


def test_a_characteristic_that_levels_off_is_refused_if_it_cannot_hold_the_weight() -> None:
    """Beyond 4 mm, 1.6 kN, the force does not grow."""
    law = CharacteristicPlan(
        2, SPRING_N_per_m, np.array([-1.0]), np.array([GAP_m]), np.array([-SPRING_N_per_m])
    )
    with pytest.raises(ValueError, match="preload"):
        solvers.adapter("frames", "two-mass").build(one_body(law, gravity=True))


def test_work_is_the_change_of_energy_on_any_path() -> None:
    springs = GapSprings(one_body(stops()), np.zeros((1, 3)))
    work_J = 0.0
    for step_m in np.random.default_rng(1).normal(0, 5e-3, 400):
        step = np.array([[step_m, 0.0, 0.0]])
        work_J += float(springs.mean_N(step)[0, 0] * step_m)
        springs.accept(step)
    assert work_J > 1
    assert springs.stored_J() == pytest.approx(work_J, rel=1e-10)
