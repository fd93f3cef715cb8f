"""The steady state of decks whose filling is known."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator.output.results.events import (
    Balance,
    Events,
    EventTable,
    Exits,
    SteadyState,
    find_steady_state,
    find_truncation,
)
from orchestrator.output.results.screening import screening
from orchestrator.ports import Array


def steady(fed_kg: Array, out_kg: Array, start_kg: float) -> SteadyState:
    """The steady state of a deck that is fed and emptied evenly within each cycle."""
    held_kg = start_kg + np.concatenate([[0.0], np.cumsum(fed_kg - out_kg)])
    return find_steady_state(Balance(fed_kg, out_kg, held_kg, (held_kg[1:] + held_kg[:-1]) / 2))


def filling(cycles: int, residence: float, noise: float = 0.0) -> tuple[Array, Array]:
    """A stirred deck fed 1 kg a cycle: the hold-up grows as residence * (1 - exp(-t/residence))."""
    rng = np.random.default_rng(3)
    held, out = 0.0, np.empty(cycles)
    for i in range(cycles):
        held += 1.0
        out[i] = held / residence * (1 + noise * rng.normal())
        held -= out[i]
    return np.ones(cycles), out


def test_a_deck_that_fills_becomes_steady() -> None:
    """The least certain half goes without noise; with it, a few residence times (next test)."""
    fed, out = filling(400, 20.0)
    state = steady(fed, out, 0.0)
    assert state.reason == ""
    assert state.first == 200
    assert state.last == 400
    assert state.imbalance is not None
    assert 0.0 < state.imbalance < 0.005


def test_noise_does_not_hide_it() -> None:
    fed, out = filling(400, 20.0, noise=0.2)
    state = steady(fed, out, 0.0)
    assert state.reason == ""
    assert 40 <= state.first <= 140  # after 2 residence times 14 % of the way remain, after 7 0.1


@pytest.mark.parametrize("cycles", [30, 60])
def test_a_deck_that_still_fills_is_not_steady(cycles: int) -> None:
    fed, out = filling(cycles, 40.0)
    state = steady(fed, out, 0.0)
    assert "%" in state.reason
    assert (state.first, state.last) == (0, cycles)
    assert state.imbalance is not None
    assert state.imbalance > 0.02


def test_the_imbalance_is_the_one_by_hand() -> None:
    """30 cycles, each 2 kg in and 1.97 kg out: 1.5 % is steady, 2.5 % is not."""
    for out_kg, is_steady in ((1.97, True), (1.95, False)):
        state = steady(np.full(30, 2.0), np.full(30, out_kg), 5.0)
        assert state.imbalance == pytest.approx((2.0 - out_kg) / 2.0)
        assert state.drift == pytest.approx((2.0 - out_kg) / 2.0)
        assert (state.reason == "") is is_steady


def fluctuating(seed: int, growth_kg: float = 0.0) -> tuple[Array, Array]:
    """Sixty cycles that are fed 85 g each on a deck that holds 1.25 kg, give or take 50 g by chance (an
    autoregressive process that forgets within some ten cycles), and ``growth_kg`` more at the end."""
    rng = np.random.default_rng(seed)
    deviation_kg, keeps = np.empty(61), 0.9
    deviation_kg[0] = 0.05 * rng.normal()
    for i in range(60):
        deviation_kg[i + 1] = keeps * deviation_kg[i] + 0.05 * np.sqrt(1 - keeps**2) * rng.normal()
    held_kg = 1.25 + deviation_kg + growth_kg * np.linspace(0.0, 1.0, 61)
    fed_kg = np.full(60, 0.085)
    return fed_kg, fed_kg - np.diff(held_kg)


def test_a_few_large_stones_do_not_make_a_steady_deck_unsteady() -> None:
    """The mass in less out is 1.5 % of the feed by chance, and so beyond 2 % in one run of six."""
    states = [steady(*fluctuating(seed), 1.25) for seed in range(200)]
    beyond = [each for each in states if abs(each.imbalance or 0.0) > 0.02]
    assert len(beyond) > 20
    told_by_imbalance = [each for each in states if "in less out" in each.reason]
    assert len(told_by_imbalance) <= 0.05 * len(states)


def test_a_deck_that_grows_beyond_chance_is_not_steady() -> None:
    """The deck grows by a tenth of the feed, with the same fluctuations."""
    states = [steady(*fluctuating(seed, growth_kg=0.1 * 60 * 0.085), 1.25) for seed in range(200)]
    assert all(each.reason for each in states)


def test_a_bed_that_holds_more_than_went_through() -> None:
    state = steady(np.full(30, 1.0), np.full(30, 1.0), 100.0)
    assert "residence" in state.reason


def test_a_feed_that_stops_ends_it() -> None:
    fed, out = filling(300, 10.0)
    fed = np.concatenate([fed, np.zeros(50)])
    out = np.concatenate([out, 10.0 * 0.1 * 0.9 ** np.arange(50)])
    state = steady(fed, out, 0.0)
    assert state.reason == ""
    assert state.last == 300


def test_batches_and_short_runs_are_not_steady() -> None:
    assert "fed" in steady(np.zeros(100), np.ones(100), 200.0).reason
    assert "20" in steady(np.ones(19), np.ones(19), 1.0).reason.split()


def test_truncation_of_a_step() -> None:
    """Sixty values of 0, then two hundred of 1: exactly the zeros go."""
    assert find_truncation(np.concatenate([np.zeros(60), np.ones(200)])) == 60


def test_what_lay_there_at_the_start_did_not_come() -> None:
    """A fine grain comes and one passes in each of 40 cycles, and of two that lie there one is never seen
    again: what passes is all that came, and not 40 of 42."""
    cycles, ones = np.arange(40), np.ones(42)
    came_s = np.concatenate([[0.0, 0.0], 0.5 * (cycles + 0.25)])
    came = EventTable(np.arange(42), came_s, 0.01 * ones, 2.0 * ones)
    left = EventTable(
        cycles, 0.5 * (cycles + 0.75), 0.01 * ones[2:], 2.0 * ones[2:], np.zeros((40, 3)), np.zeros(40, int)
    )
    events = Events(came, left, Exits(("under", "over"), ("undersize", "oversize")), 0.5 * np.arange(41.0))
    assert (events.steady.reason, events.steady.first) == ("", 0)
    recovered = screening(events, 0.02).recovered_percent
    assert recovered is not None
    assert recovered.value == pytest.approx(100.0)


def test_the_hold_up_of_a_cycle_is_its_mean_over_time() -> None:
    """Particles of 2 kg that come after a quarter of each cycle and leave after three quarters: half of the
    time the deck has 2 kg, and at all ends of cycles nothing."""
    cycles, ones = np.arange(5), np.ones(5)
    came = EventTable(cycles, 0.5 * (cycles + 0.25), 0.01 * ones, 2.0 * ones)
    left = EventTable(
        cycles, 0.5 * (cycles + 0.75), 0.01 * ones, 2.0 * ones, np.zeros((5, 3)), np.zeros(5, int)
    )
    balance = Events(came, left, Exits(("out",), ("oversize",)), 0.5 * np.arange(6.0)).balance
    np.testing.assert_allclose(balance.mean_held_kg, ones)
    assert not balance.held_kg.any()
