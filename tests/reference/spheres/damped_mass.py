"""The mass by which contacts of grains of several spheres are damped (docs/theory/clumps.md)."""

from __future__ import annotations

import numpy as np

from orchestrator.ports import Array
from tests.reference.spheres.contacts import Contacts
from tests.reference.spheres.spheres import Spheres


def compute_damped_mass_kg(
    contacts: Contacts, spheres: Spheres, slip_m_per_s: Array, stiffness_N_per_m: Array
) -> Array:
    """Return the mass (n,) by which each contact's dampers go, of the slip (n, 3) and stiffness (n,).

    The only contact of two grains gives way by their turning, too.  Where they have several, each is damped
    by S / omega^2 with Rayleigh's quotient omega^2 of the motion that all of them see, and by no more than
    the reduced mass of grains that do not turn.
    """
    normal, second = contacts.normal, contacts.second
    on_grain = second >= 0
    first_moment_m = np.cross(spheres.arm_m[contacts.first], normal)
    second_moment_m = np.cross(spheres.arm_m[second], normal) * on_grain[:, None]
    first_inverse = spheres.inverse_inertia_1_kg_m2[contacts.first]
    second_inverse = spheres.inverse_inertia_1_kg_m2[second]

    def turning(of_first: Array, of_second: Array) -> Array:
        first = np.einsum("ni,nij,nj->n", of_first, first_inverse, of_first)
        return np.asarray(first + np.einsum("ni,nij,nj->n", of_second, second_inverse, of_second))

    light_1_kg = 1.0 / contacts.mass_kg
    damped_kg = 1.0 / (light_1_kg + turning(first_moment_m, second_moment_m))
    body, other = spheres.body[contacts.first], np.where(on_grain, spheres.body[second], -1)
    swapped = on_grain & (other < body)
    pair = np.column_stack([np.where(swapped, other, body), np.where(swapped, body, other)])
    group = np.unique(pair, axis=0, return_inverse=True)[1].reshape(-1)
    presses = stiffness_N_per_m > 0.0
    places = np.column_stack([group, contacts.first, second])[presses]
    number = np.bincount(np.unique(places, axis=0)[:, 0], minlength=len(group))[group]

    way = np.where(swapped, -1.0, 1.0)[:, None]
    closing_m_per_s = np.einsum("ij,ij->i", slip_m_per_s, normal)
    push = contacts.weight * stiffness_N_per_m * closing_m_per_s

    def summed(of_each: Array) -> Array:
        total = np.zeros((len(group), 3))
        np.add.at(total, group, push[:, None] * of_each)
        return np.asarray(total[group])

    turned = np.where(swapped[:, None], -second_moment_m, first_moment_m)
    other_turned = np.where(swapped[:, None], -first_moment_m, second_moment_m)
    pushed, turned, other_turned = summed(way * normal), summed(turned), summed(other_turned)
    turned, other_turned = (
        np.where(swapped[:, None], other_turned, turned),
        np.where(swapped[:, None], turned, other_turned),
    )
    freely = light_1_kg * np.einsum("ij,ij->i", pushed, pushed) + turning(turned, other_turned)
    power = np.bincount(group, push * closing_m_per_s, minlength=len(group))[group]
    together = stiffness_N_per_m * power
    together_kg = np.where(
        together < contacts.mass_kg * freely, together / np.where(freely > 0.0, freely, 1.0), contacts.mass_kg
    )
    return np.where((number > 1) & presses, together_kg, damped_kg)
