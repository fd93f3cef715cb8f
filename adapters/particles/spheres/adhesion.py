"""The normal force of contacts: Hertz, Hertz with ``sjkr``, or JKR; arrays of n contacts.

JKR: Johnson, K. L., Kendall, K. and Roberts, A. D., Proc. R. Soc. Lond. A 324, 1971, 301-313,
doi 10.1098/rspa.1971.0141.  Equations: docs/theory/adhesion.md.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from orchestrator.ports import Array, Indices
from orchestrator.ports.plans import Jkr, ParticlesPlan, Sjkr

Materials = tuple[Indices, Indices]


@dataclass(frozen=True)
class Normal:
    """What the normal law gives for n contacts, (n,) each."""

    contact_radius_m: Array
    force_N: Array  # positive pushes apart
    pull_N: Array  # to be added to the force for the limits of friction and rolling resistance
    elastic_J: Array
    adhesion_J: Array  # not above 0


class NormalLaw(Protocol):
    """``radii_m`` are those of both partners, infinite for the surface; E* is (k, k)."""

    @property
    def reach_m(self) -> float:
        """No contact holds beyond this gap."""
        ...

    def separation_m(self, materials: Materials, radii_m: tuple[Array, Array]) -> Array:
        """Overlap, not above 0, down to which a contact that has formed holds."""
        ...

    def at(self, materials: Materials, radii_m: tuple[Array, Array], overlap_m: Array) -> Normal: ...


def normal_law(plan: ParticlesPlan, youngs_modulus_Pa: Array) -> NormalLaw:
    """The plan's, with its reduced moduli (k, k)."""
    match plan.adhesion:
        case Jkr(work_J_per_m2=work_J_per_m2, largest_stretch=stretch):
            reach_m = stretch * plan.largest_diameter_m
            return JkrLaw(youngs_modulus_Pa, work_J_per_m2, reach_m)
        case Sjkr(energy_density_J_per_m3=energy_density_J_per_m3):
            return SjkrLaw(youngs_modulus_Pa, energy_density_J_per_m3)
        case None:
            return HertzLaw(youngs_modulus_Pa)


def reduced(radii_m: tuple[Array, Array]) -> Array:
    return np.asarray(1.0 / (1.0 / radii_m[0] + 1.0 / radii_m[1]))


@dataclass(frozen=True)
class HertzLaw:
    youngs_modulus_Pa: Array
    reach_m: float = 0.0

    def separation_m(self, materials: Materials, radii_m: tuple[Array, Array]) -> Array:
        return np.zeros(len(radii_m[0]))

    def at(self, materials: Materials, radii_m: tuple[Array, Array], overlap_m: Array) -> Normal:
        contact_m = np.sqrt(reduced(radii_m) * overlap_m)
        force_N = 4.0 / 3.0 * self.youngs_modulus_Pa[materials] * contact_m * overlap_m
        none = np.zeros(len(overlap_m))
        return Normal(contact_m, force_N, none, 0.4 * force_N * overlap_m, none)


@dataclass(frozen=True)
class SjkrLaw:
    """LIGGGHTS 3.8.0's ``cohesion sjkr``: Hertz, and attraction over the area in which two spheres,
    or a sphere and a plane, cut each other."""

    youngs_modulus_Pa: Array
    energy_density_J_per_m3: Array
    reach_m: float = 0.0

    def separation_m(self, materials: Materials, radii_m: tuple[Array, Array]) -> Array:
        return np.zeros(len(radii_m[0]))

    def at(self, materials: Materials, radii_m: tuple[Array, Array], overlap_m: Array) -> Normal:
        hertz = HertzLaw(self.youngs_modulus_Pa).at(materials, radii_m, overlap_m)
        area_m2, volume_m3 = _lens(radii_m, overlap_m)
        pull_N = self.energy_density_J_per_m3[materials] * area_m2
        return Normal(
            hertz.contact_radius_m,
            hertz.force_N - pull_N,
            pull_N,
            hertz.elastic_J,
            -self.energy_density_J_per_m3[materials] * volume_m3,
        )


def _lens(radii_m: tuple[Array, Array], overlap_m: Array) -> tuple[Array, Array]:
    """The area of contact of ``sjkr``, and its integral over the overlap."""
    plane = np.isinf(radii_m[1])
    one, two = radii_m[0], np.where(plane, radii_m[0], radii_m[1])
    total_m, apart_m, odd_m = one + two, one + two - overlap_m, one - two
    area_m2 = overlap_m * (total_m + apart_m) * (1.0 - (odd_m / apart_m) ** 2) / 4.0
    height_m = (apart_m + 2.0 * total_m) / 3.0 - odd_m**2 / apart_m
    return (
        np.pi * np.where(plane, overlap_m * (2.0 * one - overlap_m), area_m2),
        np.pi * overlap_m**2 * np.where(plane, one - overlap_m / 3.0, height_m / 4.0),
    )


@dataclass(frozen=True)
class JkrLaw:
    """With u^2 = neck / (neck when it snaps) and the overlap in units of -separation, the stable
    branch is the largest root u >= 1 of  u^4 - 4 u = 3 overlap."""

    youngs_modulus_Pa: Array
    work_J_per_m2: Array
    reach_m: float

    def separation_m(self, materials: Materials, radii_m: tuple[Array, Array]) -> Array:
        radius_m = reduced(radii_m)
        return np.asarray(-3.0 * self._snapping_neck_m(materials, radius_m) ** 2 / radius_m)

    def at(self, materials: Materials, radii_m: tuple[Array, Array], overlap_m: Array) -> Normal:
        E_Pa, work_J_per_m2 = self.youngs_modulus_Pa[materials], self.work_J_per_m2[materials]
        radius_m = reduced(radii_m)
        neck_m = self._neck_m(materials, radius_m, overlap_m)
        flat_m = neck_m**2 / radius_m
        return Normal(
            neck_m,
            4.0 / 3.0 * E_Pa * neck_m * flat_m - np.sqrt(8.0 * np.pi * work_J_per_m2 * E_Pa * neck_m**3),
            3.0 * np.pi * work_J_per_m2 * radius_m,  # twice the pull-off force
            E_Pa * neck_m * (overlap_m**2 - 2.0 / 3.0 * flat_m * overlap_m + 0.2 * flat_m**2),
            -np.pi * neck_m**2 * work_J_per_m2,
        )

    def _snapping_neck_m(self, materials: Materials, radius_m: Array) -> Array:
        work_m = np.pi * self.work_J_per_m2[materials] / (8.0 * self.youngs_modulus_Pa[materials])
        return np.asarray(np.cbrt(work_m * radius_m**2))

    def _neck_m(self, materials: Materials, radius_m: Array, overlap_m: Array) -> Array:
        """The quartic by Ferrari's method; Hertz where there is no work of adhesion."""
        least_m = self._snapping_neck_m(materials, radius_m)
        dry = least_m == 0.0
        least_m = np.where(dry, 1.0, least_m)
        d = np.maximum(overlap_m * radius_m / (3.0 * least_m**2), -1.0)
        t = np.cbrt(1.0 + np.sqrt(1.0 + d**3))
        m = 2.0 / (t**2 + d + (d / t) ** 2)  # m^3 + 3 d m = 2
        root = np.sqrt(2.0 * m)
        u = 0.5 * (root + np.sqrt(np.maximum(8.0 / root - 2.0 * m, 0.0)))
        return np.asarray(np.where(dry, np.sqrt(radius_m * np.abs(overlap_m)), least_m * u**2))
