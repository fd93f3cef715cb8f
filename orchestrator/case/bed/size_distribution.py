"""The size distributions of spheres, by mass: the classes of a block or feed, and sizes drawn from them.

A case gives sizes as classes or as a cumulative curve, the smallest size that it wants to compute, and the
size below which only a sample of a feed's particles is computed.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from orchestrator.case.tables.bed import Feed, Filling, PassingPoint, SizeClass
from orchestrator.ports import Array, Indices
from orchestrator.ports.grains import Grain, Grains

RANGES = 10  # of the sizes of particles that are given one by one
FINEST_STEP = 1.2  # A curve is cut into classes whose limits have at most this ratio.


class CurveClass(SizeClass):
    """A class along a curve, which is straight between its points: its mass is spread evenly."""

    MASS_POWER = 1


def classes(source: Filling) -> tuple[SizeClass, ...]:
    """Return the classes of a source without faults that are computed; their shares add up to 1."""
    rows = _computed_classes(source)
    total = sum(row.mass_fraction for row in rows)
    return tuple(row.times(1.0 / total, "mass_fraction") for row in rows)


def share_left_out(source: Filling) -> float:
    """Return the share of the mass that does not come: it is finer than ``smallest_fed_m``, or a sample does
    not compute it, and no other class takes it over."""
    if source.finer == "next-class" or (source.smallest_fed_m is None and _sampled_below_m(source) == 0.0):
        return 0.0
    return max(0.0, 1.0 - sum(row.mass_fraction for row in _computed_classes(source)))


def finer_share(source: Filling) -> float:
    """Return the share of the mass that is finer than ``smallest_fed_m``."""
    limit_m = source.smallest_fed_m or 0.0
    return sum(row.mass_fraction * (1.0 - coarser_share(row, limit_m)) for row in given_classes(source))


@dataclass(frozen=True)
class Sample:
    """The classes of a feed of which only some particles are computed.

    ``share`` is their share of the feed's mass, ``computed`` how much of that is computed, and ``one_in`` of
    how many particles one is computed, in the coarsest and in the finest of these classes.
    """

    sizes: tuple[SizeClass, ...]
    share: float
    computed: float
    one_in: tuple[float, float]

    @property
    def in_words(self) -> str:
        """What is sampled, and how many particles stand for all."""
        low_mm = 1e3 * min(row.smallest_m for row in self.sizes)
        high_mm = 1e3 * max(row.largest_m for row in self.sizes)
        one_in = " to ".join(dict.fromkeys(f"{number:.3g}" for number in self.one_in))
        return (
            f"of the particles of {low_mm:.3g} to {high_mm:.3g} mm ({self.share:.1%} of the mass) "
            f"one in {one_in} is computed"
        )


def sample_of(source: Filling) -> Sample | None:
    """Return what a source samples; None if all particles are computed."""
    pairs = [(row, part) for row, part in _limited_classes(source) if part < 1.0]
    if not pairs:
        return None
    return Sample(
        sizes=tuple(row for row, _ in pairs),
        share=sum(row.mass_fraction for row, _ in pairs),
        computed=sum(row.mass_fraction * part for row, part in pairs),
        one_in=(1.0 / max(part for _, part in pairs), 1.0 / min(part for _, part in pairs)),
    )


def coarser_share(row: SizeClass, limit_m: float) -> float:
    """Return the share of a class's mass that is as large as a limit."""
    if limit_m <= row.smallest_m:
        return 1.0
    if limit_m >= row.largest_m:
        return 0.0
    finer = (np.array([limit_m, row.smallest_m]) / row.largest_m) ** row.MASS_POWER
    return float((1.0 - finer[0]) / (1.0 - finer[1]))


def share_between(row: SizeClass, low_m: float, high_m: float) -> float:
    """Return the share of a class's mass from one size up to another.

    A class with one size is inside or outside as a whole.
    """
    return coarser_share(row, low_m) - coarser_share(row, high_m)


def faults(source: Filling) -> Iterator[tuple[str, str, str]]:
    """Yield the key, a description and a remedy of each fault of a source."""
    if bool(source.sizes) == bool(source.curve):
        key = "curve" if source.sizes else "sizes"
        yield key, "contradicts sizes" if source.sizes else "missing", "give sizes or a curve"
        return
    if source.curve:
        yield from _faults_of_curve(source.curve)
    largest_m = max((row.largest_m for row in source.sizes), default=0.0)
    largest_m = max([largest_m, *(point.sieve_size_m for point in source.curve)])
    if source.smallest_fed_m is not None and source.smallest_fed_m >= largest_m:
        yield "smallest_fed_m", f"nothing is as large as {source.smallest_fed_m:g} m", ""
        return
    if isinstance(source, Feed):
        yield from _faults_of_sample(source, largest_m)


