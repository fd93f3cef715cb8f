"""The shaft of an unbalance that a motor turns, in space: the equation of ``shaft.py`` about any
axis, in steps of the midpoint rule.

In a step the frame gets the mean of the unbalance's force,  -u (r'1 - r'0) / h,  so that its
impulse is what the unbalance's momentum lost, to rounding; r is the radial unit vector.  The step
is predicted with the acceleration of its place that the last two steps lead to, and accepted with
the one that the frame then had: second order, as the frames themselves.
"""

from __future__ import annotations

import math

import numpy as np

from adapters.frames.common import linear
from adapters.frames.common.motor import synchronous_rad_per_s, torque_N_m
from adapters.frames.common.poses import Attached, Poses
from orchestrator.ports import Array, Saved
from orchestrator.ports.plans import Exciter, FramesPlan, Motor, SolverFailed
from orchestrator.ports.state import put_back, taken

_STATE = (
    "angle_rad",
    "speed_rad_per_s",
    "wrench",
    "motor_J",
    "lost_J",
    "_given_1_s",
    "_felt_m_per_s2",
    "_felt_before_m_per_s2",
)
MOST_ROUNDS = 50
TOLERANCE = 1e-14


def shafts(plan: FramesPlan, drawn_m: Array) -> list[SpatialShaft]:
    """One for each exciter with a motor."""
    return [
        SpatialShaft(exciter, exciter.motor, plan, drawn_m)
        for exciter in plan.exciters
        if exciter.motor is not None
    ]


class SpatialShaft:
    """``angle_rad``, ``speed_rad_per_s`` at the last step's end; ``wrench`` (6,): force and moment
    about its ``body``'s centre of mass in the present step; ``motor_J``, ``lost_J`` since t = 0.

    Of each step ``turn``, then ``feel``.
    """

    def __init__(self, exciter: Exciter, motor: Motor, plan: FramesPlan, drawn_m: Array) -> None:
        self._exciter, self._motor, self._gravity_m_per_s2 = exciter, motor, plan.gravity_m_per_s2
        numbers = linear.numbers(plan, (exciter.body,))
        self.body = int(numbers[0])
        self._at = Attached.at(exciter.position_m[None], numbers, drawn_m)
        self._across = np.cross(exciter.axis, exciter.start)
        self.angle_rad, self.speed_rad_per_s = exciter.phase_rad, 0.0
        self.wrench: Array = np.zeros(6)
        self.motor_J = self.lost_J = 0.0
        self._given_1_s: Array = np.zeros(3)  # r' of which the frame got the force
        self._felt_m_per_s2: Array = np.zeros(3)  # mean over the last step
        self._felt_before_m_per_s2: Array = np.zeros(3)

    def turn(self, poses: Poses, end_s: float, step_s: float) -> Array:
        """The change of its wrench to that of the step from ``poses`` on."""
        expected_m_per_s2 = 2 * self._felt_m_per_s2 - self._felt_before_m_per_s2
        angle_rad, speed_rad_per_s = self._ahead(expected_m_per_s2, end_s, step_s)
        given_1_s = speed_rad_per_s * self._tangent(angle_rad)
        force_N = self._exciter.mass_moment_kg_m * (self._given_1_s - given_1_s) / step_s
        place_m, self._velocity_m_per_s = (rows[0] for rows in self._at.motion(poses))
        arm_m = place_m - poses.center_m[self.body]
        arm_m += step_s / 2 * (self._velocity_m_per_s - poses.velocity_m_per_s[self.body])
        before, self._given_1_s = self.wrench, given_1_s
        self.wrench = np.concatenate([force_N, np.cross(arm_m, force_N)])
        return self.wrench - before

    def feel(self, poses: Poses, end_s: float, step_s: float) -> None:
        """Accept the step to ``poses``."""
        gained_m_per_s = self._at.motion(poses)[1][0] - self._velocity_m_per_s
        self._felt_before_m_per_s2, self._felt_m_per_s2 = (self._felt_m_per_s2, gained_m_per_s / step_s)
        angle_rad, speed_rad_per_s = self._ahead(self._felt_m_per_s2, end_s, step_s)
        torque_N_m, turned_rad = self._torque_N_m(speed_rad_per_s, end_s, step_s), angle_rad
        turned_rad -= self.angle_rad
        self.motor_J += torque_N_m * turned_rad
        self.lost_J += self._motor.bearing_N_m_s * turned_rad**2 / step_s
        self.angle_rad, self.speed_rad_per_s = angle_rad, speed_rad_per_s

    def stored_J(self, poses: Poses) -> float:
        """As ``shaft.Shaft.stored_J``."""
        velocity_m_per_s = self._at.motion(poses)[1][0]
        moved_J = self.speed_rad_per_s * float(self._tangent(self.angle_rad) @ velocity_m_per_s)
        risen = self._radial(self.angle_rad) - self._radial(self._exciter.phase_rad)
        own_J = self._motor.inertia_kg_m2 * self.speed_rad_per_s**2 / 2
        size = self._exciter.mass_moment_kg_m
        return own_J + size * (moved_J - float(risen @ self._gravity_m_per_s2))

    def save(self) -> Saved:
        return taken(self, *_STATE)

    def restore(self, saved: Saved) -> None:
        put_back(self, saved, *_STATE)

    def _ahead(self, felt_m_per_s2: Array, end_s: float, step_s: float) -> tuple[float, float]:
        """Angle and speed at the step's end, where its place has this mean acceleration."""
        if end_s - step_s < self._exciter.start_s - 1e-9 * step_s:  # until then a brake holds it
            return self.angle_rad, 0.0
        motor, speed = self._motor, self.speed_rad_per_s
        for _ in range(MOST_ROUNDS):
            mean = (self.speed_rad_per_s + speed) / 2
            tangent = self._tangent(self.angle_rad + step_s / 2 * mean)
            swung_N_m = self._exciter.mass_moment_kg_m * tangent @ (felt_m_per_s2 - self._gravity_m_per_s2)
            torque_N_m = self._torque_N_m(speed, end_s, step_s) - motor.bearing_N_m_s * mean
            growth_rad_per_s2 = (torque_N_m - float(swung_N_m)) / motor.inertia_kg_m2
            before, speed = speed, self.speed_rad_per_s + step_s * growth_rad_per_s2
            if abs(speed - before) <= TOLERANCE * motor.synchronous_rad_per_s:
                return self.angle_rad + step_s * (self.speed_rad_per_s + speed) / 2, speed
        raise SolverFailed(
            f"exudyn frames at {end_s} s: a motor's step does not settle; take a smaller frames.step_s"
        )

    def _torque_N_m(self, speed_rad_per_s: float, end_s: float, step_s: float) -> float:
        """Mean over a step that ends at this speed."""
        ends = np.array([end_s - step_s, end_s])
        synchronous = synchronous_rad_per_s(self._exciter, self._motor, ends)
        lag_rad_per_s = synchronous - np.array([self.speed_rad_per_s, speed_rad_per_s])
        return float(torque_N_m(self._motor, lag_rad_per_s).mean())

    def _radial(self, angle_rad: float) -> Array:
        cosine, sine = math.cos(angle_rad), math.sin(angle_rad)
        return np.asarray(cosine * self._exciter.start + sine * self._across)

    def _tangent(self, angle_rad: float) -> Array:
        cosine, sine = math.cos(angle_rad), math.sin(angle_rad)
        return np.asarray(cosine * self._across - sine * self._exciter.start)
