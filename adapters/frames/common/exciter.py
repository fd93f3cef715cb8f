"""The shaft of an unbalance that a motor turns.

A shaft's equation of motion is

    J w' = torque - bearing w - u t . (a - g),    t = d(radial)/d(angle)

with the acceleration a of the shaft's place and the unbalance's mass moment u.  The frame gets the force of
any unbalance, -u d2(radial)/dt2.  The motor stands on the ground and passes on torque only, as by a cardan
shaft: its reaction goes into the ground.
"""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from orchestrator.ports import Array
from orchestrator.ports.physics import motor_torque_N_m
from orchestrator.ports.plans import ExciterPlan, FramesPlan, MotorPlan
from orchestrator.ports.state import SavedAttributes
from orchestrator.ports.unbalance import Unbalance, run_up


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

    def synchronous_rad_per_s(self, time_s: Array) -> Array:
        """Return the synchronous speed (n,) at the times (n,).

        It runs up and down as an exciter's speed does, at constant voltage over frequency.
        """
        exciter = self._exciter
        up, _ = run_up(time_s - exciter.start_s, exciter.run_up_s)
        down, _ = run_up(time_s - exciter.stop_s, exciter.run_down_s)
        return np.asarray(self._motor.synchronous_rad_per_s * up * (1 - down))

    def torque_N_m(self, speed_rad_per_s: Array, time_s: Array) -> Array:
        """Return the motor's torque (n,) on a shaft at these speeds and times, (n,) each."""
        return motor_torque_N_m(self._motor, self.synchronous_rad_per_s(time_s) - speed_rad_per_s)

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
