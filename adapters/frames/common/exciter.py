"""Rotating unbalances: the force of an unbalance that runs up smoothly, and the shaft that a motor turns.

A shaft's equation of motion is

    J w' = torque - bearing w - u t . (a - g),    t = d(radial)/d(angle)

with the acceleration a of the shaft's place and the unbalance's mass moment u.  The frame gets the force of
any unbalance, -u d2(radial)/dt2.  The motor stands on the ground and passes on torque only, as by a cardan
shaft: its reaction goes into the ground.
"""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np

from orchestrator.ports import Array
from orchestrator.ports.physics import motor_torque_N_m
from orchestrator.ports.plans import ExciterPlan, FramesPlan, MotorPlan
from orchestrator.ports.state import SavedAttributes


class Unbalance:
    """A rotating unbalance, which shakes its body with its inertia force.

    With angle phi, the force is  mass_moment (phi'^2 radial - phi'' tangent), which is minus the second time
    derivative of  mass_moment * radial.
    """

    def __init__(self, exciter: ExciterPlan) -> None:
        self._exciter, self._across = exciter, np.cross(exciter.axis, exciter.start)

    def force_N(self, time_s: Array) -> Array:
        """Return the force in the world (n, 3) at the times (n,), at the exciter's given speed."""
        return self.inertia_force_N(*self._turning(time_s))

    def inertia_force_N(self, angle_rad: Array, speed_rad_per_s: Array, growth_rad_per_s2: Array) -> Array:
        """Return the force in the world (n, 3) at these angles, speeds and angular accelerations, (n,)."""
        push = speed_rad_per_s[:, None] ** 2 * self.radial(angle_rad)
        push -= growth_rad_per_s2[:, None] * self.tangent(angle_rad)
        return self._exciter.mass_moment_kg_m * push

    def radial(self, angle_rad: Array | float) -> Array:
        """Return the unit vectors (..., 3) from the shaft to the unbalance."""
        return self._turned(np.cos(angle_rad), np.sin(angle_rad))

    def tangent(self, angle_rad: Array | float) -> Array:
        """Return the derivatives (..., 3) of ``radial`` with respect to the angle."""
        return self._turned(-np.sin(angle_rad), np.cos(angle_rad))

    def _turned(self, along: Array | float, across: Array | float) -> Array:
        exciter = self._exciter
        return np.asarray(np.multiply.outer(along, exciter.start) + np.multiply.outer(across, self._across))

    def _turning(self, time_s: Array) -> tuple[Array, Array, Array]:
        """Return angle in rad, speed in rad/s and angular acceleration in rad/s^2 at rising times (n,)."""
        exciter = self._exciter
        if time_s[-1] <= exciter.stop_s:
            return self._running_up(time_s)
        angle, speed, growth = self._running_up(np.minimum(time_s, exciter.stop_s))
        full, run_down_s, stops = exciter.speed_rad_per_s, exciter.run_down_s, time_s > exciter.stop_s
        if run_down_s <= 0:
            return angle, np.where(stops, 0.0, speed), np.where(stops, 0.0, growth)
        rate, falling_s = math.pi / run_down_s, np.clip(time_s - exciter.stop_s, 0.0, run_down_s)
        angle = angle + full / 2 * (falling_s + np.sin(rate * falling_s) / rate)
        speed = np.where(stops, full / 2 * (1 + np.cos(rate * falling_s)), speed)
        growth = np.where(stops, -full / 2 * rate * np.sin(rate * falling_s), growth)
        return angle, speed, growth

    def _running_up(self, time_s: Array) -> tuple[Array, Array, Array]:
        """Return the same of an exciter that never stops."""
        full, run_up_s = self._exciter.speed_rad_per_s, self._exciter.run_up_s
        phase, since_s = self._exciter.phase_rad, time_s - self._exciter.start_s
        if since_s[0] >= run_up_s:  # full speed
            still = np.zeros_like(since_s)
            return full * (since_s - run_up_s / 2) + phase, full + still, still
        turns, since_s = since_s >= 0, np.maximum(since_s, 0.0)
        if run_up_s <= 0:
            return full * since_s + phase, full * turns, np.zeros_like(since_s)
        rate = math.pi / run_up_s
        rising = np.minimum(since_s, run_up_s)
        angle = full / 2 * (rising - np.sin(rate * rising) / rate) + full * (since_s - rising)
        speed = full / 2 * (1 - np.cos(rate * rising))
        growth = np.where(since_s < run_up_s, full / 2 * rate * np.sin(rate * rising), 0.0)
        return angle + phase, speed, growth


