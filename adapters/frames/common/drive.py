"""Drives: the exact place and velocity that a drive gives its body at a time.

Equations: docs/theory/frames.md.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from orchestrator.ports import Array, Known, Motion, Pose
from orchestrator.ports.clock import Interval
from orchestrator.ports.linear_frames import driven, skew
from orchestrator.ports.plans import DrivePlan, FramesPlan
from orchestrator.ports.unbalance import run_up

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation


@dataclass(frozen=True)
class Driving:
    """The motion of a drive at one time.

    It has the place and velocity (3,) of the drive's centre, the rotation from the drawn position, and the
    angular velocity (3,) in the world.
    """

    center_m: Array
    velocity_m_per_s: Array
    rotation: Rotation
    spin_rad_per_s: Array

    def carried(self, arm_m: Array) -> tuple[Array, Array]:
        """Return position and velocity of points ``arm_m`` (n, 3) away from the centre as drawn."""
        arm_m = self.rotation.apply(arm_m)
        return self.center_m + arm_m, self.velocity_m_per_s + arm_m @ skew(self.spin_rad_per_s).T


def driving(drive: DrivePlan, time_s: float) -> Driving:
    """Return the motion that the drive prescribes."""
    from scipy.spatial.transform import Rotation

    when_s = np.array([time_s])
    shift_m, shift_m_per_s = displacement(drive, when_s)
    turn_rad, turn_rad_per_s = rotation(drive, when_s)
    return Driving(
        drive.center_m + shift_m[0],
        shift_m_per_s[0],
        Rotation.from_rotvec(turn_rad[0]),
        angular_velocity(turn_rad[0], turn_rad_per_s[0]),
    )


def carried_motion(drive: DrivePlan, points_m: Array, time_s: float) -> tuple[Array, Array]:
    """Return position and velocity, (n, 3) each, of points that a driven body carries."""
    return driving(drive, time_s).carried(points_m - drive.center_m)


def driven_pose(plan: FramesPlan, time_s: float) -> Pose:
    """Return the exact pose of a plan's bodies at a time; bodies without a drive stand as they were drawn."""
    pose = drawn_pose(plan)
    for number, drive in zip(driven(plan), plan.drives, strict=True):
        now = driving(drive, time_s)
        pose.position_m[number], pose.velocity_m_per_s[number] = now.carried(
            pose.position_m[number] - drive.center_m
        )
        pose.rotation[number], pose.spin_rad_per_s[number] = now.rotation.as_matrix(), now.spin_rad_per_s
    return pose


def drawn_pose(plan: FramesPlan) -> Pose:
    """Return the pose of a plan's bodies as they are drawn, at rest."""
    bodies = len(plan.bodies)
    position_m = np.array([body.center_of_mass_m for body in plan.bodies]).reshape(-1, 3)
    return Pose(position_m, np.tile(np.eye(3), (bodies, 1, 1)), *np.zeros((2, bodies, 3)))


class DrivenPoints:
    """The carried points of a plan, moved by its drives; all other points stay where they were drawn."""

    def __init__(self, plan: FramesPlan) -> None:
        self._points_m, carrier = plan.points_m, np.array(plan.carrier, dtype=str)
        self._driven = [(drive, np.flatnonzero(carrier == drive.body)) for drive in plan.drives]
        self.still_or_driven = np.isin(carrier, ["ground", *(d.body for d in plan.drives)])
        self.at = lru_cache(maxsize=1)(self._at)  # an interval's end is looked at ahead, and then reached

    def _at(self, time_s: float) -> Motion:
        """Return the exact motion of all points."""
        position_m = self._points_m.copy()
        velocity_m_per_s = np.zeros_like(position_m)
        for drive, points in self._driven:
            position_m[points], velocity_m_per_s[points] = carried_motion(
                drive, self._points_m[points], time_s
            )
        return Motion(position_m, velocity_m_per_s)

    def ahead(self, interval: Interval) -> Known | None:
        """Return the motion at the interval's end of the points on driven bodies and on the ground.

        The result is None without drives.
        """
        if not self._driven:
            return None
        return Known(self.at(interval.end_s), self.still_or_driven)


def displacement(drive: DrivePlan, time_s: Array) -> tuple[Array, Array]:
    """Return displacement of the centre and its rate, (n, 3) each, at the times (n,)."""
    return _harmonic(drive, drive.amplitude_m, drive.phase_rad, time_s)


def rotation(drive: DrivePlan, time_s: Array) -> tuple[Array, Array]:
    """Return the rotation vector and its rate, (n, 3) each, at the times (n,)."""
    return _harmonic(drive, drive.rotation_rad, drive.rotation_phase_rad, time_s)


def angular_velocity(turn_rad: Array, rate_rad_per_s: Array) -> Array:
    """Return the world angular velocity (3,) of a body turned by a rotation vector.

    The vector ``turn_rad`` changes at ``rate_rad_per_s``; the result is the left Jacobian of the exponential
    map times the rate (Chirikjian, Stochastic Models, Information Theory, and Lie Groups, vol. 2, 2012, ch.
    10).
    """
    square = float(turn_rad @ turn_rad)
    angle = math.sqrt(square)
    if angle < 1e-4:  # series: the closed forms cancel; next terms are below rounding
        one_minus_cos, one_minus_sinc = 0.5 - square / 24, 1 / 6 - square / 120
    else:
        one_minus_cos = 2 * math.sin(angle / 2) ** 2 / square
        one_minus_sinc = (1 - math.sin(angle) / angle) / square
    turn = skew(turn_rad)
    across = turn @ rate_rad_per_s
    return np.asarray(rate_rad_per_s + one_minus_cos * across + one_minus_sinc * (turn @ across))


def _harmonic(drive: DrivePlan, size: Array, phase_rad: Array, time_s: Array) -> tuple[Array, Array]:
    """Return value and rate, (n, 3) each, of  ramp(t) * size * sin(w t + phase)."""
    ramp, ramp_1_s = (one[:, None] for one in run_up(time_s, drive.run_up_s))
    angle = drive.speed_rad_per_s * time_s[:, None] + phase_rad
    value = ramp * size * np.sin(angle)
    rate = size * (ramp_1_s * np.sin(angle) + ramp * drive.speed_rad_per_s * np.cos(angle))
    return value, rate
