"""Intervals: some by hand, and how often they hold what they promise, on processes of known truth."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.random import Generator

from orchestrator.output.results.estimate import (
    TOO_FEW,
    Estimate,
    batch_count,
    batch_sums,
    chance,
    controlled,
    counting_deviation,
    estimate,
    mean,
    remaining_drift,
)
from orchestrator.output.results.events import Events, EventTable, Exits
from orchestrator.ports import Array


def test_the_scatter_of_a_share_by_counting() -> None:
    """2000 draws of which of 300 particles with unequal masses pass, each with a probability of 0.3."""
    rng = np.random.default_rng(1)
    mass_kg = rng.uniform(0.2, 3.0, 300) ** 3
    passes = rng.random((2000, 300)) < 0.3
    shares = passes @ mass_kg / mass_kg.sum()
    assert counting_deviation(0.3, mass_kg) == pytest.approx(shares.std(), rel=0.05)
    assert np.isnan(counting_deviation(0.3, np.empty(0)))


def cosine(number: int, values: int) -> Array:
    """A cosine with so many half periods, of which the projection is 1."""
    return np.sqrt(2 / values) * np.cos(np.pi * number * (np.arange(values) + 0.5) / values)


def test_six_slow_cosines_give_the_interval() -> None:
    """Sizes 1 to 6 have a mean square of 91/6, t(6, 0.975) = 2.446912; the eleventh cosine, from cycle to
    cycle, counts for nothing."""
    values = 3.0 + sum((j * cosine(j, 12) for j in range(1, 7)), 20.0 * cosine(11, 12))
    result = mean(values)
    assert result.value == pytest.approx(3.0, rel=1e-14)
    assert result.batches == 12
    assert result.half_width == pytest.approx(2.446912 * np.sqrt(91 / 6 / 12), rel=1e-6)
    assert result.standard_error == pytest.approx(np.sqrt(91 / 6 / 12), rel=1e-12)


def test_a_ratio_has_the_interval_of_its_linearisation() -> None:
    """Cochran, Sampling Techniques (1977), 6.4: the interval of (y - R x) / mean(x), with which the jackknife
    agrees to first order in 1/n and the spread of x."""
    rng = np.random.default_rng(2)
    x = rng.uniform(0.99, 1.01, 20)
    y = 0.8 * x + 0.01 * rng.permutation(np.linspace(-1, 1, 20))
    result = estimate(lambda sums: sums[0] / sums[1], np.column_stack([y, x]))
    ratio = y.sum() / x.sum()
    assert result.value == pytest.approx(ratio, rel=1e-14)
    assert result.half_width == pytest.approx(chance((y - ratio * x) / x.mean()).half_width, rel=0.01)


def test_the_first_batch_has_what_is_left_over() -> None:
    """The 43 cycles in 21 batches of two leave one over, and in 40 of one would leave three."""
    sums = batch_sums(np.arange(43.0)[:, None])
    assert sums.ravel().tolist() == [3.0, *(float(2 * first + 1) for first in range(3, 43, 2))]
    assert mean(np.arange(43.0)).value == pytest.approx(21.0, rel=1e-14)


@pytest.mark.parametrize(
    ("cycles", "batches"), [(7, 7), (20, 20), (40, 40), (43, 21), (59, 29), (80, 40), (1000, 40)]
)
def test_few_cycles_are_left_over(cycles: int, batches: int) -> None:
    """Batches of equal length use nearly all cycles: at most one in twenty is left over."""
    assert batch_count(cycles) == batches
    assert cycles % batches <= max(1, cycles // 20)


def test_what_cannot_be_said_is_not_said() -> None:
    """Nine cycles are too few, and so are thirty of which each is nearly the one before."""
    assert mean(np.arange(9.0)) == Estimate(4.0, None, 9, reason=TOO_FEW)
    assert mean(np.sin(np.linspace(0.0, 3.0, 30))).reason == TOO_FEW
    assert mean(np.arange(9.0)).as_json()["reason"] == TOO_FEW
    assert estimate(lambda _: float("nan"), np.ones((9, 1))) == Estimate(None)
    assert mean(np.ones(30)).half_width == 0.0


RUNS = 2000
NORMAL_95 = 1.96


def autoregression(rng: Generator, cycles: int, phi: float) -> Array:
    """Cycles (cycles, runs) of x' = phi x + e, with mean 0."""
    x = rng.normal(size=(cycles, RUNS))
    x[0] /= np.sqrt(1 - phi**2)
    for i in range(1, cycles):
        x[i] += phi * x[i - 1]
    return x


def swing(rng: Generator, cycles: int, period: float) -> Array:
    """A swing of so many cycles at any phase, with noise of its own size."""
    phase = rng.uniform(0, 2 * np.pi, RUNS)
    moved = np.sin(2 * np.pi * np.arange(cycles)[:, None] / period + phase)
    return moved + rng.normal(0, 0.7, (cycles, RUNS))


def events(rng: Generator, cycles: int, per_cycle: float) -> Array:
    """Counts of rare events, less their mean."""
    return rng.poisson(per_cycle, (cycles, RUNS)) - per_cycle


