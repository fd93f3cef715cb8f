"""All contact forces at one instant, what they store and dissipate, and how they answer to motion."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from orchestrator.ports import Array, ContactTangent, Indices, Motion
from orchestrator.ports.geometry import TriangleSurface
from tests.reference.spheres.contacts import Contacts, Neighbours, find_contacts, match_contacts
from tests.reference.spheres.damped_mass import compute_damped_mass_kg
from tests.reference.spheres.laws import ContactForces, Laws, across
from tests.reference.spheres.spheres import Spheres


@dataclass(frozen=True)
class SphereForces:
    """The contacts and their forces, and the sums over spheres and surface points.

    ``lost_J``: lost since the instant before by tangential springs (their work less the change of
    what they store), by resistance to rolling (its work) and by necks that formed or snapped.
    ``damping_W``: power of the dampers now.
    """

    contacts: Contacts
    acting: ContactForces
    surface_m_per_s: Array  # (contacts, 3) velocity of the surface
    force_N: Array  # (spheres, 3)
    torque_N_m: Array  # (spheres, 3)
    on_points_N: Array  # (points, 3)
    lost_J: float
    damping_W: float

    @staticmethod
    def sum_up(
        contacts: Contacts,
        acting: ContactForces,
        surface_m_per_s: Array,
        spheres: int,
        points: int,
        lost_J: float,
    ) -> SphereForces:
        """The forces with their sums over so many spheres and points."""
        given = (acting.force_N, acting.turning_N, contacts.weight[:, None] * acting.couple_N_m)
        force_N, torque_N_m = contacts.sum_on_spheres(*given, spheres)
        on_points_N = contacts.sum_on_points(*given, points)
        return SphereForces(contacts, acting, surface_m_per_s, force_N, torque_N_m, on_points_N, lost_J, 0.0)

    def at_velocities(self, spheres: Spheres, surface_m_per_s: Array) -> SphereForces:
        """The same forces, which the next half step takes, with the surface points at these velocities
        (points, 3) from now on, and the dampers' power at those of the full step."""
        at_contacts = self.contacts.at_contacts(surface_m_per_s)[0]
        slip = self.contacts.compute_slip(spheres.velocity_m_per_s, spheres.spin_rad_per_s, at_contacts)
        damping_W = -float(np.vdot(self.acting.damping_N, slip))
        return replace(self, surface_m_per_s=at_contacts, damping_W=damping_W)

    def compute_spent_J(self, jump_m: Array) -> float:
        """Return the work that dampers, tangential springs and resistance to rolling do when the
        surface points jump by ``jump_m`` (points, 3): none of them notices, so it is stored nowhere."""
        acting = self.acting
        unaware_N = acting.damping_N - acting.tangential_N_per_m[:, None] * acting.shear_m
        moved_m, turned_rad = self.contacts.at_contacts(jump_m)
        couple_N_m = self.contacts.weight[:, None] * acting.couple_N_m
        return float(np.vdot(unaware_N, moved_m) + np.vdot(couple_N_m, turned_rad))

    def with_surface_of(self, other: SphereForces, spheres: int) -> SphereForces:
        """The forces between spheres, with the contacts on the surface and their forces of ``other``."""
        pairs, on_surface = self.contacts.second >= 0, other.contacts.second < 0
        contacts = Contacts.joined([self.contacts.part(pairs), other.contacts.part(on_surface)])
        acting = ContactForces.joined([self.acting.part(pairs), other.acting.part(on_surface)])
        surface_m_per_s = np.concatenate([self.surface_m_per_s[pairs], other.surface_m_per_s[on_surface]])
        points = len(self.on_points_N)
        return SphereForces.sum_up(contacts, acting, surface_m_per_s, spheres, points, other.lost_J)

    def stored_J(self) -> float:
        """The energy of all contacts."""
        return float(self.acting.elastic_J.sum() + self.acting.adhesion_J.sum())

    def renumbered(self, row: Indices, spheres: int) -> SphereForces:
        """The forces with sphere i in row ``row[i]`` of now ``spheres``, or gone where ``row[i]`` < 0."""
        stays, contacts = self.contacts.renumbered(row)
        acting, surface_m_per_s = self.acting.part(stays), self.surface_m_per_s[stays]
        points = len(self.on_points_N)
        left = SphereForces.sum_up(contacts, acting, surface_m_per_s, spheres, points, self.lost_J)
        return replace(left, damping_W=self.damping_W)


