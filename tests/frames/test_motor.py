"""An unbalance that a motor turns: steady slip, capture at a resonance, books.

One body on isotropic springs, without weight: its circular steady motion loads the shaft evenly,
with the torque  P / w,  P = c w^2 |X|^2  lost in the dampers and |X| = u w^2 / |k - M w^2 + i c w|.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from importlib import import_module
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from orchestrator.case import solvers
from orchestrator.ports import Array, Frames, Load
from orchestrator.ports.clock import Interval
from orchestrator.ports.physics import motor_torque_N_m
from orchestrator.ports.plans import FramesPlan, MotorPlan
from tests.frames.contract import INTERVAL_S, accounts, defect_J, loads
from tests.frames.machines import UP, body, bushing, exciter, two_bodies
from tests.reference import planar

STIFFNESS_N_per_m, MASS_kg, MOMENT_kg_m = 4 * 225e3, 764.0, 3.5
DAMPING_N_s_per_m = 0.2 * STIFFNESS_N_per_m / 34.3
MOTOR = MotorPlan(
    rated_power_W=11e3,
    synchronous_rad_per_s=80.0,
    rated_slip=0.04,
    breakdown_ratio=2.5,
    inertia_kg_m2=1.5,
    bearing_N_m_s=0.05,
)


def one_body(motor: MotorPlan, interval_s: float = 5e-3) -> FramesPlan:
    """Its resonance is at 34.3 rad/s."""
    places = [np.array([x, y, 0.0]) for x in (-0.9, 0.9) for y in (-0.4, 0.4)]
    springs = [bushing(("ground", "driving"), p, (225e3,) * 3) for p in places]
    damping = np.full(3, DAMPING_N_s_per_m / 4)
    turned = replace(exciter(80.0), motor=motor)
    return replace(
        two_bodies((turned,), interval_s=interval_s),
        bodies=(body("driving", MASS_kg),),
        bushings=tuple(replace(spring, damping_N_s_per_m=damping) for spring in springs),
        gravity_m_per_s2=np.zeros(3),
        points_m=np.zeros((1, 3)),
        carrier=("driving",),
        reaction_N=np.zeros((1, 3)),
    )


def surplus_N_m(motor: MotorPlan, speed: Array | float) -> Array:
    """Torque of the motor less what bearing and dampers take at a steady speed."""
    w = np.asarray(speed)
    dynamic = STIFFNESS_N_per_m - MASS_kg * w**2 + 1j * DAMPING_N_s_per_m * w
    amplitude_m = MOMENT_kg_m * w**2 / np.abs(dynamic)
    taken = motor.bearing_N_m_s * w + DAMPING_N_s_per_m * w * amplitude_m**2
    return np.asarray(motor_torque_N_m(motor, motor.synchronous_rad_per_s - w) - taken)


def steady_speeds(motor: MotorPlan) -> list[float]:
    """Return the speeds where the surplus changes its sign, from low to high."""
    tried = np.linspace(1.0, motor.synchronous_rad_per_s, 4000)
    signs = np.sign(surplus_N_m(motor, tried))
    crossings = np.flatnonzero(np.diff(signs))
    return [brentq(lambda w: float(surplus_N_m(motor, w)), *tried[n : n + 2]) for n in crossings]


def run(frames: Any, plan: FramesPlan, count: int) -> float:
    for index in range(count):
        frames.advance(Interval(index, plan.sync_interval_s), Load.zero(len(plan.points_m)))
    return float(frames.save()["shafts"]["0"]["speed_rad_per_s"])


Build = Callable[[FramesPlan], Any]


@pytest.fixture(params=["planar", pytest.param("exudyn", marks=pytest.mark.solver)])
def build(request: pytest.FixtureRequest) -> Build:
    """Exudyn in steps of a tenth of a radian, twice its own."""
    step_s = {"planar": 0.0, "exudyn": 1.25e-3}[request.param]
    solver = solvers.adapter("frames", request.param)
    return lambda plan: solver.build(replace(plan, step_s=step_s))


def test_torque_by_hand() -> None:
    """The rating at the rated slip, and the breakdown torque at the top."""
    rated_N_m = 11e3 / (80.0 * 0.96)
    assert motor_torque_N_m(MOTOR, np.array(3.2)) == pytest.approx(rated_N_m, rel=1e-14)
    top = motor_torque_N_m(MOTOR, np.linspace(0.0, 80.0, 100001)).max()
    assert top == pytest.approx(2.5 * rated_N_m, rel=1e-8)
    assert motor_torque_N_m(MOTOR, np.array(0.0)) == 0.0


def test_the_steady_speed_balances_the_torques(build: Build) -> None:
    """A strong motor passes the resonance; then the swinging of the start dies out as e^-8."""
    (expected,) = steady_speeds(MOTOR)
    assert 76.0 < expected < 80.0
    plan = one_body(MOTOR)
    frames = build(plan)
    assert run(frames, plan, 600) == pytest.approx(expected, rel=1e-4)
    (before_rad,) = frames.shaft_angles_rad().values()
    frames.advance(Interval(600, plan.sync_interval_s), Load.zero(1))
    (angle_rad,) = frames.shaft_angles_rad().values()
    assert angle_rad - before_rad == pytest.approx(expected * plan.sync_interval_s, rel=1e-4)


def test_a_weak_motor_is_caught_at_the_resonance(build: Build) -> None:
    """Sommerfeld's effect: the dampers take more power at the resonance than the motor has (I. I.
    Blekhman, Vibrational Mechanics, 2000; V. O. Kononenko, Vibrating Systems with a Limited Power
    Supply, 1969).  Of the three speeds at which the torques balance, the lowest and the highest
    are stable, and a start from rest ends at the lowest, below the resonance of 34.3 rad/s; after
    7 s it still swings about it by 5e-4."""
    weak = replace(MOTOR, rated_power_W=4e3)
    speeds = steady_speeds(weak)
    assert len(speeds) == 3
    assert speeds[0] < 34.3 < speeds[1]
    plan = one_body(weak)
    assert run(build(plan), plan, 1440) == pytest.approx(speeds[0], rel=1e-3)


@pytest.mark.solver
def test_a_shaft_about_any_axis() -> None:
    """Upright, on springs that are alike in all directions."""
    spatial = import_module("adapters.frames.exudyn")
    (expected,) = steady_speeds(MOTOR)
    upright = exciter(80.0, axis=UP, start=np.array([1.0, 0.0, 0.0]))
    plan = replace(one_body(MOTOR), exciters=(replace(upright, motor=MOTOR),))
    assert run(spatial.build(plan), plan, 600) == pytest.approx(expected, rel=1e-4)


def test_what_the_motor_gives_the_dampers_and_bearings_take(build: Build) -> None:
    """The balance holds in the steady state, to the rest of the start's swinging."""
    plan = one_body(MOTOR)
    frames = build(plan)
    run(frames, plan, 600)
    before = frames.account()
    for index in range(600, 620):
        frames.advance(Interval(index, plan.sync_interval_s), Load.zero(1))
    after = frames.account()
    given_J = after.supplied_J["motor"] - before.supplied_J["motor"]
    lost_J = sum(after.lost_J.values()) - sum(before.lost_J.values())
    assert given_J == pytest.approx(lost_J, rel=1e-3)


