"""The shaft of an unbalance that a motor turns, in the plane: its angle is a coordinate.

    J w' = torque - bearing w - u t . (a - g),    t = d(radial)/d(angle)

a the acceleration of the shaft's place, u the unbalance's mass moment; the frame gets the force of
any unbalance, -u d2(radial)/dt2.  The motor stands on the ground and passes on torque only, as by a
cardan shaft: its reaction goes into the ground.  At the nodes of the frames' own collocation.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from adapters.frames.common import linear
from adapters.frames.common.collocation import STAGES, Gauss
from adapters.frames.common.motor import synchronous_rad_per_s, torque_N_m
from adapters.frames.planar.plane import Complex, carrying, in_plane, power
from orchestrator.ports import Array, Saved
from orchestrator.ports.plans import Exciter, FramesPlan, Motor
from orchestrator.ports.state import put_back, taken

_STATE = ("angle_rad", "speed_rad_per_s", "_felt_m_per_s2", "_growth_rad_per_s2", "motor_J", "lost_J")


@dataclass(frozen=True)
class Turning:
    """At the nodes of a step, (nodes,) each."""

    speed_rad_per_s: Array
    growth_rad_per_s2: Array
    torque_N_m: Array


def shafts(plan: FramesPlan, drawn_m: Array) -> list[Shaft]:
    """One for each exciter with a motor.  Raises ValueError for one that does not lie across."""
    found = []
    for exciter in plan.exciters:
        if exciter.motor is not None:
            body = linear.numbers(plan, (exciter.body,))
            at = carrying(body, exciter.position_m[None], drawn_m)[:, 0]
            found.append(Shaft(exciter, exciter.motor, at, plan.gravity_m_per_s2))
    return found


class Shaft:
    """``angle_rad``, ``speed_rad_per_s`` at the last step's end; ``motor_J``, ``lost_J`` since t = 0.

    ``at`` (2 bodies,): its place's displacement per natural coordinate.  In each round of the
    frames' iteration, ``force`` and then ``feel``; ``end`` when the step is accepted.
    """

    def __init__(self, exciter: Exciter, motor: Motor, at: Complex, gravity_m_per_s2: Array) -> None:
        if abs(exciter.axis[1]) < 1 - 1e-12:
            raise ValueError("a motor's shaft must lie across, along y, where frames are planar")
        self._exciter, self._motor = exciter, motor
        self._sense, self._start = np.sign(exciter.axis[1]), complex(in_plane(exciter.start))
        self._gravity_m_per_s2 = complex(in_plane(gravity_m_per_s2))
        self.angle_rad, self.speed_rad_per_s = exciter.phase_rad, 0.0
        self._at = at
        self._felt_m_per_s2 = np.zeros(STAGES, dtype=np.complex128)
        self._growth_rad_per_s2 = np.zeros(STAGES)
        self.motor_J = self.lost_J = 0.0

    def force(self, gauss: Gauss, start_s: float) -> Complex:
        """On the natural coordinates, (nodes, 2 bodies)."""
        time_s = start_s + gauss.node_s
        speed = self.speed_rad_per_s + gauss.integral_s @ self._growth_rad_per_s2
        radial = self._radial(self.angle_rad + gauss.integral_s @ speed)
        torque = torque_N_m(self._motor, synchronous_rad_per_s(self._exciter, self._motor, time_s) - speed)
        torque *= time_s >= self._exciter.start_s
        size, motor = self._exciter.mass_moment_kg_m, self._motor
        swung = power(1j * self._sense * radial, self._felt_m_per_s2 - self._gravity_m_per_s2)
        growth = (torque - motor.bearing_N_m_s * speed - size * swung) / motor.inertia_kg_m2
        growth *= time_s >= self._exciter.start_s  # until then a brake holds it
        self._growth_rad_per_s2, self._turning = growth, Turning(speed, growth, torque)
        force_N = size * (speed**2 - 1j * self._sense * growth) * radial
        return np.outer(force_N, self._at.conj())

    def feel(self, acceleration: Complex) -> None:
        """Of the natural coordinates, (nodes, 2 bodies)."""
        self._felt_m_per_s2 = acceleration @ self._at

    def end(self, gauss: Gauss) -> None:
        """Accept the step."""
        weight_s, turning = gauss.weight_s, self._turning
        self.angle_rad += float(weight_s @ turning.speed_rad_per_s)
        self.speed_rad_per_s += float(weight_s @ turning.growth_rad_per_s2)
        self.motor_J += float(weight_s @ (turning.torque_N_m * turning.speed_rad_per_s))
        self.lost_J += self._motor.bearing_N_m_s * float(weight_s @ turning.speed_rad_per_s**2)

    def stored_J(self, rate: Complex) -> float:
        """Its own and the unbalance's, beyond what the unbalance's mass has as part of its body,
        with the natural coordinates at this rate (2 bodies,); zero at rest at t = 0."""
        velocity_m_per_s = complex(rate @ self._at)
        radial, first = (complex(self._radial(a)) for a in (self.angle_rad, self._exciter.phase_rad))
        moved = (1j * self._sense * radial * self.speed_rad_per_s).conjugate() * velocity_m_per_s
        risen = (radial - first).conjugate() * self._gravity_m_per_s2
        own_J = self._motor.inertia_kg_m2 * self.speed_rad_per_s**2 / 2
        return float(own_J + self._exciter.mass_moment_kg_m * (moved - risen).real)

    def save(self) -> Saved:
        return taken(self, *_STATE)

    def restore(self, saved: Saved) -> None:
        put_back(self, saved, *_STATE)

    def _radial(self, angle_rad: Array | float) -> Complex:
        return np.asarray(self._start * np.exp(1j * self._sense * angle_rad))
