"""Residence and passing of particles whose ways are known; sums over cycles."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from orchestrator.output.results.bed import passing_kg_per_s_m, residence_s, transport
from orchestrator.output.results.events import LOST, Events, EventTable, Exits, per_cycle
from orchestrator.output.results.screening import screening


def removed(ids: list[int], time_s: list[float]) -> EventTable:
    n = len(ids)
    sizes = np.full(n, 0.003), np.full(n, 1e-3)
    return EventTable(np.array(ids), np.array(time_s), *sizes, np.zeros((n, 3)), np.zeros(n, dtype=int))


def test_residence_goes_by_id() -> None:
    fed = EventTable(np.array([7, 2, 5]), np.array([0.5, 0.0, 0.1]), np.full(3, 0.003), np.full(3, 1e-3))
    stay_s = residence_s(fed, removed([5, 7, 9, 2], [1.0, 2.0, 3.0, 4.0]))
    assert stay_s[[0, 1, 3]] == pytest.approx([0.9, 1.5, 4.0])
    assert np.isnan(stay_s[2])


def test_passing_per_metre_and_second() -> None:
    passing = passing_kg_per_s_m(
        np.array([0.05, 0.15, 0.17, -0.3]), np.array([1.0, 2.0, 3.0, 4.0]), np.array([0, 0.1, 0.3]), 2.0
    )
    assert passing == pytest.approx([(1 + 4) / 0.1 / 2, (2 + 3) / 0.2 / 2])


def test_sums_over_cycles_lose_nothing() -> None:
    """The edge belongs to the cycle that ends there, t = 0 to the first."""
    time = np.array([0.0, 0.1, 0.1000001, 0.2, 0.25, 0.31])
    group = np.array([0, 1, 0, 0, LOST, 0])
    table = per_cycle(time, np.arange(1.0, 7.0), np.array([0.0, 0.1, 0.2, 0.3]), group, 2)
    assert table.tolist() == [[1.0, 2.0], [3.0 + 4.0, 0.0], [0.0, 0.0]]


def carried_bed(recovered: float, stay_s: tuple[float, float], end_s: float = 60.0) -> Events:
    """A steady deck that a run begins with: grains come at equal times and stay for random times.

    A share ``recovered`` of the fines, half of all grains, leaves with the undersize.  Grains on the deck at
    t = 0 have come before, and nobody knows when.
    """
    generator = np.random.default_rng(3)
    time_s = np.arange(-20.0, end_s, 0.005)
    left_s = time_s + generator.uniform(*stay_s, len(time_s))
    fine = generator.uniform(size=len(time_s)) < 0.5
    under = fine & (generator.uniform(size=len(time_s)) < recovered)
    there = left_s > 0
    diameter_m = np.where(fine, 0.002, 0.005)
    mass_kg = np.ones(len(time_s))
    ids = np.arange(len(time_s))
    fed = EventTable(ids[there], np.maximum(time_s, 0.0)[there], diameter_m[there], mass_kg[there])
    gone = there & (left_s < end_s)
    order = np.flatnonzero(gone)[np.argsort(left_s[gone])]
    removed = EventTable(
        ids[order],
        left_s[order],
        diameter_m[order],
        mass_kg[order],
        np.zeros((len(order), 3)),
        np.where(under[order], 0, 1),
    )
    exits = Exits(("under", "over"), ("undersize", "oversize"))
    return Events(fed, removed, exits, np.arange(0.0, end_s + 0.1, 0.5))


@pytest.mark.parametrize(("at_s", "is_steady"), [(30.0, False), (0.2, True)])
def test_a_feed_that_changes_in_the_window_is_not_steady(at_s: float, is_steady: bool) -> None:
    """The mass balances, but not the sizes: another feed may have others."""
    events = replace(carried_bed(0.7, (1.0, 3.0)), feed_changes_s=(0.0, at_s))
    assert (events.steady.reason == "") == is_steady
    if not is_steady:
        assert "a feed starts or stops at 30 s" in events.steady.reason
        assert events.window_s == (events.edges_s[0], events.edges_s[-1])


def test_a_steady_run_that_begins_with_a_bed_knows_recovery_and_residence() -> None:
    """The bed of t = 0 did not come in the window, and nobody knows how long it has been there."""
    events = carried_bed(0.7, (1.0, 3.0))
    assert not events.steady.reason
    recovered = screening(events, 0.003).recovered_percent
    assert abs(recovered.value - 70.0) < 4 * recovered.standard_error
    assert recovered.standard_error < 1.0
    residence = transport(events, None).residence_s
    assert abs(residence.value - 2.0) < 4 * residence.standard_error
    assert residence.standard_error < 0.02


def test_what_lay_there_at_the_start_has_no_residence_in_an_unsteady_run_either() -> None:
    """A batch of grains that begin anywhere on the deck is nowhere near its whole length from its exit."""
    events = carried_bed(0.7, (1.0, 3.0), end_s=4.0)
    events = replace(events, feed_changes_s=(3.9,))
    assert events.steady.reason
    residence = transport(events, None).residence_s
    fed, left = events.fed, events.removed
    over = (left.exit == 1) & ~np.isin(left.id, fed.id[fed.time_s <= 0.0])
    assert residence.value == pytest.approx(float(residence_s(fed, left)[over].mean()), rel=1e-12)
