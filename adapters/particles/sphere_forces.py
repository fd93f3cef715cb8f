"""All contact forces at one instant, what they store and what they dissipate."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from adapters.particles.sphere_contacts import Laws, contact_forces, springs
from adapters.particles.sphere_neighbours import Neighbours
from adapters.particles.sphere_state import Spheres
from adapters.particles.sphere_touch import Touching, continued, touching
from orchestrator.geometry import TriangleSurface
from orchestrator.ports import Array, Indices, Motion


@dataclass(frozen=True)
class Forces:
    """Arrays have one row per contact unless they say otherwise; (n, 3) are world vectors.

    ``friction_J``: what the tangential springs have lost since the instant before: their work
    less the change of what they store.  ``damping_W``: power of the dampers now.
    """

    touching: Touching
    surface_m_s: Array  # velocity of the surface at its contacts
    contact_N: Array  # (n, 3) on the first partner
    turning_N: Array  # (surface contacts, 3) on the sphere, through its centre
    damping_N: Array  # (n, 3) part of contact_N
    shear_m: Array  # (n, 3)
    tangential_N_m: Array  # (n,)
    normal_J: Array
    tangential_J: Array
    force_N: Array  # (spheres, 3)
    torque_N_m: Array  # (spheres, 3)
    on_points_N: Array  # (points, 3)
    friction_J: float
    damping_W: float

    @property
    def elastic_J(self) -> Array:
        return self.normal_J + self.tangential_J

    def carried(self, velocity_m_s: Array) -> Forces:
        """With the surface points at ``velocity_m_s`` (points, 3) from now on; the forces, which
        the next half step takes, stay."""
        return replace(self, surface_m_s=self.touching.at_contacts(velocity_m_s))

    def damped(self, velocity_m_s: Array, spin_rad_s: Array) -> Forces:
        """With the dampers' power at the velocities of the full step."""
        slip_m_s = self.touching.slip_m_s(velocity_m_s, spin_rad_s, self.surface_m_s)
        return replace(self, damping_W=-float(np.vdot(self.damping_N, slip_m_s)))

    def spent_J(self, jump_m: Array) -> float:
        """Work that dampers and tangential springs do when the surface points jump by ``jump_m``
        (points, 3): neither notices, so it is stored nowhere."""
        pairs = self.touching.pairs
        unaware_N = self.damping_N - self.tangential_N_m[:, None] * self.shear_m
        return float(np.vdot(unaware_N[pairs:], self.touching.at_contacts(jump_m)))

    def renumbered(self, row: Indices, spheres: int) -> Forces:
        """With sphere i in row ``row[i]`` of now ``spheres``, or gone where ``row[i]`` < 0."""
        kept, contacts = self.touching.renumbered(row)
        of_surface = kept[self.touching.pairs :]
        contact_N, turning_N = self.contact_N[kept], self.turning_N[of_surface]
        force_N, torque_N_m = contacts.on_spheres(contact_N, turning_N, spheres)
        return Forces(
            contacts,
            self.surface_m_s[of_surface],
            contact_N,
            turning_N,
            self.damping_N[kept],
            self.shear_m[kept],
            self.tangential_N_m[kept],
            self.normal_J[kept],
            self.tangential_J[kept],
            force_N,
            torque_N_m,
            contacts.on_points(contact_N, turning_N, len(self.on_points_N)),
            self.friction_J,
            self.damping_W,
        )


def forces_at(
    spheres: Spheres,
    surface: TriangleSurface,
    motion: Motion,
    near: Neighbours,
    laws: Laws,
    before: Forces | None,
    step_s: float,
) -> Forces:
    """Forces with the surface points at ``motion``, ``step_s`` after ``before``."""
    contacts = touching(spheres, surface, motion.position_m, near)
    pairs, first, second = contacts.pairs, contacts.first, contacts.second
    inverse_m, inverse_kg = 1.0 / spheres.radius_m[first], 1.0 / spheres.mass_kg[first]
    inverse_m[:pairs] += 1.0 / spheres.radius_m[second]
    inverse_kg[:pairs] += 1.0 / spheres.mass_kg[second]
    law = springs(
        laws,
        (spheres.material[first], contacts.material),
        contacts.overlap_m,
        1.0 / inverse_m,
        1.0 / inverse_kg,
        contacts.weight,
    )
    surface_m_s = contacts.at_contacts(motion.velocity_m_s)
    slip_m_s = contacts.slip_m_s(spheres.velocity_m_s, spheres.spin_rad_s, surface_m_s)
    history = _history(contacts, before, len(spheres))
    stretch_m = step_s * slip_m_s
    shear_m = _tangential(history.shear_m + stretch_m, contacts.normal)
    at = contact_forces(law, contacts.overlap_m, contacts.normal, slip_m_s, shear_m)
    tension_N = law.tangential_N_m[:, None] * at.shear_m
    tangential_J = 0.5 * np.einsum("ij,ij->i", tension_N, at.shear_m)
    work_J = 0.5 * float(np.vdot(tension_N + history.tension_N, stretch_m))
    normal_J = 0.4 * law.normal_N_m * contacts.overlap_m**2
    turning_N = _turning_N(laws, spheres, contacts)
    force_N, torque_N_m = contacts.on_spheres(at.force_N, turning_N, len(spheres))
    return Forces(
        contacts,
        surface_m_s,
        at.force_N,
        turning_N,
        at.damping_N,
        at.shear_m,
        law.tangential_N_m,
        normal_J,
        tangential_J,
        force_N,
        torque_N_m,
        contacts.on_points(at.force_N, turning_N, len(motion)),
        work_J + history.stored_J - float(tangential_J.sum()),
        0.0,
    )


def _turning_N(laws: Laws, spheres: Spheres, contacts: Touching) -> Array:
    """Hertz's energy is 8/15 E* sqrt(r) overlap^(5/2)."""
    of_surface = slice(contacts.pairs, None)
    sphere = contacts.first[of_surface]
    E_star_Pa = laws.youngs_modulus_Pa[spheres.material[sphere], contacts.material[of_surface]]
    stiffness_N_m1_5 = 8.0 / 15.0 * E_star_Pa * np.sqrt(spheres.radius_m[sphere])
    return np.asarray(stiffness_N_m1_5[:, None] * contacts.turning)


@dataclass(frozen=True)
class _History:
    """The tangential springs an instant ago, in the rows of now; zero where the contact is new."""

    shear_m: Array
    tension_N: Array
    stored_J: float  # in all, contacts that have ended included


def _history(now: Touching, before: Forces | None, spheres: int) -> _History:
    nothing = np.zeros((len(now.first), 3))
    if before is None:
        return _History(nothing, nothing, 0.0)
    same, parent = continued(now, before.touching, spheres)
    shear_m, tension_N = nothing, nothing.copy()
    heir, old = np.flatnonzero(parent >= 0), np.flatnonzero(same >= 0)
    shear_m[heir] = before.shear_m[parent[heir]]
    tension_N[old] = before.tangential_N_m[same[old], None] * shear_m[old]
    return _History(shear_m, tension_N, float(before.tangential_J.sum()))


def _tangential(vector: Array, normal: Array) -> Array:
    return np.asarray(vector - np.einsum("ij,ij->i", vector, normal)[:, None] * normal)
