"""The force of a rotating unbalance whose speed runs up smoothly."""

from __future__ import annotations

import math

import numpy as np

from orchestrator.plans import Exciter
from orchestrator.ports import Array


def force_N(exciter: Exciter, time_s: Array) -> Array:
    """Inertia force of the unbalance on its body at the times (n,): (n, 3) in the world.

    With angle phi:  mass_moment (phi'^2 radial - phi'' tangential), which is minus the second
    time derivative of  mass_moment * radial.
    """
    angle, speed, growth = _turning(exciter, time_s)
    tangent = np.cross(exciter.axis, exciter.start)
    radial = np.outer(np.cos(angle), exciter.start) + np.outer(np.sin(angle), tangent)
    tangential = np.outer(np.cos(angle), tangent) - np.outer(np.sin(angle), exciter.start)
    outward = (speed**2)[:, None] * radial - growth[:, None] * tangential
    return np.asarray(exciter.mass_moment_kg_m * outward)


def angle_rad(exciter: Exciter, time_s: float) -> float:
    """The angle at one time; it is phase_rad at t = 0."""
    return float(_turning(exciter, np.array([time_s]))[0][0])


def _turning(exciter: Exciter, time_s: Array) -> tuple[Array, Array, Array]:
    """Angle in rad, speed in rad/s, angular acceleration in rad/s^2."""
    full, run_up_s = exciter.speed_rad_s, exciter.run_up_s
    if run_up_s <= 0:
        still = np.zeros_like(time_s)
        return full * time_s + exciter.phase_rad, full + still, still
    rate = math.pi / run_up_s
    rising = np.minimum(time_s, run_up_s)
    angle = full / 2 * (rising - np.sin(rate * rising) / rate) + full * (time_s - rising)
    speed = full / 2 * (1 - np.cos(rate * rising))
    growth = np.where(time_s < run_up_s, full / 2 * rate * np.sin(rate * rising), 0.0)
    return angle + exciter.phase_rad, speed, growth
