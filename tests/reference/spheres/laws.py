"""The contact laws: normal force, damping, friction, resistance to rolling.

They are those of LIGGGHTS 3.8.0's ``tangential history`` and ``rolling_friction`` with ``model
hertz``, ``cohesion sjkr`` or our ``model jkr``.  Equations: docs/theory/spheres.md and adhesion.md.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from orchestrator.ports import Array
from orchestrator.ports.plans import Jkr, ParticlesPlan, Rebound, Sjkr
from orchestrator.ports.rows import Rows
from tests.reference.spheres.contacts import Contacts


@dataclass(frozen=True)
class NormalForce:
    """Results of the normal law for n contacts, (n,) each."""

    contact_radius_m: Array
    force_N: Array  # positive pushes apart
    spring_N: Array  # the same without the attraction of ``sjkr``
    pull_N: Array  # to be added to the force for the limits of friction and rolling resistance
    elastic_J: Array
    adhesion_J: Array  # not above 0


@dataclass(frozen=True)
class NormalLaw:
    """The law of Johnson, Kendall and Roberts (Proc. R. Soc. Lond. A 324, 1971, 301-313, doi
    10.1098/rspa.1971.0141), which is Hertz's where there is no work of adhesion, and LIGGGHTS's
    ``cohesion sjkr``, an attraction over the area in which the bodies cut each other.

    Tables (k, k) by pair of materials.  No contact holds beyond a gap of ``reach_m``.
    """

    youngs_modulus_Pa: Array  # E*
    work_J_per_m2: Array
    energy_density_J_per_m3: Array
    reach_m: float

    @staticmethod
    def of(plan: ParticlesPlan, youngs_modulus_Pa: Array) -> NormalLaw:
        """The plan's law."""
        none, adhesion = np.zeros_like(youngs_modulus_Pa), plan.adhesion
        if isinstance(adhesion, Jkr):
            reach_m = adhesion.largest_stretch * 2.0 * plan.largest_radius_m
            return NormalLaw(youngs_modulus_Pa, adhesion.work_J_per_m2, none, reach_m)
        density = adhesion.energy_density_J_per_m3 if isinstance(adhesion, Sjkr) else none
        return NormalLaw(youngs_modulus_Pa, none, density, 0.0)

    def separation_m(self, contacts: Contacts) -> Array:
        """The overlap (n,), not above 0, down to which a contact that has formed holds."""
        return np.asarray(-3.0 * self._snapping_neck_m(contacts) ** 2 / contacts.reduced_radius_m)

    def at(self, contacts: Contacts, overlap_m: Array) -> NormalForce:
        """The forces and energies at an overlap (n,)."""
        E_Pa = self.youngs_modulus_Pa[contacts.materials]
        work_J_per_m2 = self.work_J_per_m2[contacts.materials]
        radius_m = contacts.reduced_radius_m
        neck_m = self._neck_m(contacts, overlap_m)
        flat_m = neck_m**2 / radius_m
        attraction_N = attraction_J = np.zeros(len(overlap_m))
        if self.energy_density_J_per_m3.any():
            density_J_per_m3 = self.energy_density_J_per_m3[contacts.materials]
            area_m2, volume_m3 = _lens(contacts.radius_m, contacts.second_radius_m, overlap_m)
            attraction_N, attraction_J = density_J_per_m3 * area_m2, density_J_per_m3 * volume_m3
        hertz_N = 4.0 / 3.0 * E_Pa * neck_m * flat_m
        pulled_N = np.sqrt(8.0 * np.pi * work_J_per_m2 * E_Pa * neck_m**3)
        return NormalForce(
            neck_m,
            hertz_N - pulled_N - attraction_N,
            hertz_N - pulled_N,
            3.0 * np.pi * work_J_per_m2 * radius_m + attraction_N,  # twice the pull-off force
            E_Pa * neck_m * (overlap_m**2 - 2.0 / 3.0 * flat_m * overlap_m + 0.2 * flat_m**2),
            -np.pi * neck_m**2 * work_J_per_m2 - attraction_J,
        )

    def _snapping_neck_m(self, contacts: Contacts) -> Array:
        work_m = np.pi * self.work_J_per_m2 / (8.0 * self.youngs_modulus_Pa)
        return np.asarray(np.cbrt(work_m[contacts.materials] * contacts.reduced_radius_m**2))

    def _neck_m(self, contacts: Contacts, overlap_m: Array) -> Array:
        """The radius of contact.  With u^2 = neck / (neck when it snaps) and the overlap in units of
        -separation, the stable branch is the largest root u >= 1 of  u^4 - 4 u = 3 overlap, found by
        Ferrari's method."""
        radius_m, least_m = contacts.reduced_radius_m, self._snapping_neck_m(contacts)
        hertz_m: Array = np.sqrt(radius_m * np.abs(overlap_m))
        dry = least_m == 0.0
        if dry.all():
            return hertz_m
        least_m = np.where(dry, 1.0, least_m)
        d = np.maximum(overlap_m * radius_m / (3.0 * least_m**2), -1.0)
        t = np.cbrt(1.0 + np.sqrt(1.0 + d**3))
        m = 2.0 / (t**2 + d + (d / t) ** 2)  # m^3 + 3 d m = 2
        root = np.sqrt(2.0 * m)
        u = 0.5 * (root + np.sqrt(np.maximum(8.0 / root - 2.0 * m, 0.0)))
        return np.asarray(np.where(dry, hertz_m, least_m * u**2))


