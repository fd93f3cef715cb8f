"""From ``[bed]`` to particles at t = 0 and to the feed, in world axes."""

from __future__ import annotations

import numpy as np

from orchestrator.case import Case
from orchestrator.plans import Feed, ParticleList


def initial_particles(case: Case, numbers: dict[str, int]) -> ParticleList:
    """Single particles, then blocks; ``numbers`` are the materials'."""
    rows = tuple(case.bed.particles.values())
    materials = [case.materials[row.material] for row in rows]
    return ParticleList(
        position_m=np.array([row.position_m for row in rows]).reshape(-1, 3),
        velocity_m_s=np.array([row.velocity_m_s for row in rows]).reshape(-1, 3),
        spin_rad_s=np.array([row.spin_rad_s for row in rows]).reshape(-1, 3),
        diameter_m=np.array([row.diameter_m for row in rows]),
        density_kg_m3=np.array([material.density_kg_m3 for material in materials]),
        material=np.array([numbers[row.material] for row in rows], dtype=np.int64),
    )


def combined_feed(case: Case, numbers: dict[str, int]) -> Feed | None:
    """All feeds as one; None without any."""
    return None


def largest_diameter_m(case: Case) -> float:
    """Of all particles that are or will be there."""
    bed = case.bed
    found = [row.diameter_m for row in bed.particles.values()]
    for source in bed.sources:
        found += [row.largest_m for row in source.sizes]
    return max(found)