def _faults_of_sample(feed: Feed, largest_m: float) -> Iterator[tuple[str, str, str]]:
    """Yield the key, a description and a remedy of each fault of what a feed samples."""
    below_m, as_m = feed.sampled_below_m, feed.sampled_as_m
    if below_m is None:
        if as_m is not None:
            yield "sampled_as_m", "has no effect without sampled_below_m", "add that, or remove this key"
        return
    if as_m is not None and as_m < below_m:
        what = f"{as_m:g} m is less than sampled_below_m = {below_m:g} m"
        yield "sampled_as_m", what, "a sample has fewer particles than there are, not more"
    finest_m = max(feed.smallest_fed_m or 0.0, min(row.smallest_m for row in given_classes(feed)))
    if below_m <= finest_m:
        yield "sampled_below_m", f"nothing that is computed is finer than {below_m:g} m", ""
    if below_m > largest_m and feed.finer == "next-class":
        what = f"nothing is as large as {below_m:g} m, so that no class takes over what is not computed"
        yield "sampled_below_m", what, 'sample less, or take finer = "leave-out"'


def _faults_of_curve(points: Sequence[PassingPoint]) -> Iterator[tuple[str, str, str]]:
    """Yield the key, a description and a remedy of each fault of a cumulative curve."""
    size_m = [point.sieve_size_m for point in points]
    passing = [point.passing for point in points]
    if len(points) < 2 or not (np.diff(size_m) > 0).all() or not (np.diff(passing) >= 0).all():
        yield "curve", "is not a rising curve of two points or more", "from fine to coarse"
    elif passing[0] != 0 or abs(passing[-1] - 1) > 1e-6:
        what = f"goes from {passing[0]:g} to {passing[-1]:g}, not from 0 to 1"
        yield "curve", what, "begin with a size that nothing passes, end with the largest"


def given_classes(source: Filling) -> list[SizeClass]:
    """Return the size classes as the source gives them, or narrow classes along its curve.

    Particles finer than ``smallest_fed_m`` are among them.
    """
    if source.sizes:
        return list(source.sizes)
    return [
        row
        for fine, coarse in pairwise(source.curve)
        if (share := coarse.passing - fine.passing) > 0
        for row in _segment(fine.sieve_size_m, coarse.sieve_size_m, share)
    ]


def _segment(fine_m: float, coarse_m: float, share: float) -> list[SizeClass]:
    """Return narrow classes along a straight piece of the curve, whose mass is spread evenly over d."""
    count = max(1, int(np.ceil(np.log(coarse_m / fine_m) / np.log(FINEST_STEP))))
    limits_m = np.geomspace(fine_m, coarse_m, count + 1)
    shares = share * np.diff(limits_m) / (coarse_m - fine_m)
    return [
        CurveClass(smallest_m=float(low), largest_m=float(high), mass_fraction=float(part))
        for (low, high), part in zip(pairwise(limits_m), shares, strict=True)
    ]


def classes_of_grains(grains: Grains) -> tuple[SizeClass, ...]:
    """Return at most ``RANGES`` classes of given grains, which have one density.

    The limits of a class are the smallest and the largest of its particles.
    """
    size_m, volume = grains.sieve_size_m, grains.volume_m3
    number = np.digitize(size_m, np.geomspace(size_m.min(), size_m.max(), RANGES + 1)[1:-1])
    parts = [number == k for k in np.unique(number)]
    return tuple(
        size_class(size_m[part].min(), size_m[part].max(), volume[part].sum() / volume.sum())
        for part in parts
    )


def size_class(smallest_m: float, largest_m: float, mass_fraction: float) -> SizeClass:
    """Return a size class with these limits and this share of the mass."""
    return SizeClass(
        smallest_m=float(smallest_m), largest_m=float(largest_m), mass_fraction=float(mass_fraction)
    )


def _computed_classes(source: Filling) -> list[SizeClass]:
    """Return the classes with the mass that is computed, without particles finer than ``smallest_fed_m``.

    If the source wants it (``finer``), the finest class of which all particles are computed takes over the
    mass of those that are not.
    """
    pairs = _limited_classes(source)
    rows = [row if part == 1.0 else row.times(part, "mass_fraction") for row, part in pairs]
    whole = [number for number, (_, part) in enumerate(pairs) if part == 1.0]
    if source.finer == "next-class" and whole:
        first = min(whole, key=lambda number: rows[number].smallest_m)
        sample = sample_of(source)
        others = 0.0 if sample is None else sample.share - sample.computed
        more = rows[first].mass_fraction + finer_share(source) + others
        rows[first] = rows[first].model_copy(update={"mass_fraction": more})
    return rows


def _limited_classes(source: Filling) -> list[tuple[SizeClass, float]]:
    """Return the classes without particles finer than ``smallest_fed_m``.

    Each has the share of its particles that is computed, which is less than 1 for those that are sampled.
    """
    below_m, as_m = _sampled_below_m(source), _sampled_as_m(source)
    pairs: list[tuple[SizeClass, float]] = []
    for given in given_classes(source):
        row = _between(given, source.smallest_fed_m or 0.0, math.inf)
        fine = row and _between(row, 0.0, below_m)
        if fine:
            pairs.append((fine, min(1.0, float(mean_cube_m3([fine])[0]) / as_m**3)))
        if coarse := row and _between(row, below_m, math.inf):
            pairs.append((coarse, 1.0))
    return pairs


