"""All contact forces at one instant, what they store and what they dissipate."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from adapters.particles.spheres.adhesion import reduced
from adapters.particles.spheres.contacts import Laws, contact_forces, springs
from adapters.particles.spheres.neighbours import Neighbours
from adapters.particles.spheres.partners import Partners, partners
from adapters.particles.spheres.rolling import Rolling, across
from adapters.particles.spheres.search import continued, touching
from adapters.particles.spheres.state import Spheres
from adapters.particles.spheres.touch import Touching
from adapters.particles.spheres.wear import Wear
from orchestrator.ports import Array, Indices, Motion
from orchestrator.ports.geometry import TriangleSurface


@dataclass(frozen=True)
class Forces:
    """Arrays have one row per contact unless they say otherwise; (n, 3) are world vectors.  The
    weights of contacts are in all but ``shear_m`` and ``couple_N_m``.

    ``lost_J``: lost since the instant before by tangential springs (their work less the change of
    what they store), by resistance to rolling (its work) and by necks that formed or snapped.
    ``damping_W``: power of the dampers now.
    """

    touching: Touching
    surface_m_per_s: Array  # velocity of the surface at its contacts
    contact_N: Array  # (n, 3) on the first partner
    turning_N: Array  # (surface contacts, 3) on the sphere, through its centre
    damping_N: Array  # (n, 3) part of contact_N
    shear_m: Array  # (n, 3)
    tangential_N_per_m: Array  # (n,)
    couple_N_m: Array  # (n, 3) on the first partner, against rolling
    elastic_J: Array
    tangential_J: Array  # part of elastic_J
    adhesion_J: Array
    force_N: Array  # (spheres, 3)
    torque_N_m: Array  # (spheres, 3)
    on_points_N: Array  # (points, 3)
    lost_J: float
    damping_W: float

    def carried(self, velocity_m_per_s: Array) -> Forces:
        """With the surface points at ``velocity_m_per_s`` (points, 3) from now on; the forces, which
        the next half step takes, stay."""
        return replace(self, surface_m_per_s=self.touching.at_contacts(velocity_m_per_s)[0])

    def damped(self, velocity_m_per_s: Array, spin_rad_per_s: Array) -> Forces:
        """With the dampers' power at the velocities of the full step."""
        slip_m_per_s = self.touching.slip_m_per_s(velocity_m_per_s, spin_rad_per_s, self.surface_m_per_s)
        return replace(self, damping_W=-float(np.vdot(self.damping_N, slip_m_per_s)))

    def spent_J(self, jump_m: Array) -> float:
        """Work that dampers, tangential springs and resistance to rolling do when the surface
        points jump by ``jump_m`` (points, 3): none of them notices, so it is stored nowhere."""
        pairs = self.touching.pairs
        unaware_N = self.damping_N - self.tangential_N_per_m[:, None] * self.shear_m
        moved_m, turned_rad = self.touching.at_contacts(jump_m)
        couple_N_m = self.touching.weighted(self.couple_N_m)[pairs:]
        return float(np.vdot(unaware_N[pairs:], moved_m) + np.vdot(couple_N_m, turned_rad))

    def renumbered(self, row: Indices, spheres: int) -> Forces:
        """With sphere i in row ``row[i]`` of now ``spheres``, or gone where ``row[i]`` < 0."""
        kept, contacts = self.touching.renumbered(row)
        of_surface = kept[self.touching.pairs :]
        contact_N, turning_N = self.contact_N[kept], self.turning_N[of_surface]
        couple_N_m = self.couple_N_m[kept]
        weighted_N_m = contacts.weighted(couple_N_m)
        force_N, torque_N_m = contacts.on_spheres(contact_N, turning_N, weighted_N_m, spheres)
        return Forces(
            contacts,
            self.surface_m_per_s[of_surface],
            contact_N,
            turning_N,
            self.damping_N[kept],
            self.shear_m[kept],
            self.tangential_N_per_m[kept],
            couple_N_m,
            self.elastic_J[kept],
            self.tangential_J[kept],
            self.adhesion_J[kept],
            force_N,
            torque_N_m,
            contacts.on_points(contact_N, turning_N, weighted_N_m, len(self.on_points_N)),
            self.lost_J,
            self.damping_W,
        )


@dataclass(frozen=True)
class History:
    """What contacts remember of the instant before: their springs and couples, in the rows of now
    and zero where a contact is new, and which contact each was (``same``, ``parent``: see
    ``continued``)."""

    same: Indices
    parent: Indices
    shear_m: Array
    tension_N: Array
    couple_N_m: Array
    tangential_J: float  # in all, contacts that have ended included


def history(now: Touching, before: Forces | None, spheres: int) -> History:
    """Of the contacts ``now``, of so many spheres."""
    shear_m, tension_N, couple_N_m = np.zeros((3, len(now.first), 3))
    if before is None:
        nothing = np.full(len(now.first), -1)
        return History(nothing, nothing, shear_m, tension_N, couple_N_m, 0.0)
    same, parent = continued(now, before.touching, spheres)
    heir, old = np.flatnonzero(parent >= 0), np.flatnonzero(same >= 0)
    shear_m[heir] = before.shear_m[parent[heir]]
    couple_N_m[heir] = before.couple_N_m[parent[heir]]
    tension_N[old] = before.tangential_N_per_m[same[old], None] * shear_m[old]
    stored_J = float(before.tangential_J.sum())
    return History(same, parent, shear_m, tension_N, couple_N_m, stored_J)


