"""The spheres of which grains are made: one array per property, one row per sphere."""

from __future__ import annotations

from dataclasses import dataclass

from orchestrator.ports import Array, Indices


@dataclass
class Spheres:
    """n spheres, those of one grain after those of the other.

    Masses and ids are those of the grains, whose row is ``body`` (n,); ``own_m`` (n, 3) is the place in the
    grain's principal axes.
    """

    mass_kg: Array
    radius_m: Array
    position_m: Array
    velocity_m_per_s: Array
    spin_rad_per_s: Array
    id: Indices
    material: Indices
    body: Indices
    own_m: Array
    arm_m: Array  # (n, 3) from the grain's centre
    inverse_inertia_1_kg_m2: Array  # (n, 3, 3) of the grain, in the world's axes

    def __len__(self) -> int:
        return len(self.mass_kg)

    @property
    def inertia_kg_m2(self) -> Array:
        """The moments of inertia (n,) of grains of one sphere each about their centres."""
        return 0.4 * self.mass_kg * self.radius_m**2
