"""Particles on a panel: mass, stiffness and damping of the contacts of a scene."""

from __future__ import annotations

import math
from dataclasses import dataclass

from orchestrator.case.bed.contact_times import (
    contact_moduli,
    hertz_overlap_m,
    hertz_s,
    largest_diameters_m,
    reduced_modulus_Pa,
    smallest_diameters_m,
)
from orchestrator.case.tables.case import Case
from orchestrator.ports.physics import sphere_mass_kg
from orchestrator.preflight.scene.scene import Scene, bed_kg

HEXAGONAL = math.sqrt(3) / 2  # of the square of the diameter: what each needs, lying side by side


@dataclass(frozen=True)
class ContactSpring:
    """Linear, about some depth."""

    stiffness_N_per_m: float
    damping_N_s_per_m: float


@dataclass(frozen=True)
class Touch:
    """Spheres of one size on a panel.  ``deepest``: in an impact or under the bed, whichever goes
    deeper; ``resting``: under the bed as it is thrown; ``resting_m``: how deep one lies under the
    bed's weight or, where that is more, its own.  ``impact_s`` is the duration of an impact,
    ``area_m2`` what each takes of the surface where they lie side by side, ``most`` how many there
    can be."""

    material: str
    diameter_m: float
    mass_kg: float
    deepest: ContactSpring
    resting: ContactSpring
    resting_m: float
    impact_s: float
    area_m2: float
    most: float

    def __str__(self) -> str:
        return f"{self.material} of {1e3 * self.diameter_m:.3g} mm"


def touches(scene: Scene, panel_material: str) -> list[Touch]:
    """The smallest and the largest spheres of each material, on panels of a material."""
    largest_m = largest_diameters_m(scene.case)
    return [
        _touch(scene, name, diameter_m, panel_material)
        for name, smallest_m in smallest_diameters_m(scene.case).items()
        for diameter_m in sorted({smallest_m, largest_m[name]})
    ]


def _touch(scene: Scene, name: str, diameter_m: float, panel_material: str) -> Touch:
    case, speed_m_per_s = scene.case, scene.impact_m_per_s
    cap_Pa, grain = case.particles.largest_youngs_modulus_Pa, case.materials[name]
    reduced_Pa = reduced_modulus_Pa(
        contact_moduli(grain, cap_Pa), contact_moduli(case.materials[panel_material], cap_Pa)
    )
    mass_kg, radius_m = sphere_mass_kg(diameter_m, grain.density_kg_per_m3), diameter_m / 2
    area_m2 = HEXAGONAL * diameter_m**2
    pressed_N = _pressure_Pa(scene) * area_m2
    pressed_m = _pressed_m(pressed_N, reduced_Pa, radius_m)
    depth_m = max(pressed_m, hertz_overlap_m(mass_kg, radius_m, reduced_Pa, speed_m_per_s))
    restitution = _restitution(case, name, panel_material)
    deepest, resting = (
        _contact(2 * reduced_Pa * math.sqrt(radius_m * one_m), mass_kg, restitution)
        for one_m in (depth_m, pressed_m)
    )
    impact_s = hertz_s(mass_kg, radius_m, reduced_Pa, speed_m_per_s)
    most = max(1.0, bed_kg(case) / mass_kg)
    lying_N = max(scene.bed_kg_per_m2 * area_m2, mass_kg) * scene.gravity_m_per_s2
    resting_m = _pressed_m(lying_N, reduced_Pa, radius_m)
    return Touch(name, diameter_m, mass_kg, deepest, resting, resting_m, impact_s, area_m2, most)


def _pressed_m(force_N: float, reduced_Pa: float, radius_m: float) -> float:
    """Hertz's overlap under a force."""
    return float((3 * force_N / (4 * reduced_Pa * math.sqrt(radius_m))) ** (2 / 3))


def _contact(stiffness_N_per_m: float, mass_kg: float, restitution: float) -> ContactSpring:
    """Hertz's stiffness 2 E* sqrt(R depth) with the damping
    2 sqrt(5/6) beta sqrt(stiffness m), beta = -ln e / sqrt(ln^2 e + pi^2)
    (Tsuji, Tanaka and Ishida, Powder Technology 71, 1992, 239-250,
    doi 10.1016/0032-5910(92)88030-L, in the form of LIGGGHTS's model hertz)."""
    log_e = math.log(restitution)
    beta = -log_e / math.hypot(log_e, math.pi)
    return ContactSpring(
        stiffness_N_per_m, 2 * math.sqrt(5 / 6) * beta * math.sqrt(stiffness_N_per_m * mass_kg)
    )


def _pressure_Pa(scene: Scene) -> float:
    """Of the bed on a panel that throws it."""
    return scene.bed_kg_per_m2 * scene.gravity_m_per_s2 * (1 + scene.panels_throw)


def _restitution(case: Case, one: str, two: str) -> float:
    pairs = {frozenset(row.between): row.restitution for row in case.contacts}
    return pairs[frozenset((one, two))]
