"""prescribed against differences of its own path and simple cases known from elsewhere."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from adapters.frames.common.drive import angular_velocity, driving
from adapters.frames.prescribed import build
from orchestrator.ports import Array, Load
from orchestrator.ports.clock import Interval
from orchestrator.ports.plans import DrivePlan, FramesPlan
from tests.frames.machines import POINTS_M, exciter, two_bodies

DRIVE = DrivePlan(
    body="driven",
    center_m=np.array([0.1, 0.0, 0.2]),
    speed_rad_per_s=78.5,
    amplitude_m=np.array([8e-3, 0.0, 5e-3]),
    phase_rad=np.array([0.3, 0.0, 1.1]),
    rotation_rad=np.array([0.02, 0.4, -0.3]),
    rotation_phase_rad=np.array([0.0, 0.5, 1.9]),
    run_up_s=0.2,
)


def carried(drive: DrivePlan, points_m: Array, time_s: float) -> tuple[Array, Array]:
    """Position and velocity of points that a driven body carries."""
    return driving(drive, time_s).carried(points_m - drive.center_m)


def plan(*drives: DrivePlan) -> FramesPlan:
    return replace(two_bodies(drawn_at_rest=False), bushings=(), drives=drives)


@pytest.mark.parametrize("time_s", [0.03, 0.11, 0.19, 0.27])
def test_velocity_is_the_derivative_of_position(time_s: float) -> None:
    """Fourth-order differences with h = 2e-5 s: error (w h)^4 / 30 = 2e-13 of the speed, plus
    rounding 1e-16 / h = 5e-12 m/s."""
    h = 2e-5
    x = {k: carried(DRIVE, POINTS_M, time_s + k * h)[0] for k in (-2, -1, 1, 2)}
    difference = (8 * (x[1] - x[-1]) - (x[2] - x[-2])) / (12 * h)
    assert carried(DRIVE, POINTS_M, time_s)[1] == pytest.approx(difference, abs=5e-10)


@given(st.lists(st.floats(-3, 3), min_size=6, max_size=6))
def test_angular_velocity_is_that_of_the_rotation_matrix(values: list[float]) -> None:
    """omega x a = d(R a)/dt, by central differences (error about 1e-9)."""
    turn, rate = np.array(values[:3]), np.array(values[3:])
    h, arm = 1e-5, np.array([0.3, -0.7, 0.5])
    ahead, behind = (Rotation.from_rotvec(turn + k * rate).apply(arm) for k in (h, -h))
    turned = Rotation.from_rotvec(turn).apply(arm)
    expected = (ahead - behind) / (2 * h)
    assert np.cross(angular_velocity(turn, rate), turned) == pytest.approx(expected, abs=1e-7)


def test_angular_velocity_is_smooth_where_the_series_takes_over() -> None:
    rate, direction = np.array([1.0, -2.0, 0.5]), np.array([0.6, 0.0, 0.8])
    below, above = (angular_velocity(size * direction, rate) for size in (0.99999e-4, 1.00001e-4))
    assert below == pytest.approx(above, abs=1e-8)


def test_distances_within_a_body_stay() -> None:
    frames = build(plan(DRIVE))
    end = frames.advance(Interval(3, 0.07), Load.zero(4)).position_m
    assert np.linalg.norm(end[2] - end[3]) == pytest.approx(
        np.linalg.norm(POINTS_M[2] - POINTS_M[3]), rel=1e-14
    )
    assert np.array_equal(end[:2], POINTS_M[:2])  # the driving frame has no drive


def test_full_speed_is_the_harmonic_itself() -> None:
    still = np.zeros(3)
    drive = replace(DRIVE, rotation_rad=still, center_m=still)
    position_m, velocity_m_per_s = carried(drive, POINTS_M, 0.5)
    angle = 78.5 * 0.5 + drive.phase_rad
    assert position_m - POINTS_M == pytest.approx(
        np.tile(drive.amplitude_m * np.sin(angle), (4, 1)), abs=1e-15
    )
    assert velocity_m_per_s[0] == pytest.approx(78.5 * drive.amplitude_m * np.cos(angle), rel=1e-13)


def test_drives_supply_what_the_reaction_takes() -> None:
    frames = build(plan(DRIVE))
    start = frames.initial().position_m
    force = np.random.default_rng(2).normal(size=(4, 3))
    end = frames.advance(Interval(0, 0.3), Load(force)).position_m
    account = frames.account()
    assert account.received_J["reaction"] == pytest.approx(np.sum(force * (end - start)))
    assert account.supplied_J["drive"] == -account.received_J["reaction"]
    assert account.outside_impulse_N_s == pytest.approx(-0.3 * force.sum(axis=0))


@pytest.mark.parametrize(
    ("broken", "named"),
    [
        (replace(plan(DRIVE), exciters=(exciter(),)), r"\b1\b.*exciters"),
        (plan(DRIVE, DRIVE), "drive"),
        (plan(replace(DRIVE, body="drivne")), "drivne"),
        (replace(plan(DRIVE), carrier=("x",) * 4), "'x'"),
    ],
)
def test_plans_that_make_no_sense_are_refused(broken: FramesPlan, named: str) -> None:
    with pytest.raises(ValueError, match=named):
        build(broken)
