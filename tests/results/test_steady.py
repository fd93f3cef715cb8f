"""The steady state of decks whose filling is known."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator.output.results.events import find_steady_state, find_truncation
from orchestrator.ports import Array


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
    """Without noise the least certain half goes; with it, a few residence times (next test)."""
    fed, out = filling(400, 20.0)
    found = find_steady_state(fed, out, 0.0)
    assert found.reason == ""
    assert found.first == 200
    assert found.last == 400
    assert found.imbalance is not None
    assert 0.0 < found.imbalance < 0.005


def test_noise_does_not_hide_it() -> None:
    fed, out = filling(400, 20.0, noise=0.2)
    found = find_steady_state(fed, out, 0.0)
    assert found.reason == ""
    assert 40 <= found.first <= 140  # after 2 residence times 14 % of the way remain, after 7 0.1


@pytest.mark.parametrize("cycles", [30, 60])
def test_a_deck_that_still_fills_is_not_steady(cycles: int) -> None:
    fed, out = filling(cycles, 40.0)
    found = find_steady_state(fed, out, 0.0)
    assert "%" in found.reason
    assert (found.first, found.last) == (0, cycles)
    assert found.imbalance is not None
    assert found.imbalance > 0.02


def test_the_imbalance_is_the_one_by_hand() -> None:
    """30 cycles, each 2 kg in and 1.97 kg out: 1.5 % is steady, 2.5 % is not."""
    for out_kg, is_steady in ((1.97, True), (1.95, False)):
        found = find_steady_state(np.full(30, 2.0), np.full(30, out_kg), 5.0)
        assert found.imbalance == pytest.approx((2.0 - out_kg) / 2.0)
        assert found.drift == pytest.approx((2.0 - out_kg) / 2.0)
        assert (found.reason == "") is is_steady


def test_a_bed_that_holds_more_than_went_through() -> None:
    found = find_steady_state(np.full(30, 1.0), np.full(30, 1.0), 100.0)
    assert "residence" in found.reason


def test_a_feed_that_stops_ends_it() -> None:
    fed, out = filling(300, 10.0)
    fed = np.concatenate([fed, np.zeros(50)])
    out = np.concatenate([out, 10.0 * 0.1 * 0.9 ** np.arange(50)])
    found = find_steady_state(fed, out, 0.0)
    assert found.reason == ""
    assert found.last == 300


def test_batches_and_short_runs_are_not_steady() -> None:
    assert "nothing is fed" in find_steady_state(np.zeros(100), np.ones(100), 200.0).reason
    assert "20 are needed" in find_steady_state(np.ones(19), np.ones(19), 1.0).reason


def test_truncation_of_a_step() -> None:
    """Sixty values of 0, then two hundred of 1: exactly the zeros go."""
    assert find_truncation(np.concatenate([np.zeros(60), np.ones(200)])) == 60
