"""Estimates with confidence intervals, from batch means by the jackknife.

Successive cycles of a machine are not independent.  They are joined to batches that are nearly independent
(Schmeiser, Operations Research 30, 1982, 556-568, doi 10.1287/opre.30.3.556), and the remaining
correlation between neighbouring batches widens the interval.  The jackknife leaves out one batch at a
time, which gives the interval of any function of sums, such as an efficiency (Miller, Biometrika 61,
1974, 1-15, doi 10.1093/biomet/61.1.1).  For a mean it gives Student's interval.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.special import stdtrit

from orchestrator.ports import Array, Indices

BATCHES = (10, 20)  # Schmeiser advises 10 to 30; more batches would be shorter and less independent
FEWEST_BATCHES = 5
CONFIDENCE = 0.95


@dataclass(frozen=True)
class Estimate:
    """A value with the half width of its 95 % confidence interval.

    ``value`` is None if it is not defined.  ``half_width`` is None if it is unknown, because there are too
    few batches or no steady state, and so is ``standard_error``, the standard deviation of the value: half
    the width over Student's quantile.  ``counting`` is the standard deviation of a share that its number of
    particles alone explains; it is None for what is no share.
    """

    value: float | None
    half_width: float | None = None
    batches: int = 0
    counting: float | None = None
    standard_error: float | None = None

    def table(self) -> dict[str, float | int | None]:
        """Return the estimate as a table of the results."""
        table = {"value": self.value, "half_width": self.half_width, "batches": self.batches}
        told = {"counting": self.counting, "standard_error": self.standard_error}
        return table | {name: value for name, value in told.items() if value is not None}


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


def estimate(statistic: Callable[[Array], float], batches: Array) -> Estimate:
    """Return the estimate of a statistic of the sum of ``batches`` (n, ...).

    The statistic must not depend on the number of batches: a mean must be a sum over a sum.  It is NaN if
    it is not defined.
    """
    total = batches.sum(axis=0)
    whole = statistic(total)
    if not np.isfinite(whole):
        return Estimate(None)
    n = len(batches)
    if n < FEWEST_BATCHES:
        return Estimate(float(whole), None, n)
    without = np.array([statistic(total - batch) for batch in batches])
    if not np.isfinite(without).all():
        return Estimate(float(whole), None, n)
    error, quantile = standard_error(n * whole - (n - 1) * without)
    return Estimate(float(whole), quantile * error, n, standard_error=error)


def mean(values: Array) -> Estimate:
    """Return the mean of values (cycles,), with its interval from batches."""
    ones = np.column_stack([values, np.ones(len(values))])
    return estimate(lambda sums: sums[0] / sums[1], batch_sums(ones))


def mean_by_cycles(values: Array, cycle: Indices, is_steady: bool) -> Estimate:
    """Return the mean of values (times,), where ``cycle`` (times,) is the number of each value's cycle.

    Every value counts alike, however many fall into its cycle.  In a steady state there is an interval.
    """
    return ratio_by_cycles(values, np.ones(len(values)), cycle, is_steady)


def ratio_by_cycles(part: Array, whole: Array, cycle: Indices, is_steady: bool) -> Estimate:
    """Return the sum of ``part`` over the sum of ``whole``, both (times,); no value if the latter is 0."""
    sums = np.array([_sum_by_cycle(part, cycle), _sum_by_cycle(whole, cycle)]).T
    if not is_steady:
        value = share(*sums.sum(axis=0))
        return Estimate(value if np.isfinite(value) else None)
    return estimate(lambda total: share(*total), batch_sums(sums))


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


def standard_error(values: Array) -> tuple[float, float]:
    """Return the standard error of the mean of n batches, and Student's quantile for its interval.

    It is Student's interval for the number of independent batches.  With the correlation r between
    neighbours, n values have the weight of n (1 - r) / (1 + r) independent values (first-order
    autoregression; Bayley and Hammersley, Suppl. J. R. Stat. Soc. 8, 1946, 184-197).  r is corrected for
    its bias of about -(1 + 3 r) / n, and a negative r counts as 0.
    """
    n = len(values)
    spread = values - values.mean()
    variance = float(spread @ spread) / (n - 1)
    if variance == 0.0:
        return 0.0, 0.0
    r = float(spread[1:] @ spread[:-1]) / float(spread @ spread)
    r = min(max((n * r + 1) / (n - 3), 0.0), 0.8)
    independent = max(n * (1 - r) / (1 + r), 2.0)
    quantile = float(stdtrit(independent - 1, (1 + CONFIDENCE) / 2))  # of Student's distribution
    return float(np.sqrt(variance / independent)), quantile
