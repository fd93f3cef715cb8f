"""Wear of the surface by what slides on it: worn volume = rate x force x distance slid.

Archard, J. F., Journal of Applied Physics 24, 1953, 981-988, doi 10.1063/1.1721448; see
docs/theory/wear.md.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from adapters.particles.spheres.adhesion import Materials
from adapters.particles.spheres.touch import Touching
from orchestrator.ports import Array, Saved
from orchestrator.ports.plans import ParticlesPlan


@dataclass(frozen=True)
class Wear:
    """``rate_m3_per_N_m`` (k, k) by pair of materials; ``worn_m3`` (points,) since t = 0."""

    rate_m3_per_N_m: Array
    worn_m3: Array

    def rub(self, contacts: Touching, materials: Materials, grip_N: Array, slid_m: Array) -> None:
        """All contacts at an instant: ``grip_N`` (n,) what friction goes by, ``slid_m`` (n, 3)
        what the tangential springs gave way in the step before."""
        surface = slice(contacts.pairs, None)
        rubbed_J = contacts.weight * grip_N * np.linalg.norm(slid_m, axis=1)
        worn_m3 = (self.rate_m3_per_N_m[materials] * rubbed_J)[surface]
        np.add.at(self.worn_m3, contacts.points, contacts.barycentric * worn_m3[:, None])

    def save(self) -> Saved:
        return {"worn_m3": self.worn_m3.copy()}

    def restore(self, saved: Saved) -> None:
        self.worn_m3[:] = saved["worn_m3"]


def wear(plan: ParticlesPlan) -> Wear | None:
    """None for a plan in which nothing wears."""
    if plan.wear_m3_per_N_m is None:
        return None
    return Wear(plan.wear_m3_per_N_m, np.zeros(len(plan.surface.position_m)))
