"""The force of a rotating unbalance that starts when told and runs up smoothly."""

from __future__ import annotations

import math

import numpy as np

from orchestrator.ports import Array
from orchestrator.ports.plans import Exciter


class Unbalance:
    """Inertia force of a rotating unbalance on its body.

    With angle phi:  mass_moment (phi'^2 radial - phi'' tangential), which is minus the second
    time derivative of  mass_moment * radial.
    """

    def __init__(self, exciter: Exciter) -> None:
        self._exciter = exciter
        # rows: radial and tangential at angle 0
        self._axes = np.stack([exciter.start, np.cross(exciter.axis, exciter.start)])

    def force_N(self, time_s: Array) -> Array:
        """In the world at the times (n,): (n, 3)."""
        angle, speed, growth = self._turning(time_s)
        cosine, sine = np.cos(angle), np.sin(angle)
        along_start = speed**2 * cosine + growth * sine
        along_tangent = speed**2 * sine - growth * cosine
        size = self._exciter.mass_moment_kg_m
        return np.asarray(size * np.stack([along_start, along_tangent], axis=1) @ self._axes)

    def _turning(self, time_s: Array) -> tuple[Array, Array, Array]:
        """Angle in rad, speed in rad/s, angular acceleration in rad/s^2."""
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
