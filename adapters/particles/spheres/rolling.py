"""Resistance to rolling: LIGGGHTS 3.8.0's ``rolling_friction cdt`` and ``epsd2`` (cured: its couple
stays across the normal, bridge/rolling_across.h).

A couple against the relative rotation, without its part about the normal, of at most
coefficient * reduced radius * normal force: at once (``cdt``, constant directional torque) or
by a spring of stiffness  tangential stiffness * reduced radius^2  (``epsd2``, elastic-plastic
without damper).  Ai, J., Chen, J.-F., Rotter, J. M. and Ooi, J. Y., Powder Technology 206, 2011,
269-282, doi 10.1016/j.powtec.2010.09.030, models A and C.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from adapters.particles.spheres.adhesion import reduced
from adapters.particles.spheres.contacts import ContactForces, Springs
from adapters.particles.spheres.partners import Partners
from orchestrator.ports import Array
from orchestrator.ports.plans import ParticlesPlan


@dataclass(frozen=True)
class Rolling:
    """``coefficient`` (k, k) by pair of materials."""

    law: Literal["cdt", "epsd2"]
    coefficient: Array

    def couple_N_m(
        self,
        partners: Partners,
        springs: Springs,
        at: ContactForces,
        normal: Array,
        step_s: float,
        before_N_m: Array,
    ) -> Array:
        """On the first partner of each contact, (n, 3); ``before_N_m`` a step ago."""
        radius_m = reduced(partners.radii_m)
        arm_m = self.coefficient[partners.materials] * radius_m
        if self.law == "cdt":
            limit_N_m = arm_m * (springs.normal_N + springs.pull_N)
            return _directional(limit_N_m, normal, partners.rolling_rad_per_s)
        stiffness_N_per_m = springs.tangential_N_per_m * radius_m**2
        turn_rad = step_s * across(partners.rolling_rad_per_s, normal)
        # what came to lie along the turning normal is dropped: no rotation would take it back
        couple_N_m = across(before_N_m, normal) - stiffness_N_per_m[:, None] * turn_rad
        return _limited(couple_N_m, arm_m * at.grip_N)


def rolling(plan: ParticlesPlan) -> Rolling | None:
    """None without any resistance to rolling."""
    if not np.any(plan.rolling_friction > 0.0):
        return None
    return Rolling(plan.rolling, plan.rolling_friction)


def _directional(limit_N_m: Array, normal: Array, spin_rad_per_s: Array) -> Array:
    size = np.linalg.norm(spin_rad_per_s, axis=1)
    share = limit_N_m / np.where(size > 0.0, size, 1.0)
    return across(-share[:, None] * spin_rad_per_s, normal)


def _limited(couple_N_m: Array, limit_N_m: Array) -> Array:
    size_N_m = np.linalg.norm(couple_N_m, axis=1)
    over = size_N_m > limit_N_m
    shrink = np.where(over, limit_N_m / np.where(over, size_N_m, 1.0), 1.0)
    return np.asarray(shrink[:, None] * couple_N_m)


def across(vector: Array, normal: Array) -> Array:
    """Without its part along the normal."""
    return np.asarray(vector - np.einsum("ij,ij->i", vector, normal)[:, None] * normal)
