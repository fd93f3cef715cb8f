"""The ledger of frames: momentum and energy, and what came from outside.

Driven bodies belong to the outside as the ground does, but have momentum and energy: their
drives give them whatever bushings and reactions do not (d'Alembert).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from adapters.frames.common.exciter import Shaft
from orchestrator.ports import Account, Array, Indices, Saved
from orchestrator.ports.state import restore_attributes, save_attributes

_SUMS = ("outside_N_s", "damping_J", "exciter_J", "reaction_J", "pushed_J")


@dataclass(frozen=True)
class BodySums:
    """What bodies have at one time: momentum (bodies, 3), kinetic and gravitational energy
    (bodies,), the latter zero as drawn."""

    momentum_kg_m_per_s: Array
    kinetic_J: Array
    gravitational_J: Array


class FramesLedger:
    """Sums since ``start``, at t = 0.

    ``outside_N_s`` (3,) is the impulse of ground, driven bodies, weight and exciters on the free
    bodies, less that of the reaction on all others; ``damping_J`` is lost in bushings; ``exciter_J``
    and ``reaction_J`` are work; ``pushed_J`` is the work of bushings and reaction on driven bodies.
    """

    def __init__(self, start: BodySums, driven: Indices) -> None:
        self._start, self._driven = start, driven
        self.outside_N_s = np.zeros(3)
        self.damping_J = self.exciter_J = self.reaction_J = self.pushed_J = 0.0

    def account(self, now: BodySums, elastic_J: float, shafts: Sequence[tuple[Shaft, Array]] = ()) -> Account:
        """Return the account of bodies as they are ``now``, on bushings that store ``elastic_J``.

        ``shafts`` come with the velocities (3,) of their places."""
        driven = self._driven
        gained_N_s = (now.momentum_kg_m_per_s - self._start.momentum_kg_m_per_s)[driven].sum(axis=0)
        supplied_J, lost_J = {"exciter": self.exciter_J}, {"bushing_damping": self.damping_J}
        stored_J = {
            "kinetic": float(now.kinetic_J.sum()),
            "bushing_elastic": elastic_J,
            "gravitational": float(now.gravitational_J.sum()),
        }
        if len(driven):
            gained_J = now.kinetic_J - self._start.kinetic_J
            gained_J = gained_J + (now.gravitational_J - self._start.gravitational_J)
            supplied_J["drive"] = float(gained_J[driven].sum()) - self.pushed_J
        if shafts:
            supplied_J["motor"] = sum(shaft.motor_J for shaft, _ in shafts)
            lost_J["shaft_bearing"] = sum(shaft.lost_J for shaft, _ in shafts)
            stored_J["shaft"] = sum(shaft.stored_J(velocity) for shaft, velocity in shafts)
        return Account(
            now.momentum_kg_m_per_s.sum(axis=0),
            self.outside_N_s + gained_N_s,
            stored_J=stored_J,
            lost_J=lost_J,
            supplied_J=supplied_J,
            received_J={"reaction": self.reaction_J},
        )

    def save(self) -> Saved:
        return save_attributes(self, *_SUMS)

    def restore(self, saved: Saved) -> None:
        restore_attributes(self, saved, *_SUMS)
