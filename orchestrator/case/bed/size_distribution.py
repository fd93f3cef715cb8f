"""Size distributions of spheres, by mass: what a block or a feed is made of, and diameters drawn
from it.  Sizes are given as classes or as a cumulative curve, without what is finer than wanted."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from orchestrator.case.tables import bed
from orchestrator.ports import Array, Indices
from orchestrator.ports.physics import sphere_volume_m3

FINEST_STEP = 1.2  # ratio of the limits of the classes that a curve is cut into, at most


@dataclass(frozen=True)
class Class:
    """Diameters evenly spread between two limits, and their share of the mass."""

    smallest_m: float
    largest_m: float
    mass_fraction: float


Source = bed.Block | bed.Feed


def classes(source: Source) -> tuple[Class, ...]:
    """The classes that are fed; their shares add up to 1.  For a source without faults."""
    kept = _kept(source)
    total = sum(row.mass_fraction for row in kept)
    return tuple(replace(row, mass_fraction=row.mass_fraction / total) for row in kept)


def share_left_out(source: Source) -> float:
    """Of the mass, because it is finer than ``smallest_fed_m`` and not moved to the next class."""
    if source.smallest_fed_m is None or source.finer == "next-class":
        return 0.0
    return max(0.0, 1.0 - sum(row.mass_fraction for row in _kept(source)))


def finer_share(source: Source) -> float:
    """Of the mass, finer than ``smallest_fed_m``."""
    limit_m = source.smallest_fed_m or 0.0
    return sum(row.mass_fraction * (1.0 - _coarser(row, limit_m)) for row in _given(source))


def faults(source: Source) -> Iterator[tuple[str, str, str]]:
    """Key, what is wrong with it, and what to do about it."""
    if bool(source.sizes) == bool(source.curve):
        key = "curve" if source.sizes else "sizes"
        yield key, "contradicts sizes" if source.sizes else "missing", "give sizes or a curve"
        return
    if source.curve:
        yield from _faults_of_curve(source.curve)
    largest_m = max((row.largest_m for row in source.sizes), default=0.0)
    largest_m = max([largest_m, *(point.diameter_m for point in source.curve)])
    if source.smallest_fed_m is not None and source.smallest_fed_m >= largest_m:
        yield "smallest_fed_m", f"nothing is as large as {source.smallest_fed_m:g} m", ""


def _faults_of_curve(points: Sequence[bed.PassingPoint]) -> Iterator[tuple[str, str, str]]:
    diameter_m = [point.diameter_m for point in points]
    passing = [point.passing for point in points]
    if len(points) < 2 or not (np.diff(diameter_m) > 0).all() or not (np.diff(passing) >= 0).all():
        yield "curve", "is no rising curve of two points or more", "from fine to coarse"
    elif passing[0] != 0 or abs(passing[-1] - 1) > 1e-6:
        what = f"goes from {passing[0]:g} to {passing[-1]:g}, not from 0 to 1"
        yield "curve", what, "begin with a diameter that nothing passes, end with the largest"


def _given(source: Source) -> list[Class]:
    if source.sizes:
        return [Class(row.smallest_m, row.largest_m, row.mass_fraction) for row in source.sizes]
    found = []
    for fine, coarse in zip(source.curve, source.curve[1:], strict=False):
        share = coarse.passing - fine.passing
        if share > 0:
            found += _segment(fine.diameter_m, coarse.diameter_m, share)
    return found


def _segment(fine_m: float, coarse_m: float, share: float) -> list[Class]:
    """Narrow classes along a straight piece of the curve: their mass is spread evenly in d."""
    count = max(1, int(np.ceil(np.log(coarse_m / fine_m) / np.log(FINEST_STEP))))
    limits_m = np.geomspace(fine_m, coarse_m, count + 1)
    shares = share * np.diff(limits_m) / (coarse_m - fine_m)
    rows = zip(limits_m, limits_m[1:], shares, strict=False)
    return [Class(float(a), float(b), float(part)) for a, b, part in rows]


def _kept(source: Source) -> list[Class]:
    given, limit_m = _given(source), source.smallest_fed_m or 0.0
    kept = [
        Class(max(row.smallest_m, limit_m), row.largest_m, row.mass_fraction * coarser)
        for row in given
        if (coarser := _coarser(row, limit_m)) > 0
    ]
    if source.finer == "next-class" and kept:
        first = min(range(len(kept)), key=lambda k: kept[k].smallest_m)
        more = kept[first].mass_fraction + finer_share(source)
        kept[first] = replace(kept[first], mass_fraction=more)
    return kept


def _coarser(row: Class, limit_m: float) -> float:
    """Share of a class's mass that is coarser: diameters are evenly spread by number."""
    if limit_m <= row.smallest_m:
        return 1.0
    if limit_m >= row.largest_m:
        return 0.0
    powers = row.largest_m**4 - np.array([limit_m, row.smallest_m]) ** 4
    return float(powers[0] / powers[1])


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
