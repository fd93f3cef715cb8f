"""What the engine needs to know of the contact laws, besides what stands in LIGGGHTS's input."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from adapters.particles.liggghts.input import has_sliding
from orchestrator.ports.plans import GrainMaterial, Jkr, ParticlesPlan, Sjkr

if TYPE_CHECKING:
    from adapters.particles._liggghts import Engine


def set_laws(engine: Engine, plan: ParticlesPlan) -> None:
    """What the engine needs to know of the laws for the energy in contacts."""
    match plan.adhesion:
        case Jkr(work_J_per_m2=strength):
            adhesion = "jkr"
        case Sjkr(energy_density_J_per_m3=strength):
            adhesion = "sjkr"
        case None:
            adhesion, strength = "none", np.zeros(0)
    e_star_Pa, g_star_Pa = effective_moduli(plan.materials)
    engine.set_laws(e_star_Pa, g_star_Pa, has_sliding(plan), adhesion, strength.ravel().tolist())


def contact_distance_factor(plan: ParticlesPlan) -> float:
    """LIGGGHTS forgets a contact that has parted only while the bodies are within this factor of
    their contact distance (the tangential spring of one that forms again before the next neighbour
    list would otherwise be the old one); a neck must snap within it."""
    stretch = plan.adhesion.largest_stretch if isinstance(plan.adhesion, Jkr) else 0.0
    return max(1.05, 1.0 + 1.1 * stretch)


def effective_moduli(materials: tuple[GrainMaterial, ...]) -> tuple[list[float], list[float]]:
    """Hertz's E* and Mindlin's G* for every pair of materials, row by row."""
    youngs = np.array([material.youngs_modulus_Pa for material in materials])
    poisson = np.array([material.poisson_ratio for material in materials])
    normal = (1.0 - poisson**2) / youngs
    shear = 2.0 * (2.0 - poisson) * (1.0 + poisson) / youngs
    e_star_Pa = 1.0 / np.add.outer(normal, normal)
    g_star_Pa = 1.0 / np.add.outer(shear, shear)
    return e_star_Pa.ravel().tolist(), g_star_Pa.ravel().tolist()
