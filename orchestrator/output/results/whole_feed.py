"""The screening results of the whole feed, with the sizes that are too fine to be computed.

A feed lists all of its sizes, and ``smallest_fed_m`` leaves out those that would be too many particles.  The
partition curve of the computed fines is continued to the finer ones.  In a part of the deck, particles of
one size d pass openings of width a at a rate that falls with their size,

    share that stays above = exp(-K (1 - d / a)^sigma),

the form of Ferrara, Preti and Schena (International Journal of Mineral Processing 22, 1988, 193-222).  K and
sigma are those that most likely give the numbers of particles that left: a binomial regression with the
complementary log-log link (McCullagh and Nelder, Generalized Linear Models, 2nd ed., 1989, section 4.3).
docs/theory/screening.md has its limits.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import minimize
from scipy.special import roots_legendre

from orchestrator.case.bed.size_distribution import coarser_share, given_classes
from orchestrator.case.tables.bed import Feed
from orchestrator.output.results.estimate import Estimate, share
from orchestrator.output.results.events import LOST, UNDERSIZE, Events, per_cycle
from orchestrator.ports import Array

BINS = 12
NUMBER, MASS = 0, 1
NODES = 16  # of the quadrature over the diameters of a class
LIMITS = ((-7.0, 7.0), (0.0, 20.0))  # of log K and sigma


@dataclass(frozen=True)
class PartitionCurve:
    """The share of each size that stays above the deck: exp(-rate (1 - d / opening_m)^exponent)."""

    rate: float
    exponent: float
    opening_m: float

    def passed(self, diameter_m: Array) -> Array:
        """Return the shares that pass, of particles with these diameters; 0 for those that are too large."""
        free = np.clip(1.0 - np.asarray(diameter_m) / self.opening_m, 0.0, None)
        return np.asarray(np.where(free > 0.0, -np.expm1(-self.rate * free**self.exponent), 0.0))


def fit_partition(diameter_m: Array, under: Array, over: Array, opening_m: float) -> PartitionCurve | None:
    """Return the curve that most likely gives the numbers of particles (sizes,) that passed and stayed above.

    Return None if they do not determine it: all or none of them passed, or all are of one size.
    """
    there = (under + over > 0) & (diameter_m < opening_m)
    passed, kept = under[there], over[there]
    log_free = np.log(1.0 - diameter_m[there] / opening_m)
    if not (passed.any() and kept.any() and np.ptp(log_free) > 1e-6):
        return None

    def unlikelihood(coefficients: Array) -> tuple[float, Array]:
        hazard = np.exp(coefficients[0] + coefficients[1] * log_free)
        share_passed = np.maximum(-np.expm1(-hazard), 1e-300)
        slope = hazard * (kept - passed * np.exp(-hazard) / share_passed)
        value = float(kept @ hazard - passed @ np.log(share_passed))
        return value, np.array([slope.sum(), slope @ log_free])

    best = minimize(unlikelihood, (0.0, 1.0), jac=True, method="L-BFGS-B", bounds=LIMITS, tol=1e-14)
    return PartitionCurve(float(np.exp(best.x[0])), float(best.x[1]), opening_m)


@dataclass(frozen=True)
class FeedFines:
    """The fines that feeds list, as shares of the feeds' mass.

    ``computed`` is the share of the fines that are computed.  The others have the diameters ``diameter_m``
    (n,) and the shares ``share`` (n,).
    """

    computed: float
    diameter_m: Array
    share: Array

    @property
    def left_out(self) -> float:
        """The share of the mass that is not computed."""
        return float(self.share.sum())

    @property
    def total(self) -> float:
        """The share of the mass that is fine."""
        return self.computed + self.left_out

    def passed(self, computed: float, curve: PartitionCurve) -> float:
        """Return the share of all fines that pass, if ``computed`` of the computed ones do."""
        finer = float(self.share @ curve.passed(self.diameter_m))
        return (self.computed * computed + finer) / self.total


def feed_fines(feeds: Sequence[Feed], cut_m: float) -> FeedFines:
    """Return the fines, below ``cut_m``, of feeds that are mixed by their rates."""
    nodes, weights = roots_legendre(NODES)
    computed, diameter_m, shares = 0.0, [np.empty(0)], [np.empty(0)]
    total = sum(feed.rate_kg_per_s for feed in feeds)
    for feed in feeds:
        limit_m = min(feed.smallest_fed_m or 0.0, cut_m)
        for row in given_classes(feed):
            part = row.mass_fraction * feed.rate_kg_per_s / total
            coarser = coarser_share(row, limit_m)
            computed += part * (coarser - coarser_share(row, cut_m))
            if coarser < 1.0:
                low, high = row.smallest_m, min(row.largest_m, limit_m)
                sizes = (low + high) / 2 + nodes * (high - low) / 2
                mass = weights * sizes**3
                diameter_m.append(sizes)
                shares.append(part * (1.0 - coarser) * mass / mass.sum())
    return FeedFines(computed, np.concatenate(diameter_m), np.concatenate(shares))


def whole_feed(
    events: Events, fines: FeedFines, cut_m: float, opening_m: float, coarse_placement: float
) -> dict[str, Any]:
    """Return the separation of the whole feed, and the curve by which its fines are completed.

    ``opening_m`` is the smaller side of the largest openings, and ``coarse_placement`` the share of the
    computed coarse particles that stay above.  A figure is an estimate without a value where the particles
    that left do not determine the curve.
    """
    sections = events.exits.of(UNDERSIZE)
    mean_m, sums = _numbers_and_masses(events, cut_m)

    def up_to(count: int, left: Array) -> tuple[PartitionCurve | None, float]:
        """Return the curve of the first sections, and the share of the computed fines that pass there."""
        under, whole = left[:, sections[:count]].sum(axis=1), left.sum(axis=1)
        curve = fit_partition(mean_m, under[:, NUMBER], (whole - under)[:, NUMBER], opening_m)
        return curve, share(under[:, MASS].sum(), whole[:, MASS].sum())

    def placement(count: int, left: Array) -> float:
        curve, computed = up_to(count, left)
        return float("nan") if curve is None else fines.passed(computed, curve)

    def estimate(count: int, before: int = -1, scale: float = 100.0, less: float = 0.0) -> Estimate:
        def statistic(left: Array) -> float:
            earlier = placement(before, left) if before > 0 else 0.0
            return scale * (placement(count, left) - earlier) - less

        return events.figure(statistic, sums)

    last = len(sections)
    curve, _ = up_to(last, sums[events.window].sum(axis=0))
    smallest_m = min(float(fines.diameter_m.min()), float(mean_m.min()))
    diameter_m = np.linspace(smallest_m, opening_m, 41)
    return {
        "left_out_percent": 100.0 * fines.left_out,
        "fines_percent": 100.0 * fines.total,
        "fine_placement_percent": estimate(last),
        "efficiency_percent": estimate(last, less=100.0 * (1.0 - coarse_placement)),
        "sections": [
            {
                "exit": events.exits.names[number],
                "cumulative_efficiency_percent": estimate(place + 1),
                "yield_percent": estimate(place + 1, place, 100.0 * fines.total),
            }
            for place, number in enumerate(sections)
        ],
        "curve": None
        if curve is None
        else {
            "rate": curve.rate,
            "exponent": curve.exponent,
            "opening_m": opening_m,
            "diameter_m": diameter_m,
            "oversize_percent": 100.0 * (1.0 - curve.passed(diameter_m)),
        },
    }


def _numbers_and_masses(events: Events, limit_m: float) -> tuple[Array, Array]:
    """Return the mean diameter (bins,) of particles finer than a limit, and what left in each cycle.

    The latter are numbers and masses, (cycles, bins, exits, 2).
    """
    removed, exits = events.removed, len(events.exits.names)
    fine = (removed.diameter_m < limit_m) & (removed.exit != LOST)
    diameter_m = removed.diameter_m[fine]
    edges_m = np.geomspace(diameter_m.min(), limit_m, BINS + 1)
    size = np.clip(np.searchsorted(edges_m, removed.diameter_m, side="right") - 1, 0, BINS - 1)
    number = np.bincount(size[fine], minlength=BINS)
    summed_m = np.bincount(size[fine], diameter_m, BINS)
    mean_m = np.divide(summed_m, number, out=np.sqrt(edges_m[1:] * edges_m[:-1]), where=number > 0)
    group = np.where(fine, exits * size + removed.exit, -1)
    tables = [
        per_cycle(removed.time_s, each, events.edges_s, group, BINS * exits)
        for each in (np.ones(len(group)), removed.mass_kg)
    ]
    return mean_m, np.stack(tables, axis=-1).reshape(-1, BINS, exits, 2)