def _lens(one_m: Array, other_m: Array, overlap_m: Array) -> tuple[Array, Array]:
    """The area of contact of ``sjkr`` between spheres, or with a plane (radius infinite), and its
    integral over the overlap."""
    plane = np.isinf(other_m)
    two_m = np.where(plane, one_m, other_m)
    total_m, apart_m, odd_m = one_m + two_m, one_m + two_m - overlap_m, one_m - two_m
    area_m2 = overlap_m * (total_m + apart_m) * (1.0 - (odd_m / apart_m) ** 2) / 4.0
    height_m = (apart_m + 2.0 * total_m) / 3.0 - odd_m**2 / apart_m
    return (
        np.pi * np.where(plane, overlap_m * (2.0 * one_m - overlap_m), area_m2),
        np.pi * overlap_m**2 * np.where(plane, one_m - overlap_m / 3.0, height_m / 4.0),
    )


@dataclass(frozen=True)
class ContactForces(Rows):
    """Forces and couples in n contacts, with their weights in all but ``shear_m`` and ``couple_N_m``.

    Forces are those on the first partner.  Of ``stiffness_N_per_m`` and ``damping_N_s_per_m`` (n, 2) the
    first column is along the normal, the second across, zero for a contact that slides.
    """

    force_N: Array  # (n, 3)
    damping_N: Array  # (n, 3) the part of it that the dampers give
    turning_N: Array  # (n, 3) on a sphere that touches the surface, through its centre
    shear_m: Array  # (n, 3) elongation of the tangential spring
    couple_N_m: Array  # (n, 3) against rolling
    approach_m_per_s: Array  # (n,) with which the partners first touched
    slip_m_per_s: Array  # (n, 3) in the evaluation
    half_step: Array  # (n,) as a share of the time from that slip to the next one
    tangential_N_per_m: Array  # (n,)
    stiffness_N_per_m: Array
    damping_N_s_per_m: Array
    rubbed_J: Array  # (n,) what friction goes by, times what the tangential spring gave way
    tangential_J: Array  # (n,) stored in that spring
    elastic_J: Array  # (n,) that of the spring included
    adhesion_J: Array  # (n,)


