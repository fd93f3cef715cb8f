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

    ((shift_m, turn_rad),), ((shift_m_per_s, turn_rad_per_s),) = coordinates(drive, np.array([time_s]))
    return Driving(
        drive.center_m + shift_m,
        shift_m_per_s,
        Rotation.from_rotvec(turn_rad),
        angular_velocity(turn_rad, turn_rad_per_s),
    )


def drawn_pose(plan: FramesPlan) -> Pose:
    """Return the pose of a plan's bodies as they are drawn, at rest."""
    bodies = len(plan.bodies)
    position_m = np.array([body.center_of_mass_m for body in plan.bodies]).reshape(-1, 3)
    return Pose(position_m, np.tile(np.eye(3), (bodies, 1, 1)), *np.zeros((2, bodies, 3)))


class DrivenBodies:
    """The bodies and carried points of a plan, moved by its drives; all others stay where they were drawn."""

    def __init__(self, plan: FramesPlan) -> None:
        self._plan, self._points_m, carrier = plan, plan.points_m, np.array(plan.carrier, dtype=str)
        self._carried = [np.flatnonzero(carrier == drive.body) for drive in plan.drives]
        self.still_or_driven = np.isin(carrier, ["ground", *(d.body for d in plan.drives)])
        # an interval's end is looked at ahead, and then reached
        self._drivings = lru_cache(maxsize=1)(lambda time_s: [driving(row, time_s) for row in plan.drives])
        self.points = lru_cache(maxsize=1)(self._points)

    def _points(self, time_s: float) -> Motion:
        """Return the exact motion of all points."""
        position_m = self._points_m.copy()
        velocity_m_per_s = np.zeros_like(position_m)
        for drive, now, points in zip(self._plan.drives, self._drivings(time_s), self._carried, strict=True):
            arm_m = self._points_m[points] - drive.center_m
            position_m[points], velocity_m_per_s[points] = now.carried(arm_m)
        return Motion(position_m, velocity_m_per_s)

    def pose(self, time_s: float) -> Pose:
        """Return the exact pose of all bodies."""
        pose = drawn_pose(self._plan)
        for number, drive, now in zip(
            driven(self._plan), self._plan.drives, self._drivings(time_s), strict=True
        ):
            arm_m = pose.position_m[number] - drive.center_m
            pose.position_m[number], pose.velocity_m_per_s[number] = now.carried(arm_m)
            pose.rotation[number], pose.spin_rad_per_s[number] = now.rotation.as_matrix(), now.spin_rad_per_s
        return pose

    def ahead(self, interval: Interval) -> Known | None:
        """Return the motion at the interval's end of the points on driven bodies and on the ground.

        The result is None without drives.
        """
        if not self._carried:
            return None
        return Known(self.points(interval.end_s), self.still_or_driven)


def coordinates(drive: DrivePlan, time_s: Array) -> tuple[Array, Array]:
    """Return displacement of the centre and rotation vector (n, 2, 3) at the times (n,), and their rates."""
    size = np.array([drive.amplitude_m, drive.rotation_rad])
    time_s = time_s[:, None, None]
    angle = drive.speed_rad_per_s * time_s + np.array([drive.phase_rad, drive.rotation_phase_rad])
    ramp, ramp_1_s = run_up(time_s, drive.run_up_s)
    sine = np.sin(angle)
    value = ramp * size * sine
    rate = size * (ramp_1_s * sine + ramp * drive.speed_rad_per_s * np.cos(angle))
    return value, rate


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