def _between(row: SizeClass, low_m: float, high_m: float) -> SizeClass | None:
    """Return the part of a class from one size up to another, with its mass; None if it is empty."""
    share = share_between(row, low_m, high_m)
    if share <= 0.0:
        return None
    limits = {"smallest_m": max(row.smallest_m, low_m), "largest_m": min(row.largest_m, high_m)}
    return row.model_copy(update=limits | {"mass_fraction": row.mass_fraction * share})


def _sampled_below_m(source: Filling) -> float:
    """Return the size below which particles are sampled; 0 if none are."""
    return (source.sampled_below_m or 0.0) if isinstance(source, Feed) else 0.0


def _sampled_as_m(source: Filling) -> float:
    """Return the size of particles of which there would be as many as a sample has."""
    own_m = source.sampled_as_m if isinstance(source, Feed) else None
    return own_m or _sampled_below_m(source)


def shares(sizes: Sequence[SizeClass]) -> Array:
    """Return the mass share of each class, (classes,).

    Raises ValueError if a smallest size exceeds the largest, or if the shares do not add up to 1.
    """
    for row in sizes:
        if row.smallest_m > row.largest_m:
            raise ValueError(f"size class from {row.smallest_m} to {row.largest_m} m")
    share = np.array([row.mass_fraction for row in sizes])
    if abs(share.sum() - 1.0) > 1e-6:
        raise ValueError(f"mass fractions must add up to 1, got {share.tolist()}")
    return np.asarray(share / share.sum())


def mean_cube_m3(sizes: Sequence[SizeClass]) -> Array:
    """Return the mean of the cubed size in each class, (classes,)."""
    low, high, power = np.array([(row.smallest_m, row.largest_m, row.MASS_POWER) for row in sizes]).T
    even_mass = 2.0 * low**2 * high**2 / (low + high)  # (b - a) / ((1/a^2 - 1/b^2) / 2)
    even_number = (low**2 + high**2) * (low + high) / 4.0  # (b^4 - a^4) / (4 (b - a))
    return np.where(power == CurveClass.MASS_POWER, even_mass, even_number)


def counts(sizes: Sequence[SizeClass], total: int) -> Indices:
    """Return the number of particles in each class, (classes,), which add up to ``total``.

    The numbers are as near to the classes' shares of the mass as whole numbers allow (method of the
    largest remainders).
    """
    number = shares(sizes) / mean_cube_m3(sizes)
    wanted = total * number / number.sum()
    given: Indices = np.floor(wanted).astype(np.int64)
    given[np.argsort(given - wanted, kind="stable")[: total - given.sum()]] += 1
    return given


def random_sizes_m(sizes: Sequence[SizeClass], total: int, generator: np.random.Generator) -> Array:
    """Return ``total`` random sizes, class by class."""
    rows = zip(sizes, counts(sizes, total), strict=True)
    return np.concatenate([size_m(row, generator.random(number)) for row, number in rows])


def size_m(row: SizeClass, share: Array) -> Array:
    """Return the sizes below which these shares of the number of a class's particles lie, (n,) each."""
    power = row.MASS_POWER - 3.0  # a particle's mass goes with the third power
    finest, coarsest = row.smallest_m**power, row.largest_m**power
    return np.asarray((finest + share * (coarsest - finest)) ** (1.0 / power))


def median_size_m(sizes: Sequence[SizeClass]) -> float:
    """Return the size below which half of the mass lies.

    The classes may overlap, and their mass fractions may add up to any sum.
    """
    half, finer_m = sum(row.mass_fraction for row in sizes) / 2, 0.0

    def missing(limit_m: float) -> float:
        """Return what the mass below a size lacks of the half."""
        return half - sum(row.mass_fraction * share_between(row, 0.0, limit_m) for row in sizes)

    for limit_m in sorted({limit_m for row in sizes for limit_m in (row.smallest_m, row.largest_m)}):
        if missing(limit_m) <= 0.0:
            coarser_m = limit_m
            while finer_m < (middle_m := (finer_m + coarser_m) / 2) < coarser_m:  # to the last bit
                if missing(middle_m) > 0.0:
                    finer_m = middle_m
                else:
                    coarser_m = middle_m
            return coarser_m
        equal = sum(row.mass_fraction for row in sizes if row.smallest_m == row.largest_m == limit_m)
        if missing(limit_m) <= equal:
            return limit_m
        finer_m = limit_m
    raise ValueError("no size classes")


def mean_mass_kg(sizes: Sequence[SizeClass], grain: Grain[float]) -> float:
    """Return the mean mass of particles like one ``grain``.

    The number of particles in a class is proportional to (its mass share) / (its mean mass).
    """
    each_kg = grain.resized(1.0).mass_kg * mean_cube_m3(sizes)
    return float(1.0 / np.sum(shares(sizes) / each_kg))
