"""The grains of a transient that have nearly all left, against a deck whose separation is known."""

from __future__ import annotations

import re

import numpy as np
import pytest

from orchestrator.output.results.cohort import FEWEST, MOST_REMAINING, cohort
from orchestrator.output.results.events import Events, EventTable, Exits
from orchestrator.output.results.screening import screening, shares

CUT_M = 0.006
RATE_PER_S, STAY_S = 0.5, 1.5
"""Fines pass with this rate until they reach the deck's end; coarse grains stay as long."""
BATCHES_S = 0.02  # between the times at which grains are fed
STUDENT_9 = 2.262
"""Half the width of the 95 % interval of Student's distribution with nine degrees of freedom."""
PASSED = 1 - np.exp(-RATE_PER_S * STAY_S)


def transient(
    end_s: float,
    per_s: int = 4000,
    stuck: int = 0,
    rate_per_s: float = RATE_PER_S,
    together: int = 1,
    seed: int = 3,
) -> Events:
    """Return a deck that is fed from 0.2 s on, with half of the mass fine, until the run ends.

    ``stuck`` grains that were fed first never leave.  Fines among ``together`` successive grains go the same
    way.
    """
    generator = np.random.default_rng(seed)
    number = int(per_s * (end_s - 0.2))
    time_s = np.ceil(np.sort(generator.uniform(0.2, end_s, number)) / BATCHES_S) * BATCHES_S
    is_fine = generator.uniform(size=number) < 0.5
    diameter_m = np.where(is_fine, 0.004, 0.008)
    waits_s = generator.exponential(1 / rate_per_s, number)[np.arange(number) // together]
    waits_s = np.where(is_fine, waits_s, np.inf)
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
    """The fines passed in 65 to 80 % of all that has left; of each cohort 1 - exp(-0.75) = 53 %."""
    events = transient(end_s, stuck=stuck)
    assert events.steady.reason
    early = cohort(events)
    assert early is not None
    assert 0.2 < early.until_s < end_s - STAY_S + 0.05
    assert early.remaining <= MOST_REMAINING
    assert early.steady == events.steady
    biased, efficiency = screening(events, CUT_M).efficiency_percent, shares(early, CUT_M)["efficiency"]
    assert biased.value > 100 * PASSED + 10
    assert efficiency.value == pytest.approx(100 * PASSED, abs=4 * efficiency.counting + 100 * MOST_REMAINING)


def test_a_run_that_ends_too_early_has_no_cohort() -> None:
    """The first grains of 8 mm leave 1.5 s after they were fed, at 1.7 s."""
    assert cohort(transient(1.6)) is None
    assert cohort(transient(1.75, per_s=FEWEST)) is None


def test_the_chance_of_a_cohort_holds_the_true_share() -> None:
    """The intervals of 400 feeds with some 160 grains in the cohort hold, in 95 % by chance, what passes of
    each grain by its own chance, within three standard deviations of counting 400, 3.3 points; that 1 % of
    the mass may remain makes the shares too favourable by 1 point at most, a fifth of their deviation."""
    held, errors, deviations = [], [], []
    for seed in range(400):
        early = cohort(transient(2.2, per_s=320, seed=seed))
        assert early is not None
        efficiency = shares(early, CUT_M)["efficiency"]
        assert efficiency.standard_error is not None
        assert efficiency.counting is not None
        held.append(abs(efficiency.value - 100 * PASSED) <= STUDENT_9 * efficiency.standard_error)
        errors.append(efficiency.standard_error)
        deviations.append(efficiency.counting)
    assert np.mean(held) == pytest.approx(0.95, abs=0.033)
    assert np.mean(errors) == pytest.approx(np.mean(deviations), rel=0.1)


def test_grains_that_go_together_widen_the_chance_of_a_cohort() -> None:
    """Fines that are fed together all pass or all stay: 95 % of the intervals hold, where those by counting
    grains, 1.96 deviations, would hold 2 (Phi(1.96 / sqrt(5)) - 1/2) = 62 % or so for five fines."""
    held, by_counting = [], []
    for seed in range(200):
        early = cohort(transient(2.2, per_s=2000, together=10, seed=seed))
        assert early is not None
        efficiency = shares(early, CUT_M)["efficiency"]
        assert efficiency.standard_error is not None
        assert efficiency.counting is not None
        off = abs(efficiency.value - 100 * PASSED)
        held.append(off <= STUDENT_9 * efficiency.standard_error)
        by_counting.append(off <= 1.96 * efficiency.counting)
    assert np.mean(held) == pytest.approx(0.95, abs=0.047)  # three standard deviations of counting 200
    assert np.mean(by_counting) < 0.75


def test_a_cohort_has_no_interval_and_says_why() -> None:
    """The grains of the filling deck are not known; that 80 of 80 fines passed does not tell that all do."""
    for rate_per_s, reason in (
        (RATE_PER_S, r"still filling; by chance alone ± \d"),
        (100.0, "still filling$"),
    ):
        early = cohort(transient(2.2, per_s=320, rate_per_s=rate_per_s))
        assert early is not None
        efficiency = shares(early, CUT_M)["efficiency"]
        assert efficiency.half_width is None
        assert re.search(reason, efficiency.reason)
