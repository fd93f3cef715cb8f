"""How the spheres' load on the surface answers to the surface's motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from adapters.particles.spheres.contacts import springs
from adapters.particles.spheres.forces import Forces, System
from adapters.particles.spheres.partners import partners
from adapters.particles.spheres.state import Spheres
from orchestrator.ports import Array, ContactTangent

SLIDES = 1.0 - 1e-9  # of the force at which friction gives way: there it is held


@dataclass(frozen=True)
class _Pushing:
    """The surface contacts, linear about their present place; arrays of one row each.

    ``free_m_per_s`` (n, 3): mean velocity, over the interval, of the point of the sphere that touches,
    were the contact's force not there.  Of ``stiffness_N_per_m`` and the like (n, 2) the first column
    is along the normal, the second across; ``light_1_kg``: velocity that an impulse gives that
    point.
    """

    normal: Array
    elastic_N: Array
    free_m_per_s: Array
    stiffness_N_per_m: Array
    damping_N_s_per_m: Array
    light_1_kg: Array


def response(
    system: System, spheres: Spheres, now: Forces, gravity_m_per_s2: Array, length_s: float
) -> ContactTangent:
    """Springs and dampers by the implicit midpoint rule: the mean force on the sphere is
    elastic - z (u - surface velocity), z = k H / 2 + g, with the point's mean velocity u, which
    that force itself changes by H / 2 times what it gives (docs/theory/coupling.md)."""
    one = _pushing(system, spheres, now, gravity_m_per_s2, length_s / 2)
    impedance = one.stiffness_N_per_m * length_s / 2 + one.damping_N_s_per_m
    share = 1.0 / (1.0 + impedance * length_s / 2 * one.light_1_kg)
    along = one.normal[:, :, None] * one.normal[:, None, :]
    across = np.eye(3) - along

    def split(values: Array) -> Array:
        return values[:, 0, None, None] * along + values[:, 1, None, None] * across

    Z = split(share * impedance)
    push_N = np.einsum("nij,nj->ni", Z, one.free_m_per_s)
    push_N -= np.einsum("nij,nj->ni", split(share), one.elastic_N)
    touching, points = now.touching, len(now.on_points_N)
    found = ContactTangent(np.zeros((points, 3)), np.zeros((points, 3, 3)))
    weight = touching.barycentric
    np.add.at(found.push_N, touching.points, weight[:, :, None] * push_N[:, None, :])
    shares = weight[:, :, None, None] * Z[:, None, :, :]
    np.add.at(found.impedance_N_s_per_m, touching.points, shares)
    return found


def _pushing(
    system: System, spheres: Spheres, now: Forces, gravity_m_per_s2: Array, half_s: float
) -> _Pushing:
    touching = now.touching
    surface = slice(touching.pairs, None)
    first, normal = touching.first[surface], touching.normal[surface]
    lever_m, mass_kg = touching.lever_m[surface], spheres.mass_kg
    contact_N, damping_N = now.contact_N[surface], now.damping_N[surface]
    stiffness, damping = _springs(system, spheres, now)
    light = np.column_stack([1 / mass_kg, 1 / mass_kg])[first]
    light[:, 1] += lever_m**2 / spheres.inertia_kg_m2[first]
    acceleration = now.force_N / mass_kg[:, None] + gravity_m_per_s2
    turning = now.torque_N_m / spheres.inertia_kg_m2[:, None]
    still = np.zeros((len(first), 3))
    free_m_per_s = touching.slip_m_per_s(spheres.velocity_m_per_s, spheres.spin_rad_per_s, still)[surface]
    free_m_per_s += half_s * touching.slip_m_per_s(acceleration, turning, still)[surface]
    along_N = np.einsum("ij,ij->i", contact_N, normal)[:, None] * normal
    own = light[:, :1] * along_N + light[:, 1:] * (contact_N - along_N)
    return _Pushing(
        normal, contact_N - damping_N + now.turning_N, free_m_per_s - half_s * own, stiffness, damping, light
    )


def _springs(system: System, spheres: Spheres, now: Forces) -> tuple[Array, Array]:
    """Stiffness and damping (n, 2), along and across, of the surface contacts; a contact that
    slides has neither across."""
    touching = now.touching
    two = partners(touching, spheres, np.zeros((len(touching.first) - touching.pairs, 3)))
    at = system.laws.normal.at(two.materials, two.radii_m, touching.overlap_m)
    law = springs(system.laws, two.materials, at, two.mass_kg)
    weight = touching.weight
    along_N = np.einsum("ij,ij->i", now.damping_N, touching.normal) / weight
    limit_N = law.friction * np.abs(law.normal_N + along_N + law.pull_N)
    sticks = law.tangential_N_per_m * np.linalg.norm(now.shear_m, axis=1) < SLIDES * limit_N
    normal_N_per_m = 2.0 * system.laws.youngs_modulus_Pa[two.materials] * at.contact_radius_m
    stiffness = np.column_stack([normal_N_per_m, sticks * law.tangential_N_per_m])
    damping = np.column_stack([law.normal_N_s_per_m, sticks * law.tangential_N_s_per_m])
    surface = slice(touching.pairs, None)
    return (weight[:, None] * stiffness)[surface], (weight[:, None] * damping)[surface]
