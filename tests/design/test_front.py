"""Fronts of two goals, and the area that they dominate, against known ones."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator.ports import Array
from orchestrator.studies.design.aim import Aim, Goal, Limit
from orchestrator.studies.design.front import improvements, nondominated
from tests.design.functions import BNH, ZDT1, Problem, hypervolume


def gains_of(problem: Problem, settings: Array) -> Array:
    """Return the goals, (2, n), the larger the better, of actual settings that keep the limits."""
    y = problem.truth(settings)
    return np.asarray(problem.aim.gains(y)[:, problem.aim.kept(y)])


def test_limits_hold_on_their_side() -> None:
    """The limits are at least 2 of the first response, and at most 5 of the second."""
    aim = Aim((Goal(0, 1.0),), (Limit(0, 1.0, 2.0), Limit(1, -1.0, 5.0)))
    y = np.array([[1.9, 2.0, 3.0, 3.0], [4.0, 5.0, 5.1, 4.9]])
    assert aim.kept(y).tolist() == [False, True, False, True]
    assert (aim.margin(y, np.ones_like(y)) >= 0).tolist() == [False, True, False, True]


def test_the_front_of_zdt1_dominates_a_known_area() -> None:
    """0.876667: 1.21 less the area under 1 - sqrt(x), and the strips beside it."""
    first = np.linspace(0.0, 1.0, 300) ** 2
    gains = gains_of(ZDT1, np.column_stack([first, np.zeros((300, 3))]))
    assert hypervolume(gains, np.array([-1.1, -1.1])) == pytest.approx(0.876667, rel=0.004)
    assert hypervolume(gains, np.array([-1.1, -1.1])) < 0.876667


def test_the_front_of_bnh_dominates_a_known_area() -> None:
    both, second = np.linspace(0.0, 3.0, 200), np.linspace(3.0, 5.0, 100)
    settings = np.vstack([np.column_stack([both, both]), np.column_stack([second, np.full(100, 3.0)])])
    gains = gains_of(BNH, settings)
    assert gains[:, 0].tolist() == [0.0, -50.0]
    assert gains[:, -1].tolist() == [-136.0, -4.0]
    assert hypervolume(gains, np.array([-140.0, -50.0])) == pytest.approx(5285.3333, rel=0.004)


def test_the_area_of_a_few_points_is_counted_by_hand() -> None:
    points = np.array([[1.0, 2.0, 3.0, 1.5], [3.0, 2.0, 1.0, 1.5]])  # a staircase, and one below it
    assert hypervolume(points, np.zeros(2)) == pytest.approx(6.0)
    assert hypervolume(points[:, ::-1], np.zeros(2)) == pytest.approx(6.0)
    assert hypervolume(points[:, [0, 0]], np.zeros(2)) == pytest.approx(3.0)
    assert hypervolume(points, np.array([1.5, 0.5])) == pytest.approx(0.5 * 1.5 + 1.0 * 0.5)
    assert hypervolume(points, np.array([9.0, 9.0])) == 0.0
    assert hypervolume(np.empty((2, 0)), np.zeros(2)) == 0.0


def test_what_a_point_adds_is_the_difference_of_areas() -> None:
    rng = np.random.default_rng(1)
    for _ in range(20):
        points, new = rng.random((2, 8)), rng.random((2, 30)) * 1.2
        reference = rng.random(2) * 0.4
        before = hypervolume(points, reference)
        added = improvements(points, reference, new)
        for i in range(30):
            after = hypervolume(np.column_stack([points, new[:, i]]), reference)
            assert added[i] == pytest.approx(after - before, abs=1e-12)


def test_the_area_is_the_share_of_random_points_that_are_dominated() -> None:
    rng = np.random.default_rng(2)
    points, samples = rng.random((2, 10)), rng.random((2, 200_000))
    dominated = (points[:, :, None] >= samples[:, None, :]).all(axis=0).any(axis=0)
    assert hypervolume(points, np.zeros(2)) == pytest.approx(dominated.mean(), abs=0.005)


def test_a_point_is_on_the_front_unless_another_is_better_in_one_and_no_worse_in_the_other() -> None:
    gains = np.array([[1.0, 2.0, 2.0, 3.0, 0.0, 1.0], [3.0, 2.0, 1.0, 0.0, 3.0, 3.0]])
    kept = np.ones(6, bool)
    assert nondominated(gains, kept).tolist() == [True, True, False, True, False, True]


def test_a_point_that_breaks_a_limit_neither_counts_nor_dominates() -> None:
    gains = np.array([[1.0, 2.0, 0.5], [1.0, 2.0, 0.5]])
    assert nondominated(gains, np.array([True, False, True])).tolist() == [True, False, False]
    assert not nondominated(gains, np.zeros(3, bool)).any()