def compute_forces(
    laws: Laws,
    surface: TriangleSurface,
    spheres: Spheres,
    motion: Motion,
    near: Neighbours,
    before: SphereForces | None,
    step_s: float,
) -> SphereForces:
    """Find the contacts and compute their forces with the surface points at ``motion``, ``step_s``
    after ``before``."""
    contacts = find_contacts(
        spheres, surface, motion.position_m, near, laws.normal, None if before is None else before.contacts
    )
    if before is not None and not len(contacts.first) and not len(before.contacts.first):
        return replace(before, contacts=contacts, lost_J=0.0, damping_W=0.0)  # in free flight
    surface_m_per_s, surface_rad_per_s = contacts.at_contacts(motion.velocity_m_per_s)
    slip_m_per_s = contacts.compute_slip(spheres.velocity_m_per_s, spheres.spin_rad_per_s, surface_m_per_s)
    spin_rad_per_s = contacts.compute_spin(spheres.spin_rad_per_s, surface_rad_per_s)
    stiffness_N_per_m = laws.stiffness_N_per_m(contacts)
    damped_kg = compute_damped_mass_kg(contacts, spheres, slip_m_per_s, stiffness_N_per_m)
    contacts = replace(contacts, mass_kg=damped_kg)
    # what springs and couples were, zero where a contact is new; lost until now: all they stored
    shear_m, tension_N, couple_N_m, shown_m_per_s = np.zeros((4, len(contacts.first), 3))
    approach_m_per_s, lost_J = -np.einsum("ij,ij->i", slip_m_per_s, contacts.normal), 0.0
    if before is not None:
        same, parent = match_contacts(contacts, before.contacts, len(spheres))
        heir, old = np.flatnonzero(parent >= 0), np.flatnonzero(same >= 0)
        shear_m[heir] = before.acting.shear_m[parent[heir]]
        couple_N_m[heir] = before.acting.couple_N_m[parent[heir]]
        approach_m_per_s[heir] = before.acting.approach_m_per_s[parent[heir]]
        changed_m_per_s = slip_m_per_s[heir] - before.acting.slip_m_per_s[parent[heir]]
        shown_m_per_s[heir] = before.acting.half_step[parent[heir], None] * changed_m_per_s
        tension_N[old] = before.acting.tangential_N_per_m[same[old], None] * shear_m[old]
        lost_J = float(before.acting.tangential_J.sum())
        if laws.normal.reach_m > 0.0:
            lost_J += _compute_necks_J(laws, contacts, before.contacts, same, parent)
    stretch_m = step_s * slip_m_per_s
    elongation_m = across(shear_m + stretch_m, contacts.normal)
    acting = laws.at(
        contacts,
        slip_m_per_s,
        shown_m_per_s,
        spin_rad_per_s,
        elongation_m,
        couple_N_m,
        approach_m_per_s,
        step_s,
    )
    now_N = acting.tangential_N_per_m[:, None] * acting.shear_m
    lost_J += 0.5 * float(np.vdot(now_N + tension_N, stretch_m)) - float(acting.tangential_J.sum())
    mean_N_m = 0.5 * contacts.weight[:, None] * (acting.couple_N_m + couple_N_m)
    lost_J -= step_s * float(np.vdot(mean_N_m, spin_rad_per_s))
    return SphereForces.sum_up(contacts, acting, surface_m_per_s, len(spheres), len(motion), lost_J)


def _compute_necks_J(laws: Laws, now: Contacts, before: Contacts, same: Indices, parent: Indices) -> float:
    """Return the energy lost by necks that formed at zero overlap and by those that snapped: on
    either occasion the pair changes its energy while it stays where it is."""
    law, ended = laws.normal, np.ones(len(before.first), dtype=bool)
    ended[same[same >= 0]] = False
    formed, snapped = now.part(parent < 0), before.part(ended)
    begun = law.at(formed, np.zeros(len(formed.first)))
    gone = law.at(snapped, law.separation_m(snapped))
    begun_J = np.vdot(formed.weight, begun.elastic_J + begun.adhesion_J)
    return float(np.vdot(snapped.weight, gone.elastic_J + gone.adhesion_J) - begun_J)


def compute_contact_tangent(
    spheres: Spheres, now: SphereForces, gravity_m_per_s2: Array, length_s: float
) -> ContactTangent:
    """Compute how the load on the surface answers to the surface's motion over ``length_s``.

    Each contact is linear about its present place.  Springs and dampers by the implicit midpoint
    rule: the mean force on the sphere is  elastic - z (u - surface velocity), z = k H / 2 + g,  with
    the mean velocity u of the point of the sphere that touches, which that force itself changes by
    H / 2 times what it gives (docs/theory/coupling.md).
    """
    on_surface, half_s = now.contacts.second < 0, length_s / 2
    contacts, acting = now.contacts.part(on_surface), now.acting.part(on_surface)
    first, normal, still = contacts.first, contacts.normal, np.zeros((len(contacts.first), 3))
    inertia_kg_m2 = spheres.inertia_kg_m2
    # velocity that an impulse gives the point that touches, along the normal and across
    light_1_kg = np.column_stack([1 / spheres.mass_kg, 1 / spheres.mass_kg])[first]
    light_1_kg[:, 1] += contacts.lever_m**2 / inertia_kg_m2[first]
    acceleration = now.force_N / spheres.mass_kg[:, None] + gravity_m_per_s2
    turning = now.torque_N_m / inertia_kg_m2[:, None]
    along_N = np.einsum("ij,ij->i", acting.force_N, normal)[:, None] * normal
    own = light_1_kg[:, :1] * along_N + light_1_kg[:, 1:] * (acting.force_N - along_N)
    # the point's mean velocity, were the contact's force not there
    free_m_per_s = contacts.compute_slip(spheres.velocity_m_per_s, spheres.spin_rad_per_s, still)
    free_m_per_s += half_s * (contacts.compute_slip(acceleration, turning, still) - own)

    impedance = acting.stiffness_N_per_m * half_s + acting.damping_N_s_per_m
    share = 1.0 / (1.0 + impedance * half_s * light_1_kg)
    along = normal[:, :, None] * normal[:, None, :]

    def split(values: Array) -> Array:
        return values[:, 0, None, None] * along + values[:, 1, None, None] * (np.eye(3) - along)

    Z = split(share * impedance)
    elastic_N = acting.force_N - acting.damping_N + acting.turning_N
    push_N = np.einsum("nij,nj->ni", Z, free_m_per_s) - np.einsum("nij,nj->ni", split(share), elastic_N)
    points, weight = len(now.on_points_N), contacts.barycentric
    tangent = ContactTangent(np.zeros((points, 3)), np.zeros((points, 3, 3)))
    np.add.at(tangent.push_N, contacts.points, weight[:, :, None] * push_N[:, None, :])
    shares = weight[:, :, None, None] * Z[:, None, :, :]
    np.add.at(tangent.impedance_N_s_per_m, contacts.points, shares)
    return tangent
