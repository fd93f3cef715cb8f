"""Size distributions of spheres, by mass: classes, evenly spread in diameter inside each class."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from orchestrator.ports import Array, Indices
from orchestrator.ports.physics import sphere_volume_m3


class SizeInterval(Protocol):
    """Diameters between two limits, and their share of the mass."""

    @property
    def smallest_m(self) -> float: ...
    @property
    def largest_m(self) -> float: ...
    @property
    def mass_fraction(self) -> float: ...


def shares(sizes: Sequence[SizeInterval]) -> Array:
    """Mass share of each class, (classes,).  Raises ValueError for limits that are not
    0 < smallest <= largest and for shares that are not positive or do not add up to 1."""
    for row in sizes:
        if not 0.0 < row.smallest_m <= row.largest_m:
            raise ValueError(f"size class from {row.smallest_m} to {row.largest_m} m")
    share = np.array([row.mass_fraction for row in sizes])
    if not (share > 0.0).all() or abs(share.sum() - 1.0) > 1e-6:
        raise ValueError(f"mass fractions must be positive and add up to 1, got {share.tolist()}")
    return np.asarray(share / share.sum())


def mean_cube_m3(sizes: Sequence[SizeInterval]) -> Array:
    """Mean of the cubed diameter in each class, (classes,)."""
    low = np.array([row.smallest_m for row in sizes])
    high = np.array([row.largest_m for row in sizes])
    return np.asarray((low**2 + high**2) * (low + high) / 4.0)  # (b^4 - a^4) / (4 (b - a))


def counts(sizes: Sequence[SizeInterval], total: int) -> Indices:
    """How many of ``total`` particles each class gets, (classes,): as near to its share of the
    mass as whole numbers allow (largest remainders)."""
    number = shares(sizes) / mean_cube_m3(sizes)
    wanted = total * number / number.sum()
    given: Indices = np.floor(wanted).astype(np.int64)
    given[np.argsort(given - wanted, kind="stable")[: total - given.sum()]] += 1
    return given


def diameters_m(sizes: Sequence[SizeInterval], total: int, generator: np.random.Generator) -> Array:
    """``total`` diameters, class by class."""
    rows = zip(sizes, counts(sizes, total), strict=True)
    return np.concatenate([generator.uniform(r.smallest_m, r.largest_m, n) for r, n in rows])


def mean_mass_kg(sizes: Sequence[SizeInterval], density_kg_per_m3: float) -> float:
    """Of a particle: a class with mass share p has p / (its mean mass) of the number."""
    each_kg = density_kg_per_m3 * sphere_volume_m3(1.0) * mean_cube_m3(sizes)
    return float(1.0 / np.sum(shares(sizes) / each_kg))
