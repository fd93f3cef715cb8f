"""What went in and out, and the cycles over which it may be averaged."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from orchestrator.output.results.estimate import Estimate, batch_sums, estimate
from orchestrator.output.results.events import LOST, Exits, Fed, Removed, per_cycle
from orchestrator.output.results.steady import Steady, steady
from orchestrator.ports import Array


@dataclass(frozen=True)
class Events:
    """What went in and out, the whole cycles' ``edges_s``, and the steady ones of them."""

    fed: Fed
    removed: Removed
    exits: Exits
    edges_s: Array
    steady: Steady

    @property
    def window(self) -> slice:
        """The cycles over which to average."""
        return slice(self.steady.first, self.steady.last)

    @property
    def lasting_s(self) -> float:
        """How long these are."""
        return float(self.edges_s[self.steady.last] - self.edges_s[self.steady.first])

    @property
    def counted(self) -> Any:
        """(removed,) which of the particles left through an exit within them."""
        start, end = self.edges_s[self.steady.first], self.edges_s[self.steady.last]
        time = self.removed.time_s
        return (time > start) & (time <= end) & (self.removed.exit != LOST)

    def figure(self, statistic: Callable[[Array], float], cycles: Array) -> Estimate:
        """``statistic`` of sums of ``cycles`` (cycles, ...); with an interval if it is steady."""
        if self.steady.reason:
            value = statistic(cycles[self.window].sum(axis=0))
            return Estimate(float(value) if np.isfinite(value) else None)
        return estimate(statistic, batch_sums(cycles[self.window]))

    def rate(self, per_cycle: Array) -> Estimate:
        """Of something summed per cycle (cycles,), per second."""
        length_s = float(self.edges_s[1] - self.edges_s[0])
        pairs = np.column_stack([per_cycle, np.full(len(per_cycle), length_s)])
        return self.figure(lambda sums: sums[0] / sums[1], pairs)


def balanced(fed: Fed, removed: Removed, exits: Exits, edges_s: Array) -> Events:
    """With the steady state found.  Particles of t = 0 are there at the start, not fed."""
    later = fed.time_s > 0
    fed_kg = summed(fed.time_s[later], fed.mass_kg[later], edges_s)
    out_kg = summed(removed.time_s, removed.mass_kg, edges_s)
    start_kg = float(fed.mass_kg[~later].sum())
    return Events(fed, removed, exits, edges_s, steady(fed_kg, out_kg, start_kg))


def summed(time_s: Array, mass_kg: Array, edges_s: Array) -> Array:
    """(cycles,) mass in each of the cycles."""
    return per_cycle(time_s, mass_kg, edges_s, np.zeros(len(time_s), dtype=int), 1)[:, 0]
