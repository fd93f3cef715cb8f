"""Materials as plans have them, numbered in the case's order."""

from __future__ import annotations

import numpy as np

from orchestrator.case.tables.case import Case, Material
from orchestrator.ports import Array
from orchestrator.ports.plans import HyperelasticPlan


def hyperelastic(material: Material) -> HyperelasticPlan:
    """A panel's material."""
    law = material.hyperelastic
    assert law is not None, "checks.references refuses panels of other materials"
    return HyperelasticPlan(
        density_kg_per_m3=material.density_kg_per_m3,
        c10_Pa=law.c10_Pa,
        c01_Pa=law.c01_Pa,
        bulk_modulus_Pa=law.bulk_modulus_Pa,
        branches=tuple((branch.ratio, branch.relaxation_s) for branch in law.maxwell),
    )


def touching_materials(case: Case) -> tuple[str, ...]:
    """Materials of particles, panels and surfaces, in the case's order."""
    bed, screen = case.bed, case.screen
    rows = (bed.particles, bed.blocks, bed.feeds, screen.panels, screen.surfaces)
    used = {row.material for table in rows for row in table.values()}
    return tuple(name for name in case.materials if name in used)


def material_numbers(case: Case) -> dict[str, int]:
    """The number of each material that touches another."""
    return {name: number for number, name in enumerate(touching_materials(case))}


def by_pair(case: Case, numbers: dict[str, int], field: str, otherwise: float = 0.0) -> Array:
    """(k, k) table of a field of ``contacts``; ``otherwise`` for pairs that never meet."""
    table = np.full((len(numbers), len(numbers)), otherwise)
    for contact in case.contacts:
        if set(contact.between) <= set(numbers):
            one, two = (numbers[name] for name in contact.between)
            table[one, two] = table[two, one] = getattr(contact, field)
    return table
