"""Figures with confidence intervals: batch means, by the jackknife.

Successive cycles of a machine are not independent, so they are joined to batches that hardly are
(Schmeiser, Operations Research 30, 1982, 556-568, doi 10.1287/opre.30.3.556), and what correlation
is left between neighbouring batches widens the interval.  Leaving out one batch at a time gives
the interval of any function of sums, such as an efficiency (Miller, Biometrika 61, 1974, 1-15,
doi 10.1093/biomet/61.1.1); for a plain mean it is Student's.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.stats import t as student

from orchestrator.ports import Array, Indices

BATCHES = 20  # Schmeiser: 10 to 30; more would be shorter and so less independent
FEWEST_BATCHES = 5
CONFIDENCE = 0.95


@dataclass(frozen=True)
class Estimate:
    """A value and half the width of its 95 % confidence interval; None where nothing can be
    said (too few batches, no steady state).  ``value`` is None where it is not defined."""

    value: float | None
    half_width: float | None = None
    batches: int = 0

    def table(self) -> dict[str, float | int | None]:
        """Return the estimate as results have it."""
        return {"value": self.value, "half_width": self.half_width, "batches": self.batches}


def batch_sums(per_cycle: Array, batches: int = BATCHES) -> Array:
    """Return (batches, ...) sums of (cycles, ...) over equal batches of whole cycles.

    What does not divide is left out at the front, next to the start-up.  Fewer cycles than
    ``batches`` make as many batches as there are cycles.
    """
    count = min(batches, len(per_cycle))
    length = len(per_cycle) // count
    kept = per_cycle[len(per_cycle) - count * length :]
    return np.asarray(kept.reshape(count, length, *per_cycle.shape[1:]).sum(axis=1))


def estimate(statistic: Callable[[Array], float], batches: Array) -> Estimate:
    """Return ``statistic`` of the sum of ``batches`` (n, ...), which it must not depend on the number of:
    a mean is a sum over a sum.  NaN where it is not defined."""
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
    return Estimate(float(whole), half_width(n * whole - (n - 1) * without), n)


def mean(values: Array) -> Estimate:
    """Return the mean of values (cycles,), by batches."""
    ones = np.column_stack([values, np.ones(len(values))])
    return estimate(lambda sums: sums[0] / sums[1], batch_sums(ones))


def mean_by_cycles(values: Array, cycle: Indices, is_steady: bool) -> Estimate:
    """Return the mean of values (times,), of which each belongs to a ``cycle``; with its interval from
    the cycles' means where it is steady."""
    if not is_steady:
        return Estimate(float(values.mean()))
    return mean(_sum_by_cycle(values, cycle) / _sum_by_cycle(np.ones(len(values)), cycle))


def ratio_by_cycles(part: Array, whole: Array, cycle: Indices, is_steady: bool) -> Estimate:
    """Return the sum of ``part`` over the sum of ``whole``, both at the same times; None where that is 0."""
    sums = np.array([_sum_by_cycle(part, cycle), _sum_by_cycle(whole, cycle)]).T
    if not is_steady:
        return Estimate(share(*sums.sum(axis=0)))
    return estimate(lambda total: share(*total), batch_sums(sums))


def _sum_by_cycle(values: Array, cycle: Indices) -> Array:
    index = np.unique(cycle, return_inverse=True)[1]
    return np.bincount(index, values).astype(float)


def share(part: float, whole: float) -> float:
    """Return the part over the whole; NaN where there is nothing to share."""
    return float(part) / float(whole) if whole > 0 else float("nan")


def half_width(values: Array) -> float:
    """Return the half width of the interval of the mean of n batches: Student's t with the number of
    independent batches.

    With correlation r between neighbours, n values are worth n (1 - r) / (1 + r) independent ones
    (first-order autoregression; Bayley and Hammersley, Suppl. J. R. Stat. Soc. 8, 1946, 184-197).
    r is corrected for its bias, -(1 + 3 r) / n or so, and taken as 0 where it is negative.
    """
    n = len(values)
    spread = values - values.mean()
    variance = float(spread @ spread) / (n - 1)
    if variance == 0.0:
        return 0.0
    r = float(spread[1:] @ spread[:-1]) / float(spread @ spread)
    r = min(max((n * r + 1) / (n - 3), 0.0), 0.8)
    independent = max(n * (1 - r) / (1 + r), 2.0)
    quantile = float(student.ppf((1 + CONFIDENCE) / 2, independent - 1))
    return quantile * float(np.sqrt(variance / independent))