@dataclass(frozen=True)
class Laws:
    """Coefficients by pair of materials, (k, k).

    Damping gives a restitution whatever the speed; that of a pair with a ``Rebound`` goes by the speed of
    approach at first touch: Tsuji, Y., Tanaka, T. and Ishida, T., Powder
    Technology 71, 1992, 239-250, in the closed form of Antypov, D. and Elliott, J. A., EPL 94, 2011,
    50004, doi 10.1209/0295-5075/94/50004.  The tangential stiffness 8 G* a is that of Mindlin, R. D.,
    Journal of Applied Mechanics 16, 1949, 259-268.  Rolling: models A (``cdt``, constant directional
    torque) and C (``epsd2``, elastic-plastic without damper, cured: bridge/jkr_contact.h) of
    Ai, J., Chen, J.-F., Rotter, J. M. and Ooi, J. Y., Powder Technology 206, 2011, 269-282, doi
    10.1016/j.powtec.2010.09.030.
    """

    normal: NormalLaw
    shear_modulus_Pa: Array  # G*
    restitution: Array
    rebounds: tuple[Rebound, ...]
    sliding_friction: Array
    rolling_friction: Array
    rolling: Literal["cdt", "epsd2"]

    @staticmethod
    def of(plan: ParticlesPlan) -> Laws:
        """The plan's laws.  Raises ValueError for a restitution outside (0, 1]."""
        if not ((plan.restitution > 0.0) & (plan.restitution <= 1.0)).all():
            raise ValueError(f"restitution must be in (0, 1], got {plan.restitution.tolist()}")
        E = np.array([material.youngs_modulus_Pa for material in plan.materials])
        nu = np.array([material.poisson_ratio for material in plan.materials])
        normal, shear = (1.0 - nu**2) / E, 2.0 * (2.0 - nu) * (1.0 + nu) / E
        return Laws(
            NormalLaw.of(plan, 1.0 / np.add.outer(normal, normal)),
            1.0 / np.add.outer(shear, shear),
            plan.restitution,
            plan.rebounds,
            plan.sliding_friction,
            plan.rolling_friction,
            plan.rolling,
        )

    def stiffness_N_per_m(self, contacts: Contacts) -> Array:
        """The stiffness (n,) along the normal."""
        neck_m = self.normal.at(contacts, np.maximum(contacts.overlap_m, 0.0)).contact_radius_m
        return np.asarray(2.0 * self.normal.youngs_modulus_Pa[contacts.materials] * neck_m)

    def at(
        self,
        contacts: Contacts,
        slip_m_per_s: Array,
        shown_m_per_s: Array,
        spin_rad_per_s: Array,
        shear_m: Array,
        couple_N_m: Array,
        approach_m_per_s: Array,
        step_s: float,
    ) -> ContactForces:
        """The forces at the present overlaps.

        ``slip_m_per_s`` and ``spin_rad_per_s`` (n, 3) are those of the first partner relative to the
        second at the contact, in the middle of the step of ``step_s`` that ends now (0: those of now);
        ``shown_m_per_s`` (n, 3) is by what the slip has changed, for half a step; ``shear_m`` (n, 3) is the
        spring's elongation with this step's slip in it, ``couple_N_m`` (n, 3) that against rolling a step
        ago, ``approach_m_per_s`` (n,) the speed of the first touch.

        Dampers go by the slip of the step's end: with what the contact itself changes in half a step, as
        far as the slip shows it.  A sliding contact has no tangential damping.
        """
        pair, normal = contacts.materials, contacts.normal
        law = self.normal.at(contacts, contacts.overlap_m)
        S_n = 2.0 * self.normal.youngs_modulus_Pa[pair] * law.contact_radius_m
        S_t = 8.0 * self.shear_modulus_Pa[pair] * law.contact_radius_m
        damping = 2.0 * np.sqrt(5.0 / 6.0) * self._damping_ratio(contacts, approach_m_per_s)
        g_n, g_t = damping * np.sqrt(S_n * contacts.mass_kg), damping * np.sqrt(S_t * contacts.mass_kg)

        half_s_per_kg = step_s / 2.0 / contacts.mass_kg
        closing_m_per_s = np.einsum("ij,ij->i", slip_m_per_s, normal)
        tangential_m_per_s = slip_m_per_s - closing_m_per_s[:, None] * normal
        own_m_per_s = _own_change(half_s_per_kg, g_n, law.spring_N, closing_m_per_s)[:, None] * normal
        closing_m_per_s = closing_m_per_s + np.einsum("ij,ij->i", _share(own_m_per_s, shown_m_per_s), normal)
        turning_s_per_kg, damping_N_s_per_m = 3.5 * half_s_per_kg[:, None], g_t[:, None]
        own_m_per_s = _own_change(
            turning_s_per_kg, damping_N_s_per_m, -S_t[:, None] * shear_m, tangential_m_per_s
        )
        tangential_m_per_s = tangential_m_per_s + _share(own_m_per_s, shown_m_per_s)
        damping_n = -g_n * closing_m_per_s
        grip_N = np.abs(law.force_N + damping_n + law.pull_N)
        stretched_N, limit_N = S_t * np.linalg.norm(shear_m, axis=1), self.sliding_friction[pair] * grip_N
        left_m = _limited(shear_m, stretched_N, limit_N)
        g_t = np.where(stretched_N > limit_N, 0.0, g_t)
        sticks = stretched_N < limit_N
        damping_N = damping_n[:, None] * normal - g_t[:, None] * tangential_m_per_s
        elastic_N = law.force_N[:, None] * normal - S_t[:, None] * left_m
        couple_N_m = self._couple_N_m(contacts, spin_rad_per_s, couple_N_m, law, S_t, grip_N, step_s)
        weight, column = contacts.weight, contacts.weight[:, None]
        tangential_J = weight * 0.5 * S_t * np.einsum("ij,ij->i", left_m, left_m)
        # Hertz's energy is 8/15 E* sqrt(r) overlap^(5/2)
        turned = 8.0 / 15.0 * self.normal.youngs_modulus_Pa[pair] * np.sqrt(contacts.reduced_radius_m)
        return ContactForces(
            force_N=column * (elastic_N + damping_N),
            damping_N=column * damping_N,
            turning_N=turned[:, None] * contacts.turning,
            shear_m=left_m,
            couple_N_m=couple_N_m,
            approach_m_per_s=approach_m_per_s,
            slip_m_per_s=slip_m_per_s,
            half_step=np.full(len(slip_m_per_s), 0.5 if step_s > 0.0 else 1.0),
            tangential_N_per_m=weight * S_t,
            stiffness_N_per_m=column * np.column_stack([S_n, sticks * S_t]),
            damping_N_s_per_m=column * np.column_stack([g_n, sticks * g_t]),
            rubbed_J=weight * grip_N * np.linalg.norm(shear_m - left_m, axis=1),
            tangential_J=tangential_J,
            elastic_J=weight * law.elastic_J + tangential_J,
            adhesion_J=weight * law.adhesion_J,
        )

    def _damping_ratio(self, contacts: Contacts, approach_m_per_s: Array) -> Array:
        """The damping ratio (n,) of the linear oscillator with the same restitution."""
        materials, others = contacts.materials
        restitution = self.restitution[materials, others]
        for rebound in self.rebounds:
            first, second = rebound.materials
            pair = ((materials == first) & (others == second)) | ((materials == second) & (others == first))
            at = np.interp(approach_m_per_s, rebound.speed_m_per_s, rebound.restitution)
            restitution = np.where(pair, at, restitution)
        log_e = np.log(restitution)
        return np.asarray(-log_e / np.hypot(log_e, np.pi))

    def _couple_N_m(
        self,
        contacts: Contacts,
        spin_rad_per_s: Array,
        before_N_m: Array,
        law: NormalForce,
        S_t: Array,
        grip_N: Array,
        step_s: float,
    ) -> Array:
        """The couple against the relative rotation, without its part about the normal, of at most
        coefficient * reduced radius * normal force: at once, or by a spring.  LIGGGHTS takes for the
        rotation on a surface one that is longer by lever / distance."""
        if not self.rolling_friction.any():
            return before_N_m
        radius_m, normal = contacts.reduced_radius_m, contacts.normal
        arm_m = self.rolling_friction[contacts.materials] * radius_m
        longer = np.where(contacts.second < 0, contacts.lever_m / contacts.distance_m, 1.0)
        spin_rad_per_s = longer[:, None] * spin_rad_per_s
        if self.rolling == "cdt":
            size = np.linalg.norm(spin_rad_per_s, axis=1)
            share = arm_m * (law.force_N + law.pull_N) / np.where(size > 0.0, size, 1.0)
            return across(-share[:, None] * spin_rad_per_s, normal)
        turn_rad = step_s * across(spin_rad_per_s, normal)
        # what came to lie along the turning normal is dropped: no rotation would take it back
        couple_N_m = across(before_N_m, normal) - (S_t * radius_m**2)[:, None] * turn_rad
        return _limited(couple_N_m, np.linalg.norm(couple_N_m, axis=1), arm_m * grip_N)


