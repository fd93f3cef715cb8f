"""Feeds: the mass kept, the shares kept, room, retries, and the same again from a pickle."""

from __future__ import annotations

import math
import pickle
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.distance import cdist

from orchestrator.case.bed.feed import Feeds, Inlet, RateFeed
from orchestrator.case.bed.size_distribution import classes, share_left_out, size_class
from orchestrator.case.tables.bed import Feed
from orchestrator.ports.clock import Interval
from orchestrator.ports.plans import ParticleList
from tests.grains import one_sphere, sphere_kg
from tests.particles.sizes import COAL, mass_shares, smallest_gap_m

INLET = Inlet(
    sizes=COAL,
    rate_kg_per_s=2.0,
    box_m=np.array([[0.0, 0.0, 0.5], [0.1, 0.2, 0.6]]),
    velocity_m_per_s=np.array([0.0, 0.0, -1.0]),
    grain=one_sphere(1.0, material=1),
    start_s=0.01,
    stop_s=0.06,
)
LUMPS = (size_class(0.008, 0.013, 1.0),)
LARGEST_KG = float(sphere_kg(0.013))
HALVES_KG = float(sphere_kg(np.array([row.largest_m for row in COAL]), 1430.0).sum()) / 2.0


def all_accepted(feed: RateFeed | Feeds, intervals: int, length_s: float) -> list[ParticleList]:
    offers = []
    for index in range(intervals):
        offers.append(feed.due(Interval(index, length_s)))
        feed.settle(np.ones(len(offers[-1]), dtype=bool))
    return offers


def total_kg(offers: list[ParticleList]) -> float:
    return sum(float(np.sum(sphere_kg(offer.grains.sieve_size_m, 1430.0))) for offer in offers)


@settings(max_examples=25, deadline=None)
@given(
    rate_kg_per_s=st.floats(0.01, 3.0),
    length_s=st.sampled_from([1e-4, 1e-3, 3e-3]),
    seed=st.integers(0, 2**32),
)
def test_the_rate_is_kept_within_halves_of_particles(
    rate_kg_per_s: float, length_s: float, seed: int
) -> None:
    inlet = replace(INLET, rate_kg_per_s=rate_kg_per_s, seed=seed)
    feed, fed_kg = RateFeed(inlet), 0.0
    for index in range(30):
        interval = Interval(index, length_s)
        offer = feed.due(interval)
        feed.settle(np.ones(len(offer), dtype=bool))
        assert smallest_gap_m(offer) >= 0.0
        fed_kg += total_kg([offer])
        assert feed.fed_kg == pytest.approx(fed_kg, rel=1e-12)
        due_kg = rate_kg_per_s * max(0.0, min(interval.start_s, 0.06) - 0.01)
        assert feed.due_kg == pytest.approx(due_kg, abs=1e-12)
        assert abs(feed.due_kg - feed.fed_kg) <= HALVES_KG + 1e-12


def test_nothing_before_the_start_and_nothing_after_the_stop() -> None:
    offers = all_accepted(RateFeed(INLET), 100, 1e-3)
    fed = [index for index, offer in enumerate(offers) if len(offer)]
    assert fed[0] > 10
    assert fed[-1] <= 60
    assert total_kg(offers) == pytest.approx(2.0 * 0.05, abs=HALVES_KG)


def test_every_class_keeps_its_share_of_the_mass() -> None:
    """Each class stays within half of its largest particle of its share of what is due, 0.3 kg."""
    feed = RateFeed(replace(INLET, start_s=0.0, stop_s=math.inf))
    offers = all_accepted(feed, 150, 1e-3)
    diameter_m = np.concatenate([offer.grains.sieve_size_m for offer in offers])
    largest_kg = sphere_kg(np.array([row.largest_m for row in COAL]), 1430.0)
    class_kg = mass_shares(diameter_m, COAL) * total_kg(offers)
    assert np.all(abs(class_kg - feed.due_kg * np.array([0.3, 0.3, 0.4])) <= largest_kg / 2.0)


