"""What solid spheres own: mass, momentum and energy, of any solver's arrays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchestrator.ports import Array


@dataclass
class SolidSpheres:
    """n spheres, one row each; their moment of inertia is 2/5 m r^2."""

    mass_kg: Array  # (n,)
    radius_m: Array  # (n,)
    position_m: Array  # (n, 3)
    velocity_m_per_s: Array  # (n, 3)
    spin_rad_per_s: Array  # (n, 3)

    def __len__(self) -> int:
        return len(self.mass_kg)

    @property
    def inertia_kg_m2(self) -> Array:
        return 0.4 * self.mass_kg * self.radius_m**2

    def momentum_kg_m_per_s(self) -> Array:
        """The momentum (3,) of all."""
        return self.mass_kg @ self.velocity_m_per_s

    def angular_momentum_kg_m2_per_s(self) -> Array:
        """The angular momentum (3,) of all about the world's origin."""
        orbital = self.mass_kg @ np.cross(self.position_m, self.velocity_m_per_s)
        return np.asarray(orbital + self.inertia_kg_m2 @ self.spin_rad_per_s)

    def kinetic_J(self) -> float:
        """The kinetic energy of all, rotation included."""
        moving = self.mass_kg @ np.sum(self.velocity_m_per_s**2, axis=1)
        return float(moving + self.inertia_kg_m2 @ np.sum(self.spin_rad_per_s**2, axis=1)) / 2.0

    def gravitational_J(self, gravity_m_per_s2: Array) -> float:
        """The potential energy of all, zero at the world's origin."""
        return -float(self.mass_kg @ (self.position_m @ gravity_m_per_s2))

    def mechanical_J(self, gravity_m_per_s2: Array) -> float:
        """The kinetic and potential energy of all."""
        return self.kinetic_J() + self.gravitational_J(gravity_m_per_s2)
