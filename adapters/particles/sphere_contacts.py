"""The contact law: Hertz, viscous damping, and a tangential spring limited by Coulomb friction.

The same law as LIGGGHTS 3.8.0's ``model hertz tangential history``.  Sources: Hertz normal force;
damping that gives the restitution set at every speed: Tsuji, Y., Tanaka, T. and Ishida, T., Powder
Technology 71, 1992, 239-250, in the closed form of Antypov, D. and Elliott, J. A., EPL 94, 2011,
50004, doi 10.1209/0295-5075/94/50004; tangential stiffness 8 G* a of Mindlin, R. D., Journal of
Applied Mechanics 16, 1949, 259-268.  Equations: docs/theory/spheres.md.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchestrator.plans import ParticlesPlan
from orchestrator.ports import Array, Indices


@dataclass(frozen=True)
class Laws:
    """Coefficients by pair of materials: arrays (k, k)."""

    youngs_modulus_Pa: Array  # E*
    shear_modulus_Pa: Array  # G*
    damping_ratio: Array  # of the linear oscillator with the same restitution
    sliding_friction: Array


def laws(plan: ParticlesPlan) -> Laws:
    """Raises ValueError for a restitution outside (0, 1]."""
    if not ((plan.restitution > 0.0) & (plan.restitution <= 1.0)).all():
        raise ValueError(f"restitution must be in (0, 1], got {plan.restitution.tolist()}")
    E = np.array([material.youngs_modulus_Pa for material in plan.materials])
    nu = np.array([material.poisson_ratio for material in plan.materials])
    normal, shear = (1.0 - nu**2) / E, 2.0 * (2.0 - nu) * (1.0 + nu) / E
    log_e = np.log(plan.restitution)
    return Laws(
        1.0 / np.add.outer(normal, normal),
        1.0 / np.add.outer(shear, shear),
        -log_e / np.hypot(log_e, np.pi),
        plan.sliding_friction,
    )


@dataclass(frozen=True)
class Springs:
    """Stiffness and damping of n contacts at their present overlap, weights included: (n,)."""

    normal_N_m: Array  # secant: force / overlap
    tangential_N_m: Array
    normal_N_s_m: Array
    tangential_N_s_m: Array
    friction: Array


def springs(
    laws: Laws,
    materials: tuple[Indices, Indices],
    overlap_m: Array,
    radius_m: Array,
    mass_kg: Array,
    weight: Array,
) -> Springs:
    """``radius_m`` and ``mass_kg`` are the reduced ones, R* and m*; all (n,)."""
    contact_radius_m = np.sqrt(radius_m * overlap_m)
    S_n = 2.0 * laws.youngs_modulus_Pa[materials] * contact_radius_m
    S_t = 8.0 * laws.shear_modulus_Pa[materials] * contact_radius_m
    damping = weight * 2.0 * np.sqrt(5.0 / 6.0) * laws.damping_ratio[materials]
    return Springs(
        weight * 2.0 / 3.0 * S_n,
        weight * S_t,
        damping * np.sqrt(S_n * mass_kg),
        damping * np.sqrt(S_t * mass_kg),
        laws.sliding_friction[materials],
    )


@dataclass(frozen=True)
class ContactForces:
    """Forces on the first partner of each contact, (n, 3), and the shear that is left, (n, 3)."""

    force_N: Array
    damping_N: Array  # the part of it that the dampers give
    shear_m: Array


def contact_forces(
    law: Springs, overlap_m: Array, normal: Array, slip_m_s: Array, shear_m: Array
) -> ContactForces:
    """``normal`` points from the second partner to the first; ``slip_m_s`` (n, 3) is the velocity
    of the first relative to the second at the contact; ``shear_m`` the spring's elongation with
    this step's slip in it.  A sliding contact has no tangential damping.
    """
    closing_m_s = np.einsum("ij,ij->i", slip_m_s, normal)
    damping_n = -law.normal_N_s_m * closing_m_s
    push_N = law.normal_N_m * overlap_m + damping_n
    stretched_N = law.tangential_N_m * np.linalg.norm(shear_m, axis=1)
    limit_N = law.friction * np.abs(push_N)
    sliding = stretched_N > limit_N
    shrink = np.where(sliding, limit_N / np.where(sliding, stretched_N, 1.0), 1.0)
    shear_m = shear_m * shrink[:, None]
    tangential_N_s_m = np.where(sliding, 0.0, law.tangential_N_s_m)
    tangential_m_s = slip_m_s - closing_m_s[:, None] * normal
    damping_N = damping_n[:, None] * normal - tangential_N_s_m[:, None] * tangential_m_s
    elastic_N = (push_N - damping_n)[:, None] * normal - law.tangential_N_m[:, None] * shear_m
    return ContactForces(elastic_N + damping_N, damping_N, shear_m)