def test_lumps_come_when_half_of_one_is_due_and_fines_meanwhile() -> None:
    """A lump of 100 mm (0.749 kg) is 3 % of the mass: the first is due with 12.5 kg, the second with 37.4."""
    sizes = (size_class(0.01, 0.01, 0.97), size_class(0.1, 0.1, 0.03))
    inlet = replace(INLET, sizes=sizes, rate_kg_per_s=1.0, start_s=0.0, stop_s=math.inf)
    feed, lump_at_kg, fines_kg = RateFeed(inlet), [], 0.0
    for index in range(400):
        offer = feed.due(Interval(index, 0.1))
        feed.settle(np.ones(len(offer), dtype=bool))
        lump_at_kg += [feed.due_kg] * int(np.count_nonzero(offer.grains.sieve_size_m == 0.1))
        fines_kg += total_kg([offer.part(offer.grains.sieve_size_m < 0.1)])
        assert abs(fines_kg - 0.97 * feed.due_kg) < 0.01  # twenty grains, which had no room meanwhile
    lump_kg = 1430.0 * math.pi / 6 * 1e-3
    np.testing.assert_allclose(lump_at_kg, [lump_kg / 0.06, lump_kg / 0.02], atol=0.1)


def test_particles_appear_wholly_inside_the_box_with_the_velocity_given() -> None:
    offers = all_accepted(RateFeed(INLET), 60, 1e-3)
    for offer in offers:
        reach_m = offer.grains.sieve_size_m[:, None] / 2.0
        assert np.all(offer.position_m - reach_m >= INLET.box_m[0] - 1e-15)
        assert np.all(offer.position_m + reach_m <= INLET.box_m[1] + 1e-15)
        assert np.all(offer.velocity_m_per_s == [0.0, 0.0, -1.0])
        np.testing.assert_array_equal(offer.grains.material, 1)


def test_refused_particles_are_tried_again_elsewhere() -> None:
    feed = RateFeed(INLET)
    refused = feed.due(Interval(15, 1e-3))
    feed.settle(np.zeros(len(refused), dtype=bool))
    assert feed.fed_kg == 0.0
    again = feed.due(Interval(15, 1e-3))
    np.testing.assert_array_equal(again.grains.sieve_size_m, refused.grains.sieve_size_m)
    assert not np.any(again.position_m == refused.position_m)


def test_a_rate_too_large_for_the_box_shows_as_backlog() -> None:
    """An inlet that never clears takes what fits once; the rest waits."""
    feed = RateFeed(replace(INLET, sizes=LUMPS, rate_kg_per_s=200.0, start_s=0.0))
    offer = feed.due(Interval(10, 1e-3))
    feed.settle(np.ones(len(offer), dtype=bool))
    assert smallest_gap_m(offer) >= 0.0
    assert feed.due_kg - feed.fed_kg > 0.5
    assert feed.due_kg == pytest.approx(2.0)


def test_the_largest_rate_is_what_leaves_a_box_filled_by_a_fifth() -> None:
    assert INLET.largest_rate_kg_per_s == pytest.approx(0.2 * 1430.0 * 0.1 * 0.2 * 1.0)
    seldom = replace(INLET, batch_s=0.5)  # the box empties in 0.1 s
    assert seldom.largest_rate_kg_per_s == pytest.approx(0.2 * 1430.0 * 0.1 * 0.2 * 0.1 / 0.5)


