"""The times of contacts, which bound the particles' step and the sync interval, and their causes."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from orchestrator.case.bed.grains import smallest_grains
from orchestrator.case.tables.case import Case, Material

LARGEST_RAYLEIGH_FRACTION = 0.2


def contact_moduli(material: Material, largest_youngs_modulus_Pa: float | None) -> tuple[float, float]:
    """Return Young's modulus in Pa, at most the largest one, and Poisson's ratio of a material in contacts.

    A hyperelastic material has by default its small-strain values: mu = 2 (C10 + C01),
    E = 9 K mu / (3 K + mu), nu = (3 K - 2 mu) / (6 K + 2 mu).
    """
    youngs_Pa, poisson = material.youngs_modulus_Pa, material.poisson_ratio
    if material.hyperelastic is not None:
        law = material.hyperelastic
        mu, bulk = 2 * (law.c10_Pa + law.c01_Pa), law.bulk_modulus_Pa
        youngs_Pa = 9 * bulk * mu / (3 * bulk + mu) if youngs_Pa is None else youngs_Pa
        poisson = (3 * bulk - 2 * mu) / (6 * bulk + 2 * mu) if poisson is None else poisson
    assert youngs_Pa is not None, "checks.references refuses this"
    assert poisson is not None, "checks.references refuses this"
    return min(youngs_Pa, largest_youngs_modulus_Pa or math.inf), poisson


def reduced_modulus_Pa(one: tuple[float, float], two: tuple[float, float]) -> float:
    """Return the reduced modulus E* of two bodies (E, nu): 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2."""
    return 1 / ((1 - one[1] ** 2) / one[0] + (1 - two[1] ** 2) / two[0])


def pair_modulus_Pa(case: Case, between: Iterable[str], is_softened: bool = True) -> float:
    """Return the reduced modulus of two materials, at most as stiff as the case lets particles be, or as
    they are."""
    cap_Pa = case.particles.largest_youngs_modulus_Pa if is_softened else None
    return reduced_modulus_Pa(*(contact_moduli(case.materials[name], cap_Pa) for name in between))


def rayleigh_s(
    radius_m: float, density_kg_per_m3: float, youngs_modulus_Pa: float, poisson_ratio: float
) -> float:
    """Return the time of a Rayleigh wave across a sphere: pi R sqrt(rho / G) / (0.1631 nu + 0.8766).

    Li, Y., Xu, Y. and Thornton, C., Powder Technology 160, 2005, 219-228,
    doi 10.1016/j.powtec.2005.09.002.
    """
    shear_Pa = youngs_modulus_Pa / (2 * (1 + poisson_ratio))
    wave = math.pi * radius_m * math.sqrt(density_kg_per_m3 / shear_Pa)
    return wave / (0.1631 * poisson_ratio + 0.8766)


def hertz_s(mass_kg: float, radius_m: float, reduced_Pa: float, speed_m_per_s: float) -> float:
    """Return the duration of an elastic impact: 2.87 (m^2 / (R E*^2 v))^(1/5).

    Mass, radius and modulus are the reduced quantities of both bodies.
    Johnson, K. L., Contact Mechanics, 1985, section 11.4.
    """
    return 2.87 * math.pow(mass_kg**2 / (radius_m * reduced_Pa**2 * speed_m_per_s), 0.2)


def hertz_overlap_m(mass_kg: float, radius_m: float, reduced_Pa: float, speed_m_per_s: float) -> float:
    """Return the largest overlap of an elastic impact: (15 m v^2 / (16 sqrt(R) E*))^(2/5).

    Mass, radius and modulus are the reduced quantities of both bodies.
    Johnson, K. L., Contact Mechanics, 1985, section 11.4.
    """
    return math.pow(15 * mass_kg * speed_m_per_s**2 / (16 * math.sqrt(radius_m) * reduced_Pa), 0.4)


def hertz_static_overlap_m(force_N: float, radius_m: float, reduced_Pa: float) -> float:
    """Return the overlap under a constant force: (9 F^2 / (16 R E*^2))^(1/3).

    Radius and modulus are the reduced quantities of both bodies.
    Johnson, K. L., Contact Mechanics, 1985, section 4.2.
    """
    return math.pow(9 * force_N**2 / (16 * radius_m * reduced_Pa**2), 1 / 3)


def shortest_rayleigh_s(case: Case) -> float:
    """Return the shortest Rayleigh time of all particles; infinite without particles."""
    cap = case.particles.largest_youngs_modulus_Pa
    times_s = [math.inf]
    for name, grain in smallest_grains(case).items():
        moduli = contact_moduli(case.materials[name], cap)
        times_s.append(rayleigh_s(grain.contact_radius_m, grain.density_kg_per_m3, *moduli))
    return min(times_s)


def impact_speed_m_per_s(case: Case) -> float:
    """Return an estimate of the speed of impacts: 1 m/s, or the highest initial speed if that is higher.

    Particles thrown by a screen have some 1 m/s.  The estimate may be rough, because the duration of
    an impact depends only weakly on the speed (power -1/5).
    """
    bed = case.bed
    speeds = [math.hypot(*row.velocity_m_per_s) for row in (*bed.particles.values(), *bed.sources)]
    if bed.carried is not None:
        speeds.append(float(np.linalg.norm(bed.carried.velocity_m_per_s, axis=1).max()))
    return max([1.0, *speeds])