def off_centre() -> FramesPlan:
    """Two bodies with weight, and the unbalance off the centre; it runs up in 0.1 s."""
    turned = exciter(80.0, 0.1, position_m=np.array([0.05, 0.0, 0.226]), start_s=0.01)
    return two_bodies((replace(turned, motor=MOTOR),), interval_s=INTERVAL_S)


@pytest.mark.solver
def test_spatial_frames_come_to_planar_ones_with_the_square_of_the_step() -> None:
    """Places after 0.2 s of run-up, in steps of 1/4 and 1/8 ms, and what the books miss; measured
    4.6e-8 m and 2e-5 of 478 J in the coarser ones."""
    spatial, plan = import_module("adapters.frames.exudyn"), off_centre()
    places_m, defects_J = [], []
    for solver, step_s in ((planar, 0.0), (spatial, 2.5e-4), (spatial, 1.25e-4)):
        frames = solver.build(replace(plan, step_s=step_s))
        before = frames.account()
        run(frames, plan, 400)
        defects_J.append(abs(defect_J(before, frames.account())))
        places_m.append(frames.advance(Interval(400, INTERVAL_S), Load.zero(4)).position_m)
    coarse_m, fine_m = (np.abs(place_m - places_m[0]).max() for place_m in places_m[1:])
    assert coarse_m / fine_m == pytest.approx(4.0, rel=0.05)
    assert fine_m < 2e-8
    assert defects_J[1] / defects_J[2] == pytest.approx(4.0, rel=0.05)


def test_energy_closes_to_rounding() -> None:
    frames: Frames = planar.build(off_centre())
    books = accounts(frames, loads(600))
    end = books[-1]
    assert end.supplied_J["motor"] > 100.0
    assert abs(defect_J(books[0], end)) < 1e-10 * end.supplied_J["motor"]


def test_a_restored_shaft_goes_on_bit_for_bit(build: Build) -> None:
    plan = off_centre()
    whole, first, second = (build(plan) for _ in range(3))
    for index in range(200):
        for frames in (whole, first):
            frames.advance(Interval(index, INTERVAL_S), Load.zero(4))
    second.restore(first.save())
    for index in range(200, 300):
        motions = [solver.advance(Interval(index, INTERVAL_S), Load.zero(4)) for solver in (whole, second)]
        assert np.array_equal(motions[0].position_m, motions[1].position_m)


def test_a_shaft_that_is_not_across_is_refused() -> None:
    upright = replace(exciter(axis=UP, start=np.array([1.0, 0.0, 0.0])), motor=MOTOR)
    with pytest.raises(ValueError, match="across"):
        planar.build(two_bodies((upright,)))
