"""Size classes for tests, and what is asked of any set of spheres."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from orchestrator.case.bed.size_distribution import size_class
from orchestrator.case.tables.bed import SizeClass
from orchestrator.ports import Array
from orchestrator.ports.plans import ParticleList

COAL = (size_class(0.0015, 0.003, 0.3), size_class(0.003, 0.006, 0.3), size_class(0.006, 0.013, 0.4))


def smallest_gap_m(particles: ParticleList) -> float:
    """Smallest distance between two surfaces; negative if any two overlap."""
    if len(particles) < 2:
        return np.inf
    radius_m = particles.grains.sieve_size_m / 2.0
    i, j = cKDTree(particles.position_m).query_pairs(4.0 * radius_m.max(), output_type="ndarray").T
    apart_m = np.linalg.norm(particles.position_m[i] - particles.position_m[j], axis=1)
    return float(np.min(apart_m - radius_m[i] - radius_m[j], initial=np.inf))


def mass_shares(diameter_m: Array, sizes: tuple[SizeClass, ...]) -> Array:
    mass = [
        np.sum(diameter_m[(diameter_m >= row.smallest_m) & (diameter_m < row.largest_m)] ** 3)
        for row in sizes
    ]
    return np.array(mass) / np.sum(mass)
