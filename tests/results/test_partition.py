"""Partition curves whose points are known."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator.output.results.screening import (
    FEWEST_IN_CLASS,
    cut_and_spread,
    partition,
    size_at,
    size_classes,
)


def test_numbers_by_hand() -> None:
    under, over = np.array([9.0, 3.0, 0.0, 0.0]), np.array([1.0, 1.0, 5.0, 0.0])
    assert partition(under, over)[:3] == pytest.approx([0.1, 0.25, 1.0])
    assert np.isnan(partition(under, over)[3])


def test_d50_and_ep_of_a_straight_curve() -> None:
    """Rising straight from 0 at 2 mm to 1 at 6 mm: d50 = 4 mm, Ep = (5 - 3)/2 = 1 mm."""
    size = np.array([1.0, 2.0, 3.5, 4.5, 6.0, 8.0])
    d50, ep = cut_and_spread(size, np.clip((size - 2) / 4, 0, 1))
    assert d50 == pytest.approx(4.0, rel=1e-14)
    assert ep == pytest.approx(1.0, rel=1e-14)


def test_a_curve_that_does_not_reach_has_no_d50() -> None:
    assert np.isnan(size_at(0.5, np.array([1.0, 2.0]), np.array([0.1, 0.4])))


def test_empty_classes_are_passed_over() -> None:
    number = np.array([0.0, np.nan, 1.0])
    assert size_at(0.5, np.array([1.0, 2.0, 3.0]), number) == pytest.approx(2.0)


def test_classes_hold_everything_and_keep_the_cut() -> None:
    rng = np.random.default_rng(1)
    diameter = np.concatenate([rng.uniform(1.0, 6.0, 500), [12.0]])
    edges = size_classes(diameter, 3.0)
    counts = np.histogram(diameter, edges)[0]
    assert counts.sum() == len(diameter)
    assert 3.0 in edges
    assert (np.diff(edges) > 0).all()
    assert (counts[:-1] >= FEWEST_IN_CLASS).all()


def test_particles_of_one_size_are_one_class() -> None:
    assert np.histogram(np.full(7, 0.004), size_classes(np.full(7, 0.004), None))[0].tolist() == [7]


def test_an_exact_logistic_curve_from_particles() -> None:
    """Particles sent over with probability 1 / (1 + exp(-(d - 3)/w)): d50 = 3 and
    Ep = w ln 3; classes of finite width are good to a fifth of a class or so."""
    rng = np.random.default_rng(5)
    diameter = rng.uniform(1.0, 6.0, 200_000)
    width = 0.5
    over = rng.uniform(size=len(diameter)) < 1 / (1 + np.exp(-(diameter - 3.0) / width))
    edges = size_classes(diameter, None)
    number = np.histogram(diameter, edges)[0]
    mean_d = np.histogram(diameter, edges, weights=diameter)[0] / number
    sent = partition(*(np.histogram(diameter[part], edges)[0].astype(float) for part in (~over, over)))
    d50, ep = cut_and_spread(mean_d, sent)
    assert d50 == pytest.approx(3.0, rel=0.02)
    assert ep == pytest.approx(width * np.log(3), rel=0.05)
