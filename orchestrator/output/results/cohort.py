"""The grains of a run without a steady state that were fed so early that nearly all of them have left.

What has left by the end of a transient is a biased sample: fines pass within a moment, and what goes over the
end needs the whole residence time.  Of the grains that were fed until some time, nearly all have left, by
whatever way; their shares have no such bias.  They saw a deck that was still filling.
docs/theory/screening.md has the definitions.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from orchestrator.output.results.events import Events, SteadyState

MOST_REMAINING = 0.01
"""Largest share of a cohort's mass that is still in the machine."""
FEWEST = 100
"""Least number of grains of a cohort."""


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
