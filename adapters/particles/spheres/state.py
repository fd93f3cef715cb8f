"""The spheres themselves: one array per property, one row per sphere."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import numpy as np
import numpy.typing as npt

from orchestrator.ports import Array, Indices, ParticleSnapshot, Removed
from orchestrator.ports.plans import ParticleList


@dataclass
class Spheres:
    """n spheres sorted by id; solid, so that the inertia is 2/5 m r^2."""

    id: Indices
    position_m: Array  # (n, 3)
    velocity_m_per_s: Array  # (n, 3)
    spin_rad_per_s: Array  # (n, 3)
    radius_m: Array
    mass_kg: Array
    density_kg_per_m3: Array
    material: Indices

    def __len__(self) -> int:
        return len(self.id)

    @property
    def inertia_kg_m2(self) -> Array:
        return 0.4 * self.mass_kg * self.radius_m**2

    def part(self, rows: Indices | npt.NDArray[np.bool_]) -> Spheres:
        return Spheres(*(getattr(self, name.name)[rows] for name in fields(self)))

    def joined(self, others: Spheres) -> Spheres:
        pairs = ((getattr(self, f.name), getattr(others, f.name)) for f in fields(self))
        return Spheres(*(np.concatenate(pair) for pair in pairs))

    def momentum_kg_m_per_s(self) -> Array:
        return self.mass_kg @ self.velocity_m_per_s

    def angular_momentum_kg_m2_per_s(self) -> Array:
        """(3,) about the world's origin."""
        orbital = self.mass_kg @ np.cross(self.position_m, self.velocity_m_per_s)
        return np.asarray(orbital + self.inertia_kg_m2 @ self.spin_rad_per_s)

    def kinetic_J(self) -> float:
        moving = self.mass_kg @ np.sum(self.velocity_m_per_s**2, axis=1)
        return float(moving + self.inertia_kg_m2 @ np.sum(self.spin_rad_per_s**2, axis=1)) / 2.0

    def gravitational_J(self, gravity_m_per_s2: Array) -> float:
        """Zero at the world's origin."""
        return -float(self.mass_kg @ (self.position_m @ gravity_m_per_s2))

    def snapshot(self) -> ParticleSnapshot:
        return ParticleSnapshot(
            self.id.copy(),
            self.position_m.copy(),
            self.velocity_m_per_s.copy(),
            self.spin_rad_per_s.copy(),
            2.0 * self.radius_m,
            self.density_kg_per_m3.copy(),
            self.material.copy(),
        )

    def removed(self, time_s: float, exit_of: Indices) -> Removed:
        """The record of all of them, taken out at ``time_s`` through ``exit_of`` (n,)."""
        return Removed(
            self.id,
            np.full(len(self), time_s),
            self.position_m,
            self.velocity_m_per_s,
            2.0 * self.radius_m,
            self.density_kg_per_m3,
            self.material,
            exit_of,
        )


def spheres(particles: ParticleList, first_id: int) -> Spheres:
    radius_m = particles.diameter_m / 2.0
    return Spheres(
        first_id + np.arange(len(particles)),
        particles.position_m.copy(),
        particles.velocity_m_per_s.copy(),
        particles.spin_rad_per_s.copy(),
        radius_m,
        particles.density_kg_per_m3 * (4.0 / 3.0) * math.pi * radius_m**3,
        particles.density_kg_per_m3.copy(),
        particles.material.copy(),
    )