def largest_rate_found_kg_per_s(inlet: Inlet) -> float:
    """Return the rate that goes in where as much as a third of the box is always waiting; particles keep
    their velocity."""
    feed = RateFeed(replace(inlet, start_s=0.0, stop_s=math.inf))
    low, high = inlet.box_m
    present_m, reach_m, fed_kg = np.empty((0, 3)), np.empty(0), []
    batches = 3 * math.ceil(
        np.max(
            (high - low)
            / np.maximum(np.abs(inlet.velocity_m_per_s), 1e-9)
            * (np.abs(inlet.velocity_m_per_s) > 0)
        )
        / inlet.batch_s
    )
    for index in range(max(batches, 12)):
        waiting_kg = 0.33 * inlet.grain.density_kg_per_m3 * float(np.prod(high - low))
        rate = (feed.fed_kg + waiting_kg) / (max(index, 1) * inlet.batch_s)
        feed.inlet = replace(feed.inlet, rate_kg_per_s=rate)
        offer = feed.due(Interval(max(index, 1), inlet.batch_s))
        radius_m = offer.grains.sieve_size_m / 2.0
        free = np.ones(len(offer), dtype=bool)
        if len(reach_m) and len(offer):
            apart_m = cdist(offer.position_m, present_m)
            free = np.all(apart_m >= radius_m[:, None] + reach_m[None], axis=1)
        feed.settle(free)
        fed_kg.append(feed.fed_kg)
        present_m = np.vstack([present_m, offer.position_m[free]])
        present_m = present_m + inlet.batch_s * np.asarray(inlet.velocity_m_per_s)
        reach_m = np.append(reach_m, radius_m[free])
        near = np.all((present_m > low - 0.03) & (present_m < high + 0.03), axis=1)
        present_m, reach_m = present_m[near], reach_m[near]
    third = len(fed_kg) // 3
    return (fed_kg[-1] - fed_kg[third]) / ((len(fed_kg) - 1 - third) * inlet.batch_s)


@pytest.mark.parametrize(
    ("smallest_m", "largest_m", "box_m", "velocity_m_per_s", "batch_s"),
    [
        (0.008, 0.013, (0.1, 0.1, 0.03), (0.0, 0.0, -1.0), 1e-3),
        (0.008, 0.013, (0.1, 0.1, 0.03), (0.0, 0.0, -1.0), 4e-3),
        (0.008, 0.013, (0.1, 0.1, 0.03), (0.0, 0.0, -1.0), 6e-2),  # empties between batches
        (0.025, 0.030, (0.1, 0.1, 0.1), (0.0, 0.0, -1.0), 2e-3),
        (0.006, 0.008, (0.05, 0.05, 0.05), (0.5, 0.0, -0.5), 4e-3),
    ],
)
def test_the_largest_rate_is_no_more_than_what_is_found(
    smallest_m: float,
    largest_m: float,
    box_m: tuple[float, ...],
    velocity_m_per_s: tuple[float, ...],
    batch_s: float,
) -> None:
    """A case is refused above the estimate: what is let through must be possible (measured 1.0 to
    1.6 times the estimate), and little that is possible refused."""
    inlet = replace(
        INLET,
        sizes=(size_class(smallest_m, largest_m, 1.0),),
        box_m=np.array([np.zeros(3), box_m]),
        velocity_m_per_s=np.array(velocity_m_per_s),
        batch_s=batch_s,
    )
    found_kg_per_s = largest_rate_found_kg_per_s(inlet)
    assert 1.0 <= found_kg_per_s / inlet.largest_rate_kg_per_s <= 1.7


def test_a_rate_below_the_largest_finds_room() -> None:
    """Particles leave the box at the inlet's velocity; those still inside block the others."""
    inlet = replace(INLET, sizes=LUMPS, rate_kg_per_s=INLET.largest_rate_kg_per_s, start_s=0.0)
    inlet = replace(inlet, stop_s=math.inf)
    feed, present_m, reach_m = RateFeed(inlet), np.empty((0, 3)), np.empty(0)
    for index in range(200):
        offer = feed.due(Interval(index, 2e-3))
        radius_m = offer.grains.sieve_size_m / 2.0
        apart_m = np.linalg.norm(offer.position_m[:, None] - present_m[None], axis=2)
        free = np.all(apart_m >= radius_m[:, None] + reach_m[None], axis=1)
        feed.settle(free)
        present_m = np.vstack([present_m, offer.position_m[free]]) + 2e-3 * inlet.velocity_m_per_s
        reach_m = np.append(reach_m, radius_m[free])
        near = present_m[:, 2] > 0.48
        present_m, reach_m = present_m[near], reach_m[near]
    assert feed.fed_kg > 1.0
    assert feed.due_kg - feed.fed_kg < 0.05 * feed.fed_kg


