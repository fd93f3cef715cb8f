"""The contact law: normal force, viscous damping, and a tangential spring that friction limits.

The same law as LIGGGHTS 3.8.0's ``tangential history`` with ``model hertz`` or our ``model jkr``
(normal force: sphere_adhesion.py).  Sources: damping that gives the restitution set at every
speed: Tsuji, Y., Tanaka, T. and Ishida, T., Powder Technology 71, 1992, 239-250, in the closed
form of Antypov, D. and Elliott, J. A., EPL 94, 2011, 50004, doi 10.1209/0295-5075/94/50004;
tangential stiffness 8 G* a of Mindlin, R. D., Journal of Applied Mechanics 16, 1949, 259-268.
Equations: docs/theory/spheres.md.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from adapters.particles.spheres.adhesion import Materials, Normal, NormalLaw, normal_law
from orchestrator.ports import Array
from orchestrator.ports.plans import ParticlesPlan


@dataclass(frozen=True)
class Laws:
    """Coefficients by pair of materials: arrays (k, k)."""

    normal: NormalLaw
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
    youngs_modulus_Pa = 1.0 / np.add.outer(normal, normal)
    log_e = np.log(plan.restitution)
    return Laws(
        normal_law(plan, youngs_modulus_Pa),
        youngs_modulus_Pa,
        1.0 / np.add.outer(shear, shear),
        -log_e / np.hypot(log_e, np.pi),
        plan.sliding_friction,
    )


@dataclass(frozen=True)
class Springs:
    """Forces, stiffness and damping of n contacts at their present overlap: (n,).

    ``pull_N`` is what the limits of friction and rolling resistance add to the normal force.
    """

    normal_N: Array
    pull_N: Array
    tangential_N_per_m: Array
    normal_N_s_per_m: Array
    tangential_N_s_per_m: Array
    friction: Array


def springs(laws: Laws, materials: Materials, normal: Normal, mass_kg: Array) -> Springs:
    """``mass_kg`` is the reduced mass; all (n,)."""
    S_n = 2.0 * laws.youngs_modulus_Pa[materials] * normal.contact_radius_m
    S_t = 8.0 * laws.shear_modulus_Pa[materials] * normal.contact_radius_m
    damping = 2.0 * np.sqrt(5.0 / 6.0) * laws.damping_ratio[materials]
    return Springs(
        normal.force_N,
        normal.pull_N,
        S_t,
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
    grip_N: Array  # (n,) what friction and rolling resistance go by


def contact_forces(law: Springs, normal: Array, slip_m_per_s: Array, shear_m: Array) -> ContactForces:
    """``normal`` points from the second partner to the first; ``slip_m_per_s`` (n, 3) is the velocity
    of the first relative to the second at the contact; ``shear_m`` the spring's elongation with
    this step's slip in it.  A sliding contact has no tangential damping.
    """
    closing_m_per_s = np.einsum("ij,ij->i", slip_m_per_s, normal)
    damping_n = -law.normal_N_s_per_m * closing_m_per_s
    grip_N = np.abs(law.normal_N + damping_n + law.pull_N)
    stretched_N = law.tangential_N_per_m * np.linalg.norm(shear_m, axis=1)
    limit_N = law.friction * grip_N
    sliding = stretched_N > limit_N
    shrink = np.where(sliding, limit_N / np.where(sliding, stretched_N, 1.0), 1.0)
    shear_m = shear_m * shrink[:, None]
    tangential_N_s_per_m = np.where(sliding, 0.0, law.tangential_N_s_per_m)
    tangential_m_per_s = slip_m_per_s - closing_m_per_s[:, None] * normal
    damping_N = damping_n[:, None] * normal - tangential_N_s_per_m[:, None] * tangential_m_per_s
    elastic_N = law.normal_N[:, None] * normal - law.tangential_N_per_m[:, None] * shear_m
    return ContactForces(elastic_N + damping_N, damping_N, shear_m, grip_N)
