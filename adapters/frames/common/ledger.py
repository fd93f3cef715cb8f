"""The ledger of frames: momentum, energy, and contributions from outside.

Driven bodies belong to the outside as the ground does, but have momentum and energy: their drives give them
whatever bushings and reactions do not (d'Alembert).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from adapters.frames.common.exciter import Shaft
from orchestrator.ports import Account, Array
from orchestrator.ports.linear_frames import driven
from orchestrator.ports.plans import FramesPlan
from orchestrator.ports.state import SavedAttributes


@dataclass(frozen=True)
class BodyMotion:
    """The motion of bodies at one time: velocity and displacement (bodies, 3) of their centres of mass, and
    the energy (bodies,) of their rotation."""

    velocity_m_per_s: Array
    moved_m: Array
    turning_J: Array


class FramesLedger(SavedAttributes):
    """The sums of impulse and energy exchanged since ``start``, at t = 0.

    ``outside_N_s`` (3,) is the impulse of ground, driven bodies, weight and exciters on the free bodies, less
    the impulse of the reaction on all other bodies.  ``damping_J`` is the energy lost in bushings.
    ``exciter_J`` and ``reaction_J`` are the work of exciters and reaction.  ``pushed_J`` is the work of
    bushings and reaction on driven bodies.
    """

    STATE: ClassVar[tuple[str, ...]] = ("outside_N_s", "damping_J", "exciter_J", "reaction_J", "pushed_J")

    def __init__(self, plan: FramesPlan, start: BodyMotion) -> None:
        self._mass_kg = np.array([body.mass_kg for body in plan.bodies])
        self._gravity_m_per_s2, self._driven = plan.gravity_m_per_s2, driven(plan)
        self._first_N_s, self._first_J = self._momentum(start)[self._driven], self._energies_J(start)
        self.outside_N_s = np.zeros(3)
        self.damping_J = self.exciter_J = self.reaction_J = self.pushed_J = 0.0

    def add(
        self, *, outside_N_s: Array, damping_J: float, exciter_J: float, reaction_J: float, pushed_J: float
    ) -> None:
        """Add what was exchanged meanwhile; the names are those of the sums."""
        self.outside_N_s = self.outside_N_s + outside_N_s
        self.damping_J += damping_J
        self.exciter_J += exciter_J
        self.reaction_J += reaction_J
        self.pushed_J += pushed_J

    def account(
        self, now: BodyMotion, elastic_J: float, shafts: Sequence[tuple[Shaft, Array]] = ()
    ) -> Account:
        """Return the account of bodies as they move ``now``, on bushings that store ``elastic_J``.

        ``shafts`` come with the velocities (3,) of their places."""
        momentum_N_s, energies_J = self._momentum(now), self._energies_J(now)
        gained_N_s = (momentum_N_s[self._driven] - self._first_N_s).sum(axis=0)
        supplied_J, lost_J = {"exciter": self.exciter_J}, {"bushing_damping": self.damping_J}
        stored_J = {
            "kinetic": float(energies_J[0].sum()),
            "bushing_elastic": elastic_J,
            "gravitational": float(energies_J[1].sum()),
        }
        if len(self._driven):
            gained_J = (energies_J - self._first_J).sum(axis=0)
            supplied_J["drive"] = float(gained_J[self._driven].sum()) - self.pushed_J
        if shafts:
            supplied_J["motor"] = sum(shaft.motor_J for shaft, _ in shafts)
            lost_J["shaft_bearing"] = sum(shaft.lost_J for shaft, _ in shafts)
            stored_J["shaft"] = sum(shaft.stored_J(velocity) for shaft, velocity in shafts)
        return Account(
            momentum_N_s.sum(axis=0),
            self.outside_N_s + gained_N_s,
            stored_J=stored_J,
            lost_J=lost_J,
            supplied_J=supplied_J,
            received_J={"reaction": self.reaction_J},
        )

    def _momentum(self, bodies: BodyMotion) -> Array:
        """Return the momentum (bodies, 3) in kg m/s."""
        return np.asarray(self._mass_kg[:, None] * bodies.velocity_m_per_s)

    def _energies_J(self, bodies: BodyMotion) -> Array:
        """Return the kinetic and the gravitational energy in J, (2, bodies); gravity's is zero as drawn."""
        moving_J = self._mass_kg * (bodies.velocity_m_per_s**2).sum(axis=1) / 2
        risen_J = -self._mass_kg * (bodies.moved_m @ self._gravity_m_per_s2)
        return np.stack([moving_J + bodies.turning_J, risen_J])
