"""Estimates with intervals: of chance, by the jackknife and slow cosines, or of the remaining drift.

The jackknife leaves out one batch of cycles at a time, which gives a series of values for any function of
sums, such as an efficiency (Miller, Biometrika 61, 1974, 1-15, doi 10.1093/biomet/61.1.1).  Successive
cycles of a machine are not independent: what a cycle lacks may be made up for by the next one, or a bed may
remember its past for many cycles.  The variance of the mean is therefore taken from the slow part of the
series alone, from its projections on the first cosines (Lazarus, Lewis, Stock and Watson, J. Business and
Economic Statistics 36, 2018, 541-559, doi 10.1080/07350015.2018.1506926).  Their squares are nearly
independent whatever the correlation is between neighbours, so that the interval is Student's with as many
degrees of freedom as there are cosines.

Without particles nothing is left to chance.  The interval then says how far the machine still drifts.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.special import ndtri, stdtrit

from orchestrator.figures.estimate import Estimate
from orchestrator.ports import Array, Indices

BATCHES = (20, 40)  # enough for the slow part of a series
FEWEST_CYCLES = 10
COSINES = 6  # the fewest whose interval is right within a factor of two in 95 % of all runs
FEWEST_INDEPENDENT = 5.0
SLOWEST_DECAY = 0.9  # of a drift, from each third of the cycles to the next
CONFIDENCE = 0.95
NORMAL_95 = 1.96  # a 95 % interval in standard deviations
ROUNDING = 1e-12  # of the largest value
TOO_FEW = "too few cycles for an interval"


@dataclass(frozen=True)
class Interval:
    """Half the width of an interval.

    ``half_width`` is None if it is not known, and ``reason`` says why.  ``standard_error`` is the standard
    deviation of the value; it is None where nothing is left to chance.
    """

    half_width: float | None
    standard_error: float | None = None
    reason: str = ""

    def times(self, factor: float) -> Interval:
        """Return an interval that is ``factor`` times as wide."""
        half_width, error = (size and factor * size for size in (self.half_width, self.standard_error))
        return Interval(half_width, error, self.reason)


IntervalOf = Callable[[Array], Interval]
"""A function that returns the interval of the mean of a series (batches,)."""


def unknown(values: Array) -> Interval:
    """Return the interval of a series that is too short for one."""
    return Interval(None, reason=TOO_FEW)


def batch_count(cycles: int) -> int:
    """Return the number of batches into which cycles are divided.

    It is the number within ``BATCHES`` that leaves the fewest cycles over, the larger one of two.  With few
    cycles, each cycle is a batch.
    """
    fewest, most = BATCHES
    return min(range(most, fewest - 1, -1), key=lambda count: cycles % count) if cycles > most else cycles


def batch_sums(per_cycle: Array) -> Array:
    """Return the sums (batches, ...) of values (cycles, ...) over equal batches of whole cycles.

    The first batch also has the cycles that are left over, so that all cycles count.
    """
    cycles = len(per_cycle)
    count = batch_count(cycles)
    first = cycles - cycles // count * np.arange(count, 0, -1)
    first[0] = 0
    return np.asarray(np.add.reduceat(per_cycle, first, axis=0))


def estimate(
    statistic: Callable[[Array], float], batches: Array, interval_of: IntervalOf | None = None
) -> Estimate:
    """Return the estimate of a statistic of the sum of ``batches`` (n, ...), by default with chance.

    The statistic must not depend on the number of batches: a mean must be a sum over a sum.  It is NaN if
    it is not defined.
    """
    total = batches.sum(axis=0)
    whole, n = statistic(total), len(batches)
    if not np.isfinite(whole):
        return Estimate(None)
    if n < 2:  # nothing is left without the only one
        return Estimate(float(whole), None, n, reason=TOO_FEW)
    without = np.array([statistic(total - batch) for batch in batches])
    if not np.isfinite(without).all():
        return Estimate(float(whole), None, n, reason=TOO_FEW)
    interval = (interval_of or chance)(n * whole - (n - 1) * without)
    return Estimate(
        float(whole), interval.half_width, n, standard_error=interval.standard_error, reason=interval.reason
    )


def mean(values: Array, interval_of: IntervalOf | None = None) -> Estimate:
    """Return the mean of values (cycles,), with its interval from batches."""
    ones = np.column_stack([values, np.ones(len(values))])
    return estimate(lambda sums: sums[0] / sums[1], batch_sums(ones), interval_of)


def mean_by_cycles(
    values: Array, cycle: Indices, is_steady: bool, interval_of: IntervalOf | None = None
) -> Estimate:
    """Return the mean of values (times,), where ``cycle`` (times,) is the number of each value's cycle.

    Every value counts alike, however many fall into its cycle.  In a steady state there is an interval.
    """
    return ratio_by_cycles(values, np.ones(len(values)), cycle, is_steady, interval_of)


def ratio_by_cycles(
    part: Array, whole: Array, cycle: Indices, is_steady: bool, interval_of: IntervalOf | None = None
) -> Estimate:
    """Return the sum of ``part`` over the sum of ``whole``, both (times,); no value if the latter is 0."""
    sums = np.array([_sum_by_cycle(part, cycle), _sum_by_cycle(whole, cycle)]).T
    if not is_steady:
        value = share(*sums.sum(axis=0))
        return Estimate(value if np.isfinite(value) else None)
    return estimate(lambda total: share(*total), batch_sums(sums), interval_of)


def _sum_by_cycle(values: Array, cycle: Indices) -> Array:
    index = np.unique(cycle, return_inverse=True)[1]
    return np.bincount(index, values).astype(float)


def share(part: float, whole: float) -> float:
    """Return the part over the whole; NaN if the whole is not positive."""
    return float(part) / float(whole) if whole > 0 else float("nan")


def counting_deviation(part: float, mass_kg: Array) -> float:
    """Return the standard deviation of a share by mass, ``part``, of particles that go one way or the other.

    ``mass_kg`` (particles,) are the masses of all of them.  Each goes its way by itself, so that their number
    counts; unequal masses count as fewer (Kish, Survey Sampling, Wiley 1965, section 11.7).
    """
    if not len(mass_kg):
        return float("nan")
    number = float(mass_kg.sum()) ** 2 / float(mass_kg @ mass_kg)
    return float(np.sqrt(max(part * (1.0 - part), 0.0) / number))


def chance(values: Array) -> Interval:
    """Return the 95 % confidence interval of the mean of a stationary series (n,).

    The variance of the mean is that of the projections on ``COSINES`` cosines, the slowest with half a period
    over the series.  Up to seven values it is Student's interval of independent ones.  Where the correlation
    between neighbours leaves the weight of fewer than ``FEWEST_INDEPENDENT`` independent values (first-order
    autoregression; Bayley and Hammersley, Suppl. J. R. Stat. Soc. 8, 1946, 184-197), no interval is known.
    The correlation is corrected for its bias of about -(1 + 3 r) / n.
    """
    n = len(values)
    if n < FEWEST_CYCLES:
        return unknown(values)
    spread = values - values.mean()
    squares = float(spread @ spread)
    if squares <= n * (ROUNDING * float(np.abs(values).max())) ** 2:
        return Interval(0.0, 0.0)
    r = (n * float(spread[1:] @ spread[:-1]) / squares + 1) / (n - 3)
    if n * (1 - r) < FEWEST_INDEPENDENT * (1 + r):
        return unknown(values)
    phase = np.pi / n * (np.arange(n) + 0.5)
    projections = np.cos(np.arange(1, COSINES + 1)[:, None] * phase) @ spread * (2 / n) ** 0.5
    error = float(np.sqrt(np.mean(projections**2) / n))
    return Interval(float(stdtrit(COSINES, (1 + CONFIDENCE) / 2)) * error, error)  # Student's distribution


def independent(values: Array) -> Interval:
    """Return the 95 % confidence interval of the mean of independent values (n,) of one distribution.

    Values that are all alike have none: so few of them do not show their scatter.
    """
    n = len(values)
    error = float(values.std(ddof=1)) / n**0.5
    if error <= ROUNDING * float(np.abs(values).max()):
        return Interval(None)
    return Interval(float(stdtrit(n - 1, (1 + CONFIDENCE) / 2)) * error, error)  # Student's distribution


def controlled(values: Array) -> Interval:
    """Return the 95 % confidence interval of the mean of a series (n,) whose sum is controlled.

    The sum follows a straight line within a scatter that does not grow, since what a feed lacks it makes up
    for.  The mean is off by the difference of that scatter at both ends of the series.
    """
    n = len(values)
    if n < FEWEST_CYCLES:
        return unknown(values)
    number, sums = np.arange(n + 1), np.concatenate([[0.0], np.cumsum(values - values.mean())])
    scatter = sums - np.polyval(np.polyfit(number, sums, 1), number)
    error = float(np.sqrt(2 * np.sum(scatter**2) / (n - 1))) / n
    return Interval(float(ndtri((1 + CONFIDENCE) / 2)) * error, error)  # normal distribution


def remaining_drift(values: Array) -> Interval:
    """Return by how much the mean of a series (n,), in which nothing is left to chance, may still be off.

    It is the largest distance of the mean of a third of the series from the mean, and what is still to come
    if the drift goes on to decay as from the first two thirds to the last two (Aitken's extrapolation).  For
    an exponential decay this is once to twice the distance from the final value.  Where the thirds swing to
    and fro, the last step is added.
    """
    if len(values) < 3:
        return unknown(values)
    early, middle, late = (float(part.mean()) for part in np.array_split(values, 3))
    first, last = middle - early, late - middle
    off = max(abs(part - float(values.mean())) for part in (early, middle, late))
    if first * last < 0:
        return Interval(off + abs(last))
    decay = min(last / first, SLOWEST_DECAY) if first else SLOWEST_DECAY
    return Interval(off + abs(last) * decay / (1 - decay))
