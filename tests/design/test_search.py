"""Whole searches on noisy functions whose best settings are known.

Bounds: twice to four times what a search of this kind reached here in some ten repetitions; of the hidden
screens, the median loss is at most 0.03 and 0.07 m/s.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest

from orchestrator.ports import Array
from orchestrator.studies.design.aim import Aim, Goal, Limit
from orchestrator.studies.design.gaussian_process import GaussianProcess
from orchestrator.studies.design.optimisers import ExpectedImprovement, Whale
from orchestrator.studies.design.plans import box_behnken
from orchestrator.studies.design.quadratic import Quadratic
from tests.design import functions
from tests.design.functions import BEST_VELOCITY, Problem, hypervolume, percent, study

PER_POINT = 2 * 0.0267  # m/s that a point of efficiency short counts: twice what it costs on the front
SCREENS = {"plain": functions.SCREEN, "band": functions.SCREEN_WITH_BAND}


def regrets(problem: Problem, best: float, start: int, total: int, seeds: Iterable[int]) -> Array:
    """Return how far what is recommended stays behind the best, for each seed."""
    goal = problem.aim.goals[0]
    values = []
    for seed in seeds:
        setting = study(problem, GaussianProcess(), ExpectedImprovement(), start, total, seed)[2]
        values.append(
            goal.sign * (best - problem.truth(problem.space.actual(setting[None]))[goal.response, 0])
        )
    return np.array(values)


def short_of_limits(problem: Problem, setting: Array) -> float:
    """Return by how much a coded setting breaks its limits at most."""
    truth = problem.truth(problem.space.actual(setting[None]))[:, 0]
    return max((each.sign * (each.value - truth[each.response]) for each in problem.aim.limits), default=0.0)


def loss_and_shortfall(screen: str, seed: int) -> tuple[float, float]:
    """Search a hidden screen with 27 runs: the velocity lost in m/s, with what is short in efficiency
    counted twice, and the points of efficiency that are short."""
    setting = study(SCREENS[screen], GaussianProcess(), ExpectedImprovement(), 13, 27, seed)[2]
    return judged(screen, setting)


def judged(screen: str, setting: Array) -> tuple[float, float]:
    """Return the loss of a setting, and its shortfall in points of efficiency."""
    velocity, logit = SCREENS[screen].truth(setting[None])[:, 0]
    shortfall = max(0.0, 80.0 - float(percent(logit)))
    return max(0.0, BEST_VELOCITY[screen] - velocity) + PER_POINT * shortfall, shortfall


@pytest.mark.slow
@pytest.mark.parametrize(("screen", "bound"), [("plain", 0.03), ("band", 0.07)])
def test_a_hidden_screen_is_nearly_as_fast_as_possible_after_27_runs(screen: str, bound: float) -> None:
    """No search of five is more than a point of efficiency short."""
    losses, shortfalls = zip(*(loss_and_shortfall(screen, seed) for seed in range(1, 6)), strict=True)
    assert np.median(losses) <= bound
    assert max(shortfalls) <= 1.0


def test_the_papers_way_is_some_ten_points_short_where_particles_fly() -> None:
    """A Box-Behnken plan, a quadratic of the percents and the whale algorithm lose 0.02 and 0.30 m/s."""
    x, aim = box_behnken(4), Aim((Goal(0, 1.0),), (Limit(1, 1.0, 80.0),))
    losses = {}
    for screen, problem in SCREENS.items():
        results = []
        for seed in range(5):
            rng = np.random.default_rng(seed)
            y, variance = problem.observe(x, rng)
            y[:, 1] = percent(y[:, 1])
            setting = Whale().propose(Quadratic().fit(x, y, variance, 1), aim, problem.space, x, rng)
            results.append(judged(screen, setting))
        losses[screen] = np.median(results, axis=0)
    assert losses["plain"][0] < 0.05
    assert losses["band"][0] > 0.2
    assert losses["band"][1] > 5.0


def test_the_smallest_value_of_branins_function_is_found() -> None:
    assert np.median(regrets(functions.BRANIN, 0.397887, 12, 30, (1, 2, 3))) < 0.4


@pytest.mark.parametrize(
    ("problem", "best", "bound", "tolerance"),
    [(functions.GARDNER_1, -2.0, 0.05, 0.02), (functions.GARDNER_2, 0.253236, 0.06, 0.02)],
    ids=["Gardner 1", "Gardner 2"],
)
@pytest.mark.slow
def test_the_best_setting_within_a_limit_is_found(
    problem: Problem, best: float, bound: float, tolerance: float
) -> None:
    """The second one allows 1.76 % of the square."""
    ends = [study(problem, GaussianProcess(), ExpectedImprovement(), 12, 30, seed)[2] for seed in (1, 2, 3)]
    values = [problem.truth(problem.space.actual(end[None]))[0, 0] for end in ends]
    assert np.median(values) - best < bound
    assert max(short_of_limits(problem, end) for end in ends) < tolerance


@pytest.mark.slow
def test_the_smallest_value_of_hartmanns_function_of_six_factors_is_found() -> None:
    assert np.median(regrets(functions.HARTMANN, -3.32237, 20, 60, (1, 2, 3))) < 0.3


@pytest.mark.slow
@pytest.mark.parametrize(
    ("problem", "reference", "volume", "start", "total"),
    [(functions.ZDT1, (-1.1, -1.1), 0.876667, 20, 60), (functions.BNH, (-140.0, -50.0), 5285.3333, 12, 40)],
    ids=["ZDT1", "BNH"],
)
def test_the_front_of_two_goals_is_found(
    problem: Problem, reference: tuple[float, float], volume: float, start: int, total: int
) -> None:
    """Sixty runs dominate at least 97 % of the area that the true front does, of the easier front forty."""
    x, _, _ = study(problem, GaussianProcess(), ExpectedImprovement(), start, total, 1)
    y = problem.truth(problem.space.actual(x))
    gains = problem.aim.gains(y)[:, problem.aim.kept(y)]
    assert hypervolume(gains, np.array(reference)) > 0.97 * volume
