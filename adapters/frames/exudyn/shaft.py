"""Shafts that motors turn, about any axis, on bodies in space."""

from __future__ import annotations

import numpy as np

from adapters.frames.common.exciter import Shaft
from adapters.frames.exudyn.poses import Attached, Poses
from orchestrator.ports import Array, linear_frames
from orchestrator.ports.physics import motor_torque_N_m
from orchestrator.ports.plans import ExciterPlan, FramesPlan, MotorPlan, SolverFailed

MOST_ROUNDS = 50
TOLERANCE = 1e-14
"""The largest error of a shaft's step, as a share of its synchronous speed."""


class SpatialShaft(Shaft):
    """A shaft about any axis, in steps of the midpoint rule.

    In a step the frame gets the mean of the unbalance's force,  -u (r'1 - r'0) / h,  with the radial unit
    vector r, so that its impulse is the momentum lost by the unbalance, to rounding.  The step is predicted
    with the acceleration of the shaft's place, extrapolated from the last two steps, and accepted with the
    acceleration that the frame then had.  It is of second order, like the frames' own steps.

    ``wrench`` (6,) is the force and the moment about the centre of mass of body number ``body`` in the
    present step.  In each step ``turn`` is called first, then ``feel``.
    """

    STATE = (*Shaft.STATE, "wrench", "_given_1_s", "_felt_m_per_s2", "_felt_before_m_per_s2")

    def __init__(self, exciter: ExciterPlan, motor: MotorPlan, plan: FramesPlan, drawn_m: Array) -> None:
        super().__init__(exciter, motor, plan)
        numbers = linear_frames.numbers(plan, (exciter.body,))
        self.body = int(numbers[0])
        self._at = Attached.at(exciter.position_m[None], numbers, drawn_m)
        self.wrench: Array = np.zeros(6)
        self._given_1_s: Array = np.zeros(3)  # r' whose force the frame got
        self._felt_m_per_s2: Array = np.zeros(3)  # the mean over the last step
        self._felt_before_m_per_s2: Array = np.zeros(3)

    def velocity_m_per_s(self, poses: Poses) -> Array:
        """Return the velocity (3,) of the shaft's place."""
        return np.asarray(self._at.motion(poses)[1][0])

    def place_m(self, poses: Poses) -> Array:
        """Return the place (3,) of the shaft."""
        return np.asarray(self._at.motion(poses)[0][0])

    def turn(self, poses: Poses, end_s: float, step_s: float) -> Array:
        """Turn the shaft in the step from ``poses`` on, and return the change (6,) of the wrench."""
        expected_m_per_s2 = 2 * self._felt_m_per_s2 - self._felt_before_m_per_s2
        angle_rad, speed_rad_per_s = self._ahead(expected_m_per_s2, end_s, step_s)
        given_1_s = speed_rad_per_s * self.tangent(angle_rad)
        force_N = self._exciter.mass_moment_kg_m * (self._given_1_s - given_1_s) / step_s
        place_m, self._velocity_m_per_s = (rows[0] for rows in self._at.motion(poses))
        arm_m = place_m - poses.center_m[self.body]
        arm_m += step_s / 2 * (self._velocity_m_per_s - poses.velocity_m_per_s[self.body])
        before, self._given_1_s = self.wrench, given_1_s
        self.wrench = np.concatenate([force_N, np.cross(arm_m, force_N)])
        return self.wrench - before

    def feel(self, poses: Poses, end_s: float, step_s: float) -> None:
        """Accept the step to ``poses``, with the acceleration that the frame had in it."""
        gained_m_per_s = self.velocity_m_per_s(poses) - self._velocity_m_per_s
        self._felt_before_m_per_s2, self._felt_m_per_s2 = self._felt_m_per_s2, gained_m_per_s / step_s
        angle_rad, speed_rad_per_s = self._ahead(self._felt_m_per_s2, end_s, step_s)
        turned_rad = angle_rad - self.angle_rad
        torque_N_m = self._mean_torque_N_m(speed_rad_per_s, self._synchronous(end_s, step_s))
        self.motor_J += torque_N_m * turned_rad
        self.lost_J += self._motor.bearing_N_m_s * turned_rad**2 / step_s
        self.angle_rad, self.speed_rad_per_s = angle_rad, speed_rad_per_s

    def _ahead(self, felt_m_per_s2: Array, end_s: float, step_s: float) -> tuple[float, float]:
        """Return angle and speed at the step's end, for this mean acceleration of the shaft's place."""
        if end_s - step_s < self._exciter.start_s - 1e-9 * step_s:  # until then a brake holds the shaft
            return self.angle_rad, 0.0
        speed, synchronous_rad_per_s = self.speed_rad_per_s, self._synchronous(end_s, step_s)
        for _ in range(MOST_ROUNDS):
            mean = np.array((self.speed_rad_per_s + speed) / 2)
            torque_N_m = self._mean_torque_N_m(speed, synchronous_rad_per_s)
            growth = self.growth_rad_per_s2(
                self.angle_rad + step_s / 2 * mean, mean, np.array(torque_N_m), felt_m_per_s2
            )
            before, speed = speed, self.speed_rad_per_s + step_s * float(growth)
            if abs(speed - before) <= TOLERANCE * self._motor.synchronous_rad_per_s:
                return self.angle_rad + step_s * (self.speed_rad_per_s + speed) / 2, speed
        raise SolverFailed(
            f"exudyn frames at {end_s} s: a motor's step does not settle; take a smaller frames.step_s"
        )

    def _synchronous(self, end_s: float, step_s: float) -> Array:
        """Return the synchronous speeds (2,) at the start and the end of a step."""
        return self.synchronous_rad_per_s(np.array([end_s - step_s, end_s]))

    def _mean_torque_N_m(self, speed_rad_per_s: float, synchronous_rad_per_s: Array) -> float:
        """Return the mean of the torque over a step that ends at this speed."""
        lags_rad_per_s = synchronous_rad_per_s - (self.speed_rad_per_s, speed_rad_per_s)
        return float(motor_torque_N_m(self._motor, lags_rad_per_s).sum() / 2)