class Shaft(SavedAttributes, Unbalance):
    """The angle and speed of a motor's shaft at the last step's end, and its energies since t = 0.

    ``name`` is that of the exciter.  ``motor_J`` is the motor's work and ``lost_J`` the loss in the bearings.
    """

    STATE: ClassVar[tuple[str, ...]] = ("angle_rad", "speed_rad_per_s", "motor_J", "lost_J")

    def __init__(self, exciter: ExciterPlan, motor: MotorPlan, plan: FramesPlan) -> None:
        super().__init__(exciter)
        self._motor, self._gravity_m_per_s2 = motor, plan.gravity_m_per_s2
        self.name = exciter.name
        self.angle_rad, self.speed_rad_per_s = exciter.phase_rad, 0.0
        self.motor_J = self.lost_J = 0.0

    def torque_N_m(self, speed_rad_per_s: Array, time_s: Array) -> Array:
        """Return the motor's torque (n,) on a shaft at these speeds and times, (n,) each.

        The synchronous speed runs up and down as an exciter's does, at constant voltage over frequency.
        """
        exciter = self._exciter
        risen = _share(time_s - exciter.start_s, exciter.run_up_s)
        fallen = _share(time_s - exciter.stop_s, exciter.run_down_s)
        up, down = (1 - np.cos(np.pi * risen)) / 2, (1 + np.cos(np.pi * fallen)) / 2
        synchronous_rad_per_s = self._motor.synchronous_rad_per_s * up * down
        return motor_torque_N_m(self._motor, synchronous_rad_per_s - speed_rad_per_s)

    def growth_rad_per_s2(
        self, angle_rad: Array, speed_rad_per_s: Array, torque_N_m: Array, felt_m_per_s2: Array
    ) -> Array:
        """Return the angular acceleration (n,) where the shaft's place is accelerated by
        ``felt_m_per_s2`` (n, 3)."""
        pull_m_per_s2 = np.sum(self.tangent(angle_rad) * (felt_m_per_s2 - self._gravity_m_per_s2), axis=-1)
        swung_N_m = self._exciter.mass_moment_kg_m * pull_m_per_s2
        drag_N_m = self._motor.bearing_N_m_s * speed_rad_per_s
        return np.asarray((torque_N_m - drag_N_m - swung_N_m) / self._motor.inertia_kg_m2)

    def stored_J(self, velocity_m_per_s: Array) -> float:
        """Return the energy of shaft and unbalance beyond the energy that the body has with the unbalance's
        mass.

        It is zero at rest at t = 0.  ``velocity_m_per_s`` (3,) is the velocity of the shaft's place.
        """
        moved_J = self.speed_rad_per_s * float(self.tangent(self.angle_rad) @ velocity_m_per_s)
        risen = self.radial(self.angle_rad) - self.radial(self._exciter.phase_rad)
        own_J = self._motor.inertia_kg_m2 * self.speed_rad_per_s**2 / 2
        return own_J + self._exciter.mass_moment_kg_m * (moved_J - float(risen @ self._gravity_m_per_s2))


def _share(since_s: Array, lasting_s: float) -> Array:
    """Return the share of a time that has passed, from 0 to 1; of no time, all of it at once."""
    if lasting_s > 0:
        return np.asarray(np.clip(since_s / lasting_s, 0.0, 1.0))
    return np.asarray(since_s >= 0, dtype=np.float64)
