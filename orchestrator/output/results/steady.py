"""The steady state, from the mass balance.

Two steps.  Where it may begin: the start-up to leave out is the one that makes the mean hold-up
of the rest most certain (marginal standard error rule; White, Simulation 69, 1997, 323-334, doi
10.1177/003754979706900601).  Whether it is one: over the rest, what goes out equals what comes
in within 2 %, and so does a straight line through the hold-up.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchestrator.ports import Array

FEWEST_CYCLES = 20
LARGEST_IMBALANCE = 0.02


@dataclass(frozen=True)
class Steady:
    """Cycles ``first`` to ``last`` (not included) over which to average.

    Where ``reason`` is not empty they are no steady state, and it says why.  ``imbalance`` is
    (in - out) / in over them, ``drift`` the slope of the hold-up over the rate of feed.
    """

    first: int
    last: int
    reason: str
    imbalance: float | None = None
    drift: float | None = None


def steady(fed_kg: Array, out_kg: Array, start_kg: float) -> Steady:
    """``fed_kg`` and ``out_kg`` (cycles,) are the masses in each whole cycle, ``start_kg`` what is
    there at the first one's beginning."""
    cycles = len(fed_kg)
    feeding = np.flatnonzero(fed_kg)
    if not len(feeding):
        return Steady(0, cycles, "nothing is fed: a batch is never steady")
    last = int(feeding[-1]) + 1
    held_kg = start_kg + np.concatenate([[0.0], np.cumsum(fed_kg - out_kg)])
    if cycles - last > 1:
        end = f"the feed stops after cycle {last}"
    else:
        last, end = cycles, "the run ends"
    if last - feeding[0] < FEWEST_CYCLES:
        fed = f"only {last - int(feeding[0])} cycles are fed before {end}"
        return Steady(0, cycles, f"{fed}; {FEWEST_CYCLES} are needed")
    mean_kg = (held_kg[:last] + held_kg[1 : last + 1]) / 2
    first = truncation(mean_kg)
    window = slice(first, last)
    in_kg, gone_kg = float(fed_kg[window].sum()), float(out_kg[window].sum())
    imbalance = (in_kg - gone_kg) / in_kg
    slope_kg = float(np.polyfit(np.arange(last - first), mean_kg[window], 1)[0])
    drift = slope_kg * (last - first) / in_kg
    reason = _why_not(imbalance, drift, last - first, held_kg[last], gone_kg)
    if reason:
        return Steady(0, cycles, reason, imbalance, drift)
    return Steady(first, last, "", imbalance, drift)


def truncation(values: Array) -> int:
    """How many of the first values to leave out: at most half of them, at least
    ``FEWEST_CYCLES`` staying."""
    candidates = range(min(len(values) // 2, len(values) - FEWEST_CYCLES) + 1)
    errors = [float(values[d:].var()) / (len(values) - d) for d in candidates]
    return int(np.argmin(errors))


def _why_not(imbalance: float, drift: float, cycles: int, held_kg: float, gone_kg: float) -> str:
    """Little's law: with more on the deck than left it, they stay longer than the cycles last."""
    largest = 100 * LARGEST_IMBALANCE
    for what, value in (("in less out", imbalance), ("the growth of the hold-up", drift)):
        if abs(value) > LARGEST_IMBALANCE:
            share = f"{100 * value:+.1f} % of the feed over the last {cycles} cycles"
            return f"{what} is {share}; up to {largest:g} % counts as steady"
    if held_kg > gone_kg:
        return f"the last {cycles} cycles are shorter than the particles' residence time"
    return ""
