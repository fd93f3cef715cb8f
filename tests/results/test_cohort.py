"""The grains of a transient that have nearly all left, against a deck whose separation is known."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator.output.results.cohort import FEWEST, MOST_REMAINING, cohort
from orchestrator.output.results.events import Events, EventTable, Exits
from orchestrator.output.results.screening import screening

CUT_M = 0.006
RATE_PER_S, STAY_S = 0.5, 1.5
"""Fines pass with this rate until they reach the deck's end; coarse grains stay as long."""
BATCHES_S = 0.02  # between the times at which grains are fed
PASSED = 1 - np.exp(-RATE_PER_S * STAY_S)


def transient(end_s: float, per_s: int = 4000, stuck: int = 0) -> Events:
    """Return a deck that is fed from 0.2 s on, with half of the mass fine, until the run ends.

    ``stuck`` grains that were fed first never leave.
    """
    generator = np.random.default_rng(3)
    number = int(per_s * (end_s - 0.2))
    time_s = np.ceil(np.sort(generator.uniform(0.2, end_s, number)) / BATCHES_S) * BATCHES_S
    is_fine = generator.uniform(size=number) < 0.5
    diameter_m = np.where(is_fine, 0.004, 0.008)
    waits_s = np.where(is_fine, generator.exponential(1 / RATE_PER_S, number), np.inf)
    waits_s[:stuck] = np.inf
    left_s = time_s + np.minimum(waits_s, STAY_S)
    left_s[:stuck] = np.inf
    ids, mass_kg = np.arange(number), np.ones(number)
    came = EventTable(ids, time_s, diameter_m, mass_kg)
    gone = np.flatnonzero(left_s < end_s)
    gone = gone[np.argsort(left_s[gone])]
    exit_number = np.where(waits_s < STAY_S, 0, 1)[gone]
    place_m = np.zeros((len(gone), 3))
    removed = EventTable(ids[gone], left_s[gone], diameter_m[gone], mass_kg[gone], place_m, exit_number)
    exits = Exits(("through", "over"), ("undersize", "oversize"))
    return Events(came, removed, exits, np.linspace(0.0, end_s, round(end_s / 0.08) + 1))


@pytest.mark.parametrize("stuck", [0, 3])
@pytest.mark.parametrize("end_s", [2.2, 2.8])
def test_a_transient_is_told_without_bias(end_s: float, stuck: int) -> None:
    """Of all that has left, 65 to 80 % of the fines had passed; of each cohort 1 - exp(-0.75) = 53 %."""
    events = transient(end_s, stuck=stuck)
    assert events.steady.reason
    early = cohort(events)
    assert early is not None
    assert 0.2 < early.until_s < end_s - STAY_S + 0.05
    assert early.remaining <= MOST_REMAINING
    assert early.steady == events.steady
    biased, told = (screening(each, CUT_M).efficiency_percent for each in (events, early))
    assert biased.value > 100 * PASSED + 10
    assert told.half_width is None
    assert told.value == pytest.approx(100 * PASSED, abs=4 * told.counting + 100 * MOST_REMAINING)


def test_a_run_that_ends_too_early_has_no_cohort() -> None:
    """The first grains of 8 mm leave 1.5 s after they were fed, at 1.7 s."""
    assert cohort(transient(1.6)) is None
    assert cohort(transient(1.75, per_s=FEWEST)) is None
