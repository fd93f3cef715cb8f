"""The grains of a run without a steady state that were fed so early that nearly all of them have left.

What has left by the end of a transient is a biased sample: fines pass within a moment, and what goes over the
end needs the whole residence time.  Of the grains that were fed until some time, nearly all have left, by
whatever way; their shares have no such bias.  They saw a deck that was still filling.

A cohort's figures have no interval: what a filling deck does to them, their grains do not know.  They
have the standard error of their grains' chance, a lower bound of their uncertainty.  Grains that were fed
one after the other make a part, and parts are left out one at a time (the jackknife of ``estimate``):
what grains do together within a part counts.
docs/theory/screening.md has the definitions.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from orchestrator.figures.estimate import Estimate
from orchestrator.output.results.estimate import IntervalOf, estimate, independent
from orchestrator.output.results.events import LOST, Events, SteadyState
from orchestrator.ports import Array, Indices

MOST_REMAINING = 0.01
"""Largest share of a cohort's mass that is still in the machine."""
FEWEST = 100
"""Least number of grains of a cohort."""
PARTS = 10
"""Number of parts of a cohort, of equally many grains."""
FILLING = "no interval: the deck was still filling"


def last_fed_s(events: Events) -> float | None:
    """Return the latest time until which what was fed has nearly all left; None if it is too little."""
    fed = events.fed
    order = np.argsort(fed.time_s, kind="stable")
    order = order[fed.time_s[order] > 0]
    mass_kg = events.came_kg[order]
    remaining_kg = np.where(np.isin(fed.id[order], events.removed.id), 0.0, mass_kg)
    complete = np.cumsum(remaining_kg) <= MOST_REMAINING * np.cumsum(mass_kg)
    complete[: FEWEST - 1] = False
    time_s = fed.time_s[order]
    complete[:-1] &= np.diff(time_s) > 0  # a batch of the feed is in the cohort as a whole
    return float(time_s[np.flatnonzero(complete)[-1]]) if complete.any() else None


@dataclass(frozen=True)
class Cohort(Events):
    """The grains that were fed until ``until_s``, in a run whose steady state is ``state``.

    ``remaining`` is the share of their mass that has not left.
    """

    until_s: float = 0.0
    remaining: float = 0.0
    state: SteadyState | None = None

    @cached_property
    def steady(self) -> SteadyState:
        """The state of the run, of which the cohort is a part."""
        assert self.state is not None, "a cohort has the state of its run"
        return self.state

    @property
    def parts(self) -> int:
        """The number of parts of the cohort."""
        return PARTS

    @cached_property
    def part(self) -> Indices:
        """The number (removed,) of the part in which each particle that left was fed."""
        number = np.empty(len(self.fed.id), dtype=int)
        number[np.argsort(self.fed.time_s, kind="stable")] = np.arange(len(number))
        row = np.searchsorted(self.fed.id, self.removed.id, sorter=(order := np.argsort(self.fed.id)))
        return np.asarray(number[order[row]] * PARTS // len(number))

    @property
    def window(self) -> slice:
        """All parts."""
        return slice(None)

    @property
    def left_in_window(self) -> Any:
        """The mask (removed,) of particles that left through an exit."""
        return self.removed.exit != LOST

    def figure(
        self, statistic: Callable[[Array], float], cycles: Array, interval_of: IntervalOf | None = None
    ) -> Estimate:
        """Return the estimate of a statistic of the sum of ``cycles`` (parts, ...), without an interval.

        Its reason has the half width of the interval of the grains' chance alone.
        """
        found = estimate(statistic, cycles, interval_of or independent)
        if found.half_width is None:
            return replace(found, reason=FILLING)
        alone = f"{FILLING}; by chance alone ± {found.half_width:.2g}"
        return replace(found, half_width=None, reason=alone)


def cohort(events: Events) -> Cohort | None:
    """Return the grains that were fed so early that nearly all of them have left.

    Return None if there are fewer than ``FEWEST``.
    """
    until_s = last_fed_s(events)
    if until_s is None:
        return None
    early = (events.fed.time_s > 0) & (events.fed.time_s <= until_s)
    fed = events.fed.part(early)
    inside, came_kg = ~np.isin(fed.id, events.removed.id), events.came_kg[early]
    return Cohort(
        fed,
        events.removed.part(np.isin(events.removed.id, fed.id)),
        events.exits,
        events.edges_s,
        listed=events.listed,
        until_s=until_s,
        remaining=float(came_kg[inside].sum() / came_kg.sum()),
        state=events.steady,
    )