@pytest.mark.parametrize(
    ("process", "cycles", "what"),
    [
        (autoregression, 10, 0.0),
        (autoregression, 20, 0.0),
        (autoregression, 100, 0.0),
        (autoregression, 20, -0.3),
        (autoregression, 30, -0.6),
        (autoregression, 25, 0.3),
        (autoregression, 40, 0.5),
        (autoregression, 80, 0.7),
        (autoregression, 200, 0.85),
        (swing, 50, 6.3),
        (swing, 30, 2.3),
        (events, 50, 0.3),
        (events, 20, 2.0),
    ],
)
def test_intervals_hold_as_often_as_they_say_and_have_the_right_width(
    process: Callable[[Generator, int, float], Array], cycles: int, what: float
) -> None:
    """95 % are promised; 2000 runs find a share with a standard error of 0.5 %, and at the numbers of cycles
    chosen correlation costs up to 2.5 %.  Half the width is 0.5 to 2 times 1.96 standard deviations in 95 %
    of the runs, by Student's distribution in 97 %.  A fifth of ten independent cycles look correlated."""
    series = process(np.random.default_rng(7), cycles, what)
    deviation = series.mean(axis=0).std()
    estimates = [each for each in map(mean, series.T) if each.half_width is not None]
    assert len(estimates) > 0.75 * RUNS
    width = np.array([each.half_width for each in estimates])
    held = np.abs([each.value for each in estimates]) <= width
    assert 0.92 <= held.mean() <= 0.98
    assert np.mean((width > NORMAL_95 * deviation / 2) & (width < 2 * NORMAL_95 * deviation)) > 0.94


def test_a_share_has_the_right_interval() -> None:
    """Each of about three particles in a cycle passes with a probability of 0.4."""
    rng, shares, widths = np.random.default_rng(3), [], []
    for _ in range(500):
        came = rng.poisson(3.0, 40)
        share = estimate(lambda s: s[0] / s[1], np.column_stack([rng.binomial(came, 0.4), came]))
        shares.append(share.value)
        widths.append(share.half_width)
    known = [(x, w) for x, w in zip(shares, widths, strict=True) if w is not None]
    held = [abs(x - 0.4) <= w for x, w in known]
    assert len(known) > 490
    assert 0.92 <= np.mean(held) <= 0.98


@pytest.mark.parametrize("largest_kg", [1.0, 8.0])
def test_a_feed_that_makes_up_for_what_it_lacks_has_a_narrow_interval(largest_kg: float) -> None:
    """A kilogram is due in each cycle, and stones come whenever some mass is due.  Slow cosines of such a
    series would be three to five times too wide."""
    rng, means, widths = np.random.default_rng(5), [], []
    for _ in range(500):
        fed_kg, total_kg = np.zeros(70), 0.0
        for cycle in range(70):
            while total_kg + fed_kg[cycle] < cycle + 1:
                fed_kg[cycle] += largest_kg * rng.uniform(0.1, 1.0) ** 2
            total_kg += fed_kg[cycle]
        result = estimate(lambda s: s[0] / s[1], np.column_stack([fed_kg, np.ones(70)])[10:], controlled)
        means.append(result.value)
        widths.append(result.half_width)
    width, value = np.array(widths), np.array(means)
    assert 0.92 <= np.mean(np.abs(value - 1.0) <= width) <= 0.985
    ratio = width / (NORMAL_95 * value.std())
    assert np.mean((ratio > 0.5) & (ratio < 2.0)) > 0.95


@pytest.mark.parametrize("decay_cycles", [2.0, 5.0, 10.0, 30.0, 90.0])
def test_a_machine_without_chance_has_the_drift_that_remains(decay_cycles: float) -> None:
    """A stroke of 5 mm is reached from 6 mm: the mean of 30 cycles is off by less than its interval, which
    says no more than twice as much."""
    stroke_mm = 5.0 + np.exp(-np.arange(30) / decay_cycles)
    stroke = mean(stroke_mm, remaining_drift)
    assert stroke.value is not None
    assert stroke.half_width is not None
    off_mm = stroke.value - 5.0
    assert off_mm <= stroke.half_width <= 2.1 * off_mm
    assert stroke.standard_error is None


@pytest.mark.parametrize(("stay_cycles", "known"), [(6, True), (15, False)])
def test_a_bed_that_remembers_the_whole_window_has_no_interval(stay_cycles: int, known: bool) -> None:
    """A kilogram comes in each of 60 cycles, and leaves after 6 or 15: the window has nine or three stays."""
    came_s = np.arange(60) + 0.5
    left = came_s + stay_cycles < 60
    place, ids = np.zeros((left.sum(), 3)), np.arange(60)
    fed = EventTable(ids, came_s, np.ones(60), np.ones(60))
    gone = EventTable(
        ids[left], came_s[left] + stay_cycles, np.ones(left.sum()), np.ones(left.sum()), place, ids[left] * 0
    )
    seen = Events(fed, gone, Exits(("end",), ("oversize",)), np.arange(61.0))
    assert not seen.steady.reason
    assert seen.has_interval == known
