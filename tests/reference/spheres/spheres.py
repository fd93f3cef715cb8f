"""The spheres themselves: one array per property, one row per sphere."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from adapters.particles.liggghts.ledger import SolidSpheres
from orchestrator.ports import Array, Indices, ParticleSnapshot, Removed
from orchestrator.ports.physics import sphere_mass_kg
from orchestrator.ports.plans import ParticleList
from tests.reference.spheres.rows import Rows
from tests.reference.spheres.visits import Visits


@dataclass
class Spheres(SolidSpheres, Rows):
    """n solid spheres sorted by id."""

    id: Indices
    density_kg_per_m3: Array
    material: Indices

    @staticmethod
    def of(particles: ParticleList, first_id: int) -> Spheres:
        """The spheres of a list, with ids in order from ``first_id``."""
        return Spheres(
            mass_kg=sphere_mass_kg(particles.diameter_m, particles.density_kg_per_m3),
            radius_m=particles.diameter_m / 2.0,
            position_m=particles.position_m.copy(),
            velocity_m_per_s=particles.velocity_m_per_s.copy(),
            spin_rad_per_s=particles.spin_rad_per_s.copy(),
            id=first_id + np.arange(len(particles)),
            density_kg_per_m3=particles.density_kg_per_m3.copy(),
            material=particles.material.copy(),
        )

    def snapshot(self) -> ParticleSnapshot:
        """A copy, as the port has it."""
        return ParticleSnapshot(
            id=self.id.copy(),
            position_m=self.position_m.copy(),
            velocity_m_per_s=self.velocity_m_per_s.copy(),
            spin_rad_per_s=self.spin_rad_per_s.copy(),
            diameter_m=2.0 * self.radius_m,
            density_kg_per_m3=self.density_kg_per_m3.copy(),
            material=self.material.copy(),
        )

    def removed(self, time_s: float, exit_of: Indices, visits: Visits) -> Removed:
        """The record of all of them, taken out at ``time_s`` through ``exit_of`` (n,)."""
        return Removed(
            id=self.id,
            time_s=np.full(len(self), time_s),
            position_m=self.position_m,
            velocity_m_per_s=self.velocity_m_per_s,
            diameter_m=2.0 * self.radius_m,
            density_kg_per_m3=self.density_kg_per_m3,
            material=self.material,
            exit=exit_of,
            contacts=visits.contacts.astype(np.int32),
            over_s=visits.over_s.astype(np.float32),
            within_reach_s=visits.within_reach_s.astype(np.float32),
            last_panel=visits.last_panel,
        )
