"""The screening results of the whole feed, with the sizes that are too fine to be computed.

A feed lists all of its sizes, and ``smallest_fed_m`` leaves out those that would be too many particles.  The
partition curve of the computed fines is continued to the finer ones.  In a part of the deck, particles of
one size d make N attempts to pass openings of width a, whose chance falls with their size,

    share that stays above = (1 - p (1 - d / a)^sigma)^N.

The chance of the finest is the open share p of the panels (Gaudin, Principles of Mineral Dressing, 1939, with
sigma = 2).  For many attempts this is exp(-p N (1 - d / a)^sigma), the form of Ferrara, Preti and Schena
(International Journal of Mineral Processing 22, 1988, 193-222).  N and sigma are those that most likely give
the numbers of particles that left (McCullagh and Nelder, Generalized Linear Models, 2nd ed., 1989, ch. 4).

The error of the continuation is tested on the computed fines: the curve of their coarser half is continued to
the finer half.  The test holds over a factor of ``TESTED_FACTOR`` in size.  Of finer ones it is only taken
that they pass at least as well as those of that size.  docs/theory/screening.md has the definitions.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy.optimize import minimize
from scipy.special import roots_legendre

from orchestrator.case.bed.size_distribution import coarser_share, given_classes
from orchestrator.case.tables.bed import Feed
from orchestrator.figures.estimate import Estimate
from orchestrator.figures.material import Continuation, Curve, WholeFeed, WholeFeedSection
from orchestrator.output.results.estimate import share
from orchestrator.output.results.events import LOST, UNDERSIZE, Events
from orchestrator.output.results.listed_feed import ListedFeed, feed_parts, listed_feed, mass_between
from orchestrator.ports import Array

BINS = 12
NUMBER, MASS = 0, 1
NODES = 16  # of the quadrature over the sizes of a class
LIMITS = ((-7.0, 7.0), (0.0, 20.0))  # of log N and sigma
TESTED_FACTOR = 2.0  # over which the error of continued curves was measured (docs/measured/screening.md)
LARGEST_ERROR = 25.0  # points: an interval of so much to either side holds half of all answers
NO_TEST = "the coarser half of the fines that left determines no curve: the error of continuing it is unknown"


@dataclass(frozen=True)
class PartitionCurve:
    """The share of each size that stays above: (1 - open_share (1 - d / opening_m)^exponent)^attempts."""

    attempts: float
    exponent: float
    opening_m: float
    open_share: float

    def passed(self, size_m: Array) -> Array:
        """Return the shares that pass, of particles with these sizes; 0 for those that are too large."""
        free = np.clip(1.0 - np.asarray(size_m) / self.opening_m, 0.0, None)
        chance = self.open_share * free**self.exponent
        return np.asarray(np.where(free > 0.0, -np.expm1(self.attempts * np.log1p(-chance)), 0.0))


def fit_partition(
    size_m: Array, under: Array, over: Array, opening_m: float, open_share: float
) -> PartitionCurve | None:
    """Return the curve that most likely gives the numbers of particles (sizes,) that passed and stayed above.

    Return None if they do not determine it: all or none of them passed, or all are of one size.
    """
    there = (under + over > 0) & (size_m < opening_m)
    passed, kept = under[there], over[there]
    log_free = np.log(1.0 - size_m[there] / opening_m)
    if not (passed.any() and kept.any() and np.ptp(log_free) > 1e-6):
        return None

    def unlikelihood(coefficients: Array) -> tuple[float, Array]:
        attempts, chance = np.exp(coefficients[0]), open_share * np.exp(coefficients[1] * log_free)
        hazard = -attempts * np.log1p(-chance)
        share_passed = np.maximum(-np.expm1(-hazard), 1e-300)
        slope = kept - passed * np.exp(-hazard) / share_passed
        value = float(kept @ hazard - passed @ np.log(share_passed))
        return value, np.array([slope @ hazard, slope @ (attempts * chance / (1 - chance) * log_free)])

    start = -np.log(open_share), 1.0
    best = minimize(unlikelihood, start, jac=True, method="L-BFGS-B", bounds=LIMITS, tol=1e-14)
    return PartitionCurve(float(np.exp(best.x[0])), float(best.x[1]), opening_m, open_share)


@dataclass(frozen=True)
class FeedFines:
    """The fines of feeds, below ``cut_m``, as shares of the feeds' mass.

    The fines that are not computed have the sizes ``size_m`` (n,) and the shares ``share`` (n,).
    """

    cut_m: float
    listed: ListedFeed
    size_m: Array
    share: Array

    @property
    def left_out(self) -> float:
        """The share of the mass that is finer than what is computed."""
        return float(self.share.sum())

    @property
    def smallest_m(self) -> float:
        """The finest size that the feeds list."""
        return min(row.smallest_m for row, _ in self.listed.given)

    @property
    def smallest_computed_m(self) -> float:
        """The finest size that is computed."""
        return min(row.smallest_m for row, _ in self.listed.computed)

    @property
    def total(self) -> float:
        """The share of the mass that is fine."""
        return mass_between(self.listed.given, 0.0, self.cut_m)

    def in_doubt(self, curve: PartitionCurve) -> float:
        """Return the share of all fines by which the curve may be wrong on sizes beyond its tested reach.

        At least as many of them pass as of the finest size within reach, and at most all.
        """
        least_m = self.smallest_computed_m / TESTED_FACTOR
        beyond = self.size_m < least_m
        passed, least = curve.passed(self.size_m[beyond]), float(curve.passed(np.array(least_m)))
        return float(self.share[beyond] @ np.maximum(passed - least, 1.0 - passed)) / self.total

    def passed(self, computed: float, curve: PartitionCurve) -> float:
        """Return the share of all fines that pass, if ``computed`` of those do whose sizes are computed."""
        finer = float(self.share @ curve.passed(self.size_m))
        return ((self.total - self.left_out) * computed + finer) / self.total


def feed_fines(
    feeds: Sequence[Feed], cut_m: float, window_s: tuple[float, float] = (0.0, math.inf)
) -> FeedFines:
    """Return the fines, below ``cut_m``, of feeds that are mixed by what they feed in a window of time."""
    nodes, weights = roots_legendre(NODES)
    size_m, shares = [np.empty(0)], [np.empty(0)]
    for feed, part in zip(feeds, feed_parts(feeds, window_s), strict=True):
        limit_m = min(feed.smallest_fed_m or 0.0, cut_m)
        for row in given_classes(feed) if part else ():
            if (coarser := coarser_share(row, limit_m)) < 1.0:
                low, high = row.smallest_m, min(row.largest_m, limit_m)
                sizes = (low + high) / 2 + nodes * (high - low) / 2
                mass = weights * sizes ** (row.MASS_POWER - 1)
                size_m.append(sizes)
                shares.append(part * row.mass_fraction * (1.0 - coarser) * mass / mass.sum())
    listed = listed_feed(feeds, window_s)
    return FeedFines(cut_m, listed, np.concatenate(size_m), np.concatenate(shares))


def whole_feed(events: Events, fines: FeedFines, opening_m: float, open_share: float) -> WholeFeed | str:
    """Return the separation of the whole feed, and the curve by which its fines are completed.

    ``opening_m`` is the smaller side of the openings, which are all alike, and ``open_share`` their share of
    the panels.  The half widths have the error of continuing the curve, too.  Return the reason instead if
    the particles that left do not test it, or if the error is too large.
    """
    undersize = events.exits.of(UNDERSIZE)
    mean_m, sums = _numbers_and_masses(events, fines)
    last, finer = len(undersize), slice(0, BINS // 2)
    all_left = sums[events.window].sum(axis=0)

    def fit(left: Array, count: int, classes: slice) -> PartitionCurve | None:
        under = left[classes, undersize[:count], NUMBER].sum(axis=1)
        over = left[classes, :, NUMBER].sum(axis=1) - under
        return fit_partition(mean_m[classes], under, over, opening_m, open_share)

    def placement(count: int, left: Array) -> float:
        """Return the share of all fines that pass in the first ``count`` sections."""
        curve, mass_kg = fit(left, count, slice(0, BINS)), left[:BINS, :, MASS]
        computed = share(mass_kg[:, undersize[:count]].sum(), mass_kg.sum())
        return float("nan") if curve is None else 100.0 * fines.passed(computed, curve)

    def tested_error(count: int) -> float:
        """Return by how much of the finer half the curve of the coarser half lets too much pass."""
        curve, mass_kg = fit(all_left, count, slice(BINS // 2, BINS)), all_left[finer, :, MASS]
        if curve is None:
            return float("nan")
        too_much = mass_kg.sum(axis=1) @ curve.passed(mean_m[finer]) - mass_kg[:, undersize[:count]].sum()
        return share(too_much, mass_kg.sum())

    def efficiency(left: Array) -> float:
        coarse_kg = left[BINS, :, MASS]
        passed = float(coarse_kg[undersize].sum() / coarse_kg.sum()) if coarse_kg.any() else 0.0
        return placement(last, left) - 100.0 * passed

    def section_yield(place: int, left: Array) -> float:
        before = placement(place, left) if place else 0.0
        return fines.total * (placement(place + 1, left) - before)

    tested = np.array([0.0, *(tested_error(count) for count in range(1, last + 1))])
    if not np.isfinite(tested[last]):
        return NO_TEST
    reach = math.log(fines.smallest_computed_m / fines.smallest_m)
    told_reach = min(reach, math.log(TESTED_FACTOR))
    tested_reach = math.log(fines.cut_m / fines.smallest_computed_m) / 2
    told = 100.0 * fines.left_out / fines.total * tested * (told_reach / tested_reach) ** 2
    curves = [fit(all_left, count, slice(0, BINS)) for count in range(1, last + 1)]
    doubt = 100.0 * np.array([0.0, *(np.nan if each is None else fines.in_doubt(each) for each in curves)])
    error = told + np.copysign(doubt, told)
    if abs(error[last]) > LARGEST_ERROR:
        computed_mm, listed_mm = 1e3 * fines.smallest_computed_m, 1e3 * fines.smallest_m
        return (
            f"its curve, continued from {computed_mm:.3g} to {listed_mm:.3g} mm, may be wrong by "
            f"{abs(error[last]):.0f} points of the fines, as its own finer half tells; "
            "compute more of them (smallest_fed_m)"
        )

    def figure(statistic: Callable[[Array], float], error: float) -> Estimate:
        """Return an estimate whose interval has the error of the continuation, too."""
        found = events.figure(statistic, sums)
        width = found.half_width
        wider = None if width is None or not np.isfinite(error) else width + abs(error)
        return replace(found, half_width=wider)

    sections = [
        WholeFeedSection(
            exit=events.exits.names[number],
            cumulative_efficiency_percent=figure(partial(placement, place + 1), error[place + 1]),
            yield_percent=figure(
                partial(section_yield, place),
                fines.total * (abs(told[place + 1] - told[place]) + max(doubt[place : place + 2])),
            ),
        )
        for place, number in enumerate(undersize)
    ]
    curve = curves[-1]
    return WholeFeed(
        left_out_percent=100.0 * fines.left_out,
        smallest_m=fines.smallest_m,
        smallest_computed_m=fines.smallest_computed_m,
        fines_percent=100.0 * fines.total,
        fine_placement_percent=figure(partial(placement, last), error[last]),
        efficiency_percent=figure(efficiency, error[last]),
        continuation=Continuation(
            factor=math.exp(reach),
            tested_factor=math.exp(tested_reach),
            tested_error_percent=float(100.0 * tested[last]),
            error_percent=float(error[last]),
        ),
        sections=sections,
        curve=None if curve is None else _course(curve, min(*fines.size_m, *mean_m)),
    )


def _course(curve: PartitionCurve, smallest_m: float) -> Curve:
    """Return the curve's numbers, and its course from a size to the openings' width."""
    size_m = np.linspace(smallest_m, curve.opening_m, 41)
    return Curve(
        attempts=curve.attempts,
        exponent=curve.exponent,
        opening_m=curve.opening_m,
        open_share=curve.open_share,
        sieve_size_m=size_m,
        oversize_percent=100.0 * (1.0 - curve.passed(size_m)),
    )


def _numbers_and_masses(events: Events, fines: FeedFines) -> tuple[Array, Array]:
    """Return the mean size (bins,) of fine particles, and what left by size and exit, part by part.

    The latter are numbers and masses, (parts, bins + 1, exits, 2); the last size is all that is coarse.
    Masses are those for which the particles stand in the feed as it is listed.
    """
    removed, exits = events.removed, len(events.exits.names)
    left = removed.exit != LOST
    fine = left & (removed.sieve_size_m < fines.cut_m)
    size_m = removed.sieve_size_m[fine]
    edges_m = np.geomspace(size_m.min(), fines.cut_m, BINS + 1)
    size = np.where(fine, np.searchsorted(edges_m[1:-1], removed.sieve_size_m, side="right"), BINS)
    number = np.bincount(size[fine], minlength=BINS)
    summed_m = np.bincount(size[fine], size_m, BINS)
    mean_m = np.divide(summed_m, number, out=np.sqrt(edges_m[1:] * edges_m[:-1]), where=number > 0)
    group = np.where(left, exits * size + removed.exit, -1)
    tables = [events.sums(each, group, (BINS + 1) * exits) for each in (np.ones(len(group)), events.left_kg)]
    return mean_m, np.stack(tables, axis=-1).reshape(-1, BINS + 1, exits, 2)
