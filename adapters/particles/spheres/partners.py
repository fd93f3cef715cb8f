"""What the two partners of each contact are made of, and how big and heavy they are together."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from adapters.particles.spheres.adhesion import Materials
from adapters.particles.spheres.state import Spheres
from adapters.particles.spheres.touch import Touching
from orchestrator.ports import Array


@dataclass(frozen=True)
class Partners:
    """n contacts: materials and radii of both partners, the surface's radius infinite; reduced
    mass (n,); spin (n, 3) of the first relative to the second, and what LIGGGHTS takes for it:
    on a surface it is longer by lever / distance."""

    materials: Materials
    radii_m: tuple[Array, Array]
    mass_kg: Array
    spin_rad_per_s: Array
    rolling_rad_per_s: Array


def partners(contacts: Touching, spheres: Spheres, surface_rad_per_s: Array) -> Partners:
    """``surface_rad_per_s`` (surface contacts, 3): spin of the surface there."""
    first, second, pairs = contacts.first, contacts.second, contacts.pairs
    radius_m, other_m = spheres.radius_m[first], np.full(len(first), np.inf)
    other_m[:pairs] = spheres.radius_m[second]
    inverse_kg = 1.0 / spheres.mass_kg[first]
    inverse_kg[:pairs] += 1.0 / spheres.mass_kg[second]
    spin_rad_per_s = spheres.spin_rad_per_s[first]
    spin_rad_per_s[:pairs] -= spheres.spin_rad_per_s[second]
    spin_rad_per_s[pairs:] -= surface_rad_per_s
    rolling_rad_per_s = spin_rad_per_s.copy()
    distance_m = radius_m[pairs:] - contacts.overlap_m[pairs:]
    rolling_rad_per_s[pairs:] *= (contacts.lever_m[pairs:] / distance_m)[:, None]
    materials = (spheres.material[first], contacts.material)
    return Partners(materials, (radius_m, other_m), 1.0 / inverse_kg, spin_rad_per_s, rolling_rad_per_s)
