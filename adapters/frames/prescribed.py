"""Frames that move as prescribed: no masses, no forces, exact positions and velocities.

The drives give whatever force and work the panels' reaction asks for.  A body without a drive
stands still, and so does "ground".  Equations: docs/theory/frames.md.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.spatial.transform import Rotation

from orchestrator.clock import Interval
from orchestrator.plans import Drive, FramesPlan
from orchestrator.ports import Account, Array, Load, Motion, counted


def build(plan: FramesPlan) -> PrescribedFrames:
    """Raises ValueError if the plan has exciters or bushings, or names an unknown body."""
    _check(plan)
    return PrescribedFrames(plan)


class PrescribedFrames:
    """``Frames`` moved by drives only."""

    def __init__(self, plan: FramesPlan) -> None:
        self._points_m = plan.points_m
        carrier = np.array(plan.carrier, dtype=str)
        self._driven = [(drive, np.flatnonzero(carrier == drive.body)) for drive in plan.drives]
        self._now = self._motion(0.0)
        self._impulse_N_s = np.zeros(3)
        self._received_J = 0.0

    def initial(self) -> Motion:
        return self._now

    def advance(self, interval: Interval, reaction: Load) -> Motion:
        counted("frames' reaction", reaction, len(self._points_m))
        before, self._now = self._now, self._motion(interval.end_s)
        moved_m = self._now.position_m - before.position_m
        self._received_J += float(np.sum(reaction.force_N * moved_m))
        self._impulse_N_s += interval.length_s * reaction.force_N.sum(axis=0)
        return self._now

    def account(self) -> Account:
        """Massless bodies: the drives return at once the impulse and the work they receive."""
        return Account(
            np.zeros(3),
            -self._impulse_N_s,
            supplied_J={"drive": -self._received_J},
            received_J={"reaction": self._received_J},
        )

    def close(self) -> None:
        pass

    def _motion(self, time_s: float) -> Motion:
        position_m = self._points_m.copy()
        velocity_m_s = np.zeros_like(position_m)
        for drive, points in self._driven:
            position_m[points], velocity_m_s[points] = moved(drive, self._points_m[points], time_s)
        return Motion(position_m, velocity_m_s)


def moved(drive: Drive, points_m: Array, time_s: float) -> tuple[Array, Array]:
    """Position and velocity, (n, 3) each, of points that a driven body carries."""
    shift_m, shift_m_s = _harmonic(drive, drive.amplitude_m, drive.phase_rad, time_s)
    turn_rad, turn_rad_s = _harmonic(drive, drive.rotation_rad, drive.rotation_phase_rad, time_s)
    arm_m = Rotation.from_rotvec(turn_rad).apply(points_m - drive.center_m)
    spin_rad_s = angular_velocity(turn_rad, turn_rad_s)
    return drive.center_m + shift_m + arm_m, shift_m_s + np.cross(spin_rad_s, arm_m)


def angular_velocity(turn_rad: Array, rate_rad_s: Array) -> Array:
    """World angular velocity (3,) of a body turned by the rotation vector ``turn_rad`` that
    changes at ``rate_rad_s``: the left Jacobian of the exponential map times the rate
    (Chirikjian, Stochastic Models, Information Theory, and Lie Groups, vol. 2, 2012, ch. 10)."""
    square = float(turn_rad @ turn_rad)
    angle = math.sqrt(square)
    if angle < 1e-4:  # series: the closed forms cancel; next terms are below rounding
        one_minus_cos, one_minus_sinc = 0.5 - square / 24, 1 / 6 - square / 120
    else:
        one_minus_cos = 2 * math.sin(angle / 2) ** 2 / square
        one_minus_sinc = (1 - math.sin(angle) / angle) / square
    across = np.cross(turn_rad, rate_rad_s)
    twice_across = np.cross(turn_rad, across)
    return np.asarray(rate_rad_s + one_minus_cos * across + one_minus_sinc * twice_across)


def _harmonic(drive: Drive, size: Array, phase_rad: Array, time_s: float) -> tuple[Array, Array]:
    """Value and rate, (3,) each, of  ramp(t) * size * sin(w t + phase)."""
    ramp, ramp_1_s = _ramp(drive.run_up_s, time_s)
    angle = drive.speed_rad_s * time_s + phase_rad
    value = ramp * size * np.sin(angle)
    rate = size * (ramp_1_s * np.sin(angle) + ramp * drive.speed_rad_s * np.cos(angle))
    return value, rate


def _ramp(run_up_s: float, time_s: float) -> tuple[float, float]:
    """Value and rate of  (1 - cos(pi t / run_up_s)) / 2  until ``run_up_s``, then 1."""
    if time_s >= run_up_s:
        return 1.0, 0.0
    angle = math.pi * time_s / run_up_s
    return (1 - math.cos(angle)) / 2, math.pi / (2 * run_up_s) * math.sin(angle)


def _check(plan: FramesPlan) -> None:
    if plan.exciters or plan.bushings:
        raise ValueError(
            f"prescribed frames move by drives only, but the plan has {len(plan.exciters)} "
            f"exciters and {len(plan.bushings)} bushings: leave them out or take another solver"
        )
    bodies = {body.name for body in plan.bodies}
    driven = [drive.body for drive in plan.drives]
    if unknown := (set(plan.carrier) - bodies - {"ground"}) | (set(driven) - bodies):
        raise ValueError(f"no such body: {sorted(unknown)}; the bodies are {sorted(bodies)}")
    if len(set(driven)) < len(driven):
        raise ValueError(f"one drive per body, got drives for {driven}")