@dataclass(frozen=True)
class System:
    """What stays the same during a run."""

    surface: TriangleSurface
    laws: Laws
    rolling: Rolling | None
    wear: Wear | None


def forces_at(
    system: System, spheres: Spheres, motion: Motion, near: Neighbours, before: Forces | None, step_s: float
) -> Forces:
    """Forces with the surface points at ``motion``, ``step_s`` after ``before``."""
    contacts = touching(
        spheres,
        system.surface,
        motion.position_m,
        near,
        system.laws.normal,
        before.touching if before is not None else None,
    )
    surface_m_per_s, surface_rad_per_s = contacts.at_contacts(motion.velocity_m_per_s)
    slip_m_per_s = contacts.slip_m_per_s(spheres.velocity_m_per_s, spheres.spin_rad_per_s, surface_m_per_s)
    two, weight = partners(contacts, spheres, surface_rad_per_s), contacts.weight
    normal = system.laws.normal.at(two.materials, two.radii_m, contacts.overlap_m)
    law = springs(system.laws, two.materials, normal, two.mass_kg)
    earlier = history(contacts, before, len(spheres))
    stretch_m = step_s * slip_m_per_s
    shear_m = across(earlier.shear_m + stretch_m, contacts.normal)
    at = contact_forces(law, contacts.normal, slip_m_per_s, shear_m)
    if system.wear is not None:
        system.wear.rub(contacts, two.materials, at.grip_N, shear_m - at.shear_m)
    couple_N_m = earlier.couple_N_m
    if system.rolling is not None:
        couple_N_m = system.rolling.couple_N_m(two, law, at, contacts.normal, step_s, earlier.couple_N_m)
    tangential_N_per_m = weight * law.tangential_N_per_m
    tension_N = tangential_N_per_m[:, None] * at.shear_m
    tangential_J = 0.5 * np.einsum("ij,ij->i", tension_N, at.shear_m)
    lost_J = 0.5 * float(np.vdot(tension_N + earlier.tension_N, stretch_m))
    lost_J += earlier.tangential_J - float(tangential_J.sum())
    if system.rolling is not None:
        mean_N_m = 0.5 * contacts.weighted(couple_N_m + earlier.couple_N_m)
        lost_J -= step_s * float(np.vdot(mean_N_m, two.spin_rad_per_s))
    if before is not None and system.laws.normal.reach_m > 0.0:
        lost_J += _necks_J(system, spheres, contacts, earlier, before.touching)
    contact_N, turning_N = contacts.weighted(at.force_N), _turning_N(system.laws, two, contacts)
    weighted_N_m = contacts.weighted(couple_N_m)
    force_N, torque_N_m = contacts.on_spheres(contact_N, turning_N, weighted_N_m, len(spheres))
    return Forces(
        contacts,
        surface_m_per_s,
        contact_N,
        turning_N,
        contacts.weighted(at.damping_N),
        at.shear_m,
        tangential_N_per_m,
        couple_N_m,
        weight * normal.elastic_J + tangential_J,
        tangential_J,
        weight * normal.adhesion_J,
        force_N,
        torque_N_m,
        contacts.on_points(contact_N, turning_N, weighted_N_m, len(motion)),
        lost_J,
        0.0,
    )


def _turning_N(laws: Laws, two: Partners, contacts: Touching) -> Array:
    """Hertz's energy is 8/15 E* sqrt(r) overlap^(5/2)."""
    stiffness_N_per_m1_5 = 8.0 / 15.0 * laws.youngs_modulus_Pa[two.materials] * np.sqrt(reduced(two.radii_m))
    return np.asarray(stiffness_N_per_m1_5[contacts.pairs :, None] * contacts.turning)


def _necks_J(system: System, spheres: Spheres, now: Touching, earlier: History, before: Touching) -> float:
    """Lost by necks that formed at zero overlap and by those that snapped: on either occasion
    the pair changes its energy while it stays where it is."""
    formed, ended = earlier.parent < 0, np.ones(len(before.first), dtype=bool)
    ended[earlier.same[earlier.same >= 0]] = False
    law, lost_J = system.laws.normal, 0.0
    for changed, sign in ((now.only(formed), -1.0), (before.only(ended), 1.0)):
        if len(changed.first):
            two = partners(changed, spheres, _still(changed))
            place_m = np.zeros(len(changed.first))
            if sign > 0.0:
                place_m = law.separation_m(two.materials, two.radii_m)
            at = law.at(two.materials, two.radii_m, place_m)
            lost_J += sign * float(np.vdot(changed.weight, at.elastic_J + at.adhesion_J))
    return lost_J


def _still(contacts: Touching) -> Array:
    """Of a surface that does not turn: only radii and materials are asked for."""
    return np.zeros((len(contacts.first) - contacts.pairs, 3))