def _own_change(
    half_s_per_kg: Array, damping_N_s_per_m: Array, spring_N: Array, slip_m_per_s: Array
) -> Array:
    """By what spring and damper change the slip in half a step, the damper by the slip at its end."""
    change_m_per_s = half_s_per_kg * (spring_N - damping_N_s_per_m * slip_m_per_s)
    return np.asarray(change_m_per_s / (1.0 + half_s_per_kg * damping_N_s_per_m))


def _share(own_m_per_s: Array, shown_m_per_s: Array) -> Array:
    """The part of a contact's own changes (n, 3) of slip that the slip shows."""
    all_m2_per_s2 = np.einsum("ij,ij->i", own_m_per_s, own_m_per_s)
    along = np.einsum("ij,ij->i", shown_m_per_s, own_m_per_s)
    share = np.clip(along / np.where(all_m2_per_s2 > 0.0, all_m2_per_s2, 1.0), 0.0, 1.0)
    return np.asarray(share[:, None] * own_m_per_s)


def across(vector: Array, normal: Array) -> Array:
    """Vectors (n, 3) without their part along the normal."""
    return np.asarray(vector - np.einsum("ij,ij->i", vector, normal)[:, None] * normal)


def _limited(vector: Array, size: Array, limit: Array) -> Array:
    """Vectors (n, 3), shortened where their ``size`` (n,) is above the limit."""
    over = size > limit
    return np.asarray(np.where(over, limit / np.where(over, size, 1.0), 1.0)[:, None] * vector)
