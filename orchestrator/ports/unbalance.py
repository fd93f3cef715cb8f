"""Rotating unbalances at their given speeds, and the smooth way in which machines run up."""

from __future__ import annotations

import math

import numpy as np

from orchestrator.ports import Array
from orchestrator.ports.plans import ExciterPlan


def run_up(since_s: Array, lasting_s: float) -> tuple[Array, Array]:
    """Return value and rate of  (1 - cos(pi t / T)) / 2  at times of any shape since the start.

    It is 0 before the start and 1 after the time T, ``lasting_s``; where that is 0, it jumps.
    """
    if lasting_s <= 0:
        return np.asarray(since_s >= 0, dtype=np.float64), np.zeros_like(since_s)
    angle = np.pi * np.minimum(np.maximum(since_s / lasting_s, 0.0), 1.0)  # np.clip takes longer
    rate = np.where(since_s < lasting_s, np.pi / (2 * lasting_s) * np.sin(angle), 0.0)
    return (1 - np.cos(angle)) / 2, rate


class Unbalance:
    """A rotating unbalance, which shakes its body with its inertia force.

    With angle phi, the force is  mass_moment (phi'^2 radial - phi'' tangent), which is minus the second time
    derivative of  mass_moment * radial.
    """

    def __init__(self, exciter: ExciterPlan) -> None:
        self._exciter, self._across = exciter, np.cross(exciter.axis, exciter.start)

    def force_N(self, time_s: Array) -> Array:
        """Return the force in the world (n, 3) at the times (n,), at the exciter's given speed."""
        return self.inertia_force_N(*self.turning(time_s))

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

    def turning(self, time_s: Array) -> tuple[Array, Array, Array]:
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