def test_a_pickle_goes_on_the_same() -> None:
    feed = RateFeed(INLET)
    all_accepted(feed, 25, 1e-3)
    copy = pickle.loads(pickle.dumps(feed))
    first, second = (source.due(Interval(26, 1e-3)) for source in (feed, copy))
    assert len(first)
    np.testing.assert_array_equal(first.position_m, second.position_m)
    np.testing.assert_array_equal(first.grains.sieve_size_m, second.grains.sieve_size_m)


def test_a_sampled_feed_goes_on_the_same_from_a_checkpoint() -> None:
    """Particles of 6 to 10 mm, 30 % of the mass, come as often as those of 12 mm; a restored feed offers
    the same ones."""
    rows = [{"smallest_m": 0.006, "largest_m": 0.01, "mass_fraction": 0.3}]
    rows += [{"smallest_m": 0.01, "largest_m": 0.02, "mass_fraction": 0.7}]
    box_m = ((0.0, 0.0, 0.5), (0.1, 0.2, 0.6))
    table = {"material": "coal", "rate_kg_per_s": 2.0, "box_m": box_m, "sizes": rows}
    sample = Feed.model_validate(table | {"sampled_below_m": 0.01, "sampled_as_m": 0.012})
    rate_kg_per_s = 2.0 * (1.0 - share_left_out(sample))
    inlet = replace(
        INLET, sizes=classes(sample), rate_kg_per_s=rate_kg_per_s, start_s=0.0, stop_s=math.inf, seed=5
    )
    feed, again = RateFeed(inlet), RateFeed(inlet)
    offers = all_accepted(feed, 2000, 1e-3)
    number = sum(int(np.count_nonzero(offer.grains.sieve_size_m < 0.01)) for offer in offers)
    expected = 0.3 * 2.0 * 1.999 / sphere_kg(0.012, 1430.0)
    assert number == pytest.approx(expected, abs=3 * (0.1 * expected) ** 0.5)  # masses vary by 40 %
    again.restore(feed.save())
    first, second = (source.due(Interval(2000, 1e-3)) for source in (feed, again))
    assert len(first)
    np.testing.assert_array_equal(first.position_m, second.position_m)
    np.testing.assert_array_equal(first.grains.sieve_size_m, second.grains.sieve_size_m)


def test_answers_must_fit_the_offer() -> None:
    feed = RateFeed(INLET)
    offered = len(feed.due(Interval(30, 1e-3)))
    with pytest.raises(ValueError, match=rf"\b{offered}\b.*\b0\b"):
        feed.settle(np.zeros(0, dtype=bool))


def test_several_feeds_are_one() -> None:
    other = replace(
        INLET,
        box_m=INLET.box_m + 1.0,
        sizes=(size_class(0.012, 0.013, 1.0),),
        rate_kg_per_s=6.0,
        grain=one_sphere(1.0, material=0),
        seed=2,
    )
    feeds = Feeds([INLET, other])
    offer = feeds.due(Interval(40, 1e-3))
    wanted = offer.grains.material == 0
    feeds.settle(wanted)
    assert 0 < wanted.sum() < len(offer)
    assert feeds.feeds[0].fed_kg == 0.0
    assert feeds.feeds[1].fed_kg == pytest.approx(6.0 * 0.03, abs=LARGEST_KG)


def test_feeds_through_one_box_are_refused() -> None:
    with pytest.raises(ValueError, match="overlap"):
        Feeds([INLET, replace(INLET, box_m=INLET.box_m + 0.05)])
