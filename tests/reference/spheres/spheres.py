"""The spheres themselves: one array per property, one row per sphere."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from adapters.particles.liggghts.ledger import SolidSpheres
from orchestrator.ports import Indices, ParticleSnapshot, Removed
from orchestrator.ports.grains import Grains
from orchestrator.ports.plans import ParticleList
from orchestrator.ports.rows import Rows
from tests.reference.spheres.visits import Visits


@dataclass
class Spheres(SolidSpheres, Rows):
    """n solid spheres sorted by id."""

    id: Indices
    grains: Grains

    @property
    def material(self) -> Indices:
        """The numbers of their materials (n,)."""
        return np.asarray(self.grains.material)

    @staticmethod
    def of(particles: ParticleList, first_id: int) -> Spheres:
        """The spheres of a list, with ids in order from ``first_id``."""
        return Spheres(
            mass_kg=particles.grains.mass_kg,
            radius_m=particles.grains.bounding_radius_m,
            position_m=particles.position_m.copy(),
            velocity_m_per_s=particles.velocity_m_per_s.copy(),
            spin_rad_per_s=particles.spin_rad_per_s.copy(),
            id=first_id + np.arange(len(particles)),
            grains=particles.grains,
        )

    def snapshot(self) -> ParticleSnapshot:
        """A copy, as the port has it."""
        return ParticleSnapshot(
            id=self.id.copy(),
            position_m=self.position_m.copy(),
            velocity_m_per_s=self.velocity_m_per_s.copy(),
            spin_rad_per_s=self.spin_rad_per_s.copy(),
            grains=self.grains,
        )

    def removed(self, time_s: float, exit_of: Indices, visits: Visits) -> Removed:
        """The record of all of them, taken out at ``time_s`` through ``exit_of`` (n,)."""
        return Removed(
            id=self.id,
            time_s=np.full(len(self), time_s),
            position_m=self.position_m,
            velocity_m_per_s=self.velocity_m_per_s,
            grains=self.grains,
            exit=exit_of,
            contacts=visits.contacts.astype(np.int32),
            over_s=visits.over_s.astype(np.float32),
            within_reach_s=visits.within_reach_s.astype(np.float32),
            last_panel=visits.last_panel,
        )
