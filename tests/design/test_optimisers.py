"""The contract of an optimiser of the design chain, tested of each of them; and known best settings.

The best settings of the surfaces of Table 5 were computed with SLSQP from sixty starts.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from orchestrator.ports import Array
from orchestrator.studies.design.aim import Aim, Goal, Limit
from orchestrator.studies.design.front import improvements
from orchestrator.studies.design.gaussian_process import GaussianProcess
from orchestrator.studies.design.optimisers import (
    OPTIMISERS,
    ExpectedImprovement,
    Gradient,
    Optimiser,
    Whale,
    predict_each,
)
from orchestrator.studies.design.plans import box_behnken
from orchestrator.studies.design.quadratic import Quadratic
from orchestrator.studies.design.space import SimplerSpace, Space
from orchestrator.studies.design.surrogates import Fitted
from tests.design.functions import SCREEN_WITH_BAND
from tests.design.table5 import fitted_quadratic, table_5

CUBE = Space(-np.ones(3), np.ones(3))
FALLING = Space(-np.ones(3), np.ones(3), chains=((0, 1, 2),))
GRID = np.stack(np.meshgrid(*[np.linspace(-1, 1, 21)] * 3), axis=-1).reshape(-1, 3)
FAST = Goal(0, 1.0)
EVERY = pytest.mark.parametrize("kind", OPTIMISERS.values(), ids=OPTIMISERS)
IN_EACH = pytest.mark.parametrize("space", [CUBE, FALLING], ids=["cube", "ordered"])


def truth(x: Array) -> Array:
    """Compute velocity and efficiency, (n, 2), of settings of three factors."""
    a, b, c = x.T
    return np.column_stack([1.0 + 0.6 * a + 0.2 * b - 0.1 * c**2, 80.0 - 15.0 * a - 10.0 * b + 3.0 * a * c])


@cache
def plan() -> Array:
    """Return the settings that were run."""
    return box_behnken(3)


@cache
def fitted() -> Fitted:
    """Fit quadratics to noisy runs of the plan."""
    noise = np.random.default_rng(1).standard_normal((len(plan()), 2)) * [0.01, 0.5]
    return Quadratic().fit(plan(), truth(plan()) + noise, np.ones((len(plan()), 2)), 1)


def at_least(efficiency: float, confidence: float = 0.9) -> Aim:
    """Return the aim of the largest velocity with a limit to the efficiency."""
    return Aim((FAST,), (Limit(1, 1.0, efficiency),), confidence)


def propose(kind: type[Optimiser], aim: Aim, space: Space = CUBE, seed: int = 1) -> Array:
    """Propose a setting after the plan."""
    return kind().propose(fitted(), aim, space, plan(), np.random.default_rng(seed))


def recommend(kind: type[Optimiser], aim: Aim, space: Space = CUBE, seed: int = 1) -> Array:
    """Recommend a setting after the plan."""
    return kind().recommend(fitted(), aim, space, plan(), np.random.default_rng(seed))


def probability(aim: Aim, x: Array) -> float:
    """Return the probability that a setting keeps the limits."""
    return float(np.exp(aim.log_probability(*predict_each(fitted(), x[None])))[0])


@cache
def best_on_the_grid(aim: Aim, ordered: bool) -> float:
    """Return the largest velocity that keeps the limits with the aim's confidence, on a grid."""
    grid = GRID[(np.diff(GRID) <= 1e-12).all(axis=1)] if ordered else GRID
    mean, deviation = predict_each(fitted(), grid)
    return float(mean[0][aim.log_probability(mean, deviation) >= np.log(aim.confidence)].max())


@EVERY
@IN_EACH
def test_settings_lie_in_the_ranges_and_keep_the_order(kind: type[Optimiser], space: Space) -> None:
    for seed, choose in ((1, propose), (2, propose), (3, recommend)):
        x = choose(kind, at_least(80.0), space, seed)
        assert x.shape == (3,)
        assert (np.abs(x) <= 1.0).all()
        assert space is CUBE or (np.diff(x) <= 0.0).all()


@EVERY
def test_one_generator_gives_one_setting(kind: type[Optimiser]) -> None:
    for choose in (propose, recommend):
        first, again = choose(kind, at_least(80.0)), choose(kind, at_least(80.0))
        np.testing.assert_array_equal(first, again)


@EVERY
@IN_EACH
@pytest.mark.parametrize("confidence", [0.5, 0.9, 0.99])
def test_what_is_recommended_is_best_and_keeps_the_limit_with_confidence(
    kind: type[Optimiser], space: Space, confidence: float
) -> None:
    aim = at_least(80.0, confidence)
    x = recommend(kind, aim, space)
    assert probability(aim, x) > confidence - 1e-4
    velocity = float(predict_each(fitted(), x[None])[0][0, 0])
    assert velocity > best_on_the_grid(aim, space is FALLING) - 0.02


@EVERY
def test_two_limits_hold_together_with_confidence(kind: type[Optimiser]) -> None:
    aim = Aim((FAST,), (Limit(1, 1.0, 80.0), Limit(0, -1.0, 1.1)), 0.9)
    assert probability(aim, recommend(kind, aim)) > 0.9 - 1e-4


@EVERY
def test_a_goal_without_limits_is_taken_to_its_end(kind: type[Optimiser]) -> None:
    for goal, corner in ((FAST, [1.0, 1.0]), (Goal(0, -1.0), [-1.0, -1.0])):
        x = recommend(kind, Aim((goal,)))
        assert x[:2] == pytest.approx(corner, abs=0.05)


@EVERY
@pytest.mark.parametrize("limit", [108.5, 130.0], ids=["hardly", "not at all"])
def test_where_no_setting_is_so_sure_the_surest_is_recommended(kind: type[Optimiser], limit: float) -> None:
    aim = at_least(limit)
    surest = float(aim.margin(*predict_each(fitted(), GRID)).max())
    assert surest < 1.0
    x = recommend(kind, aim)
    assert float(aim.margin(*predict_each(fitted(), x[None]))[0]) > surest - 0.3


@EVERY
@pytest.mark.parametrize("unit", [1e-8, 1e8])
def test_other_units_of_the_responses_give_the_same_recommendation(
    kind: type[Optimiser], unit: float
) -> None:
    noise = np.random.default_rng(1).standard_normal((len(plan()), 2)) * [0.01, 0.5]
    y = (truth(plan()) + noise) * unit
    aim = Aim((Goal(0, -1.0),), (Limit(1, -1.0, 75.0 * unit),))
    other = Quadratic().fit(plan(), y, y, 1)
    x = kind().recommend(other, aim, CUBE, plan(), np.random.default_rng(1))
    same = recommend(kind, Aim((Goal(0, -1.0),), (Limit(1, -1.0, 75.0),)))
    assert predict_each(fitted(), x[None])[0][0] == pytest.approx(
        predict_each(fitted(), same[None])[0][0], abs=0.005
    )
    assert probability(Aim((FAST,), (Limit(1, -1.0, 75.0),)), x) > 0.9 - 1e-3


@EVERY
def test_two_goals_are_searched_too(kind: type[Optimiser]) -> None:
    aim = Aim((FAST, Goal(1, 1.0)), (Limit(0, 1.0, 0.5),))
    for choose in (propose, recommend):
        assert (np.abs(choose(kind, aim)) <= 1.0).all()


@EVERY
def test_a_simpler_design_is_kept(kind: type[Optimiser]) -> None:
    """The second factor follows from the first."""

    def simplify(x: Array) -> Array:
        simple = x.copy()
        simple[:, 1] = -0.5 * simple[:, 0]
        return simple

    space = SimplerSpace(-np.ones(3), np.ones(3), (), simplify)
    done = recommend(Gradient, at_least(80.0, 0.95))[None]  # better than any simpler one
    for choose in (kind().propose, kind().recommend):
        x = choose(fitted(), at_least(80.0), space, done, np.random.default_rng(1))
        assert x[1] == pytest.approx(-0.5 * x[0], abs=1e-12)
    best = GRID[np.isclose(GRID[:, 1], -0.5 * GRID[:, 0])]
    mean, deviation = predict_each(fitted(), best)
    kept = at_least(80.0).log_probability(mean, deviation) >= np.log(0.9)
    assert predict_each(fitted(), x[None])[0][0, 0] > mean[0][kept].max() - 0.02


@EVERY
def test_the_best_simpler_design_is_not_the_best_design_made_simple(kind: type[Optimiser]) -> None:
    """Three equal factors are best at 0.2, the mean of what is best for each; the first alone at 0.9."""
    y = -((plan() - [0.9, 0.2, -0.5]) ** 2).sum(axis=1)
    surface = Quadratic().fit(plan(), y[:, None], np.ones((len(plan()), 1)), 1)
    space = SimplerSpace(-np.ones(3), np.ones(3), ((0, 1, 2),), lambda x: np.repeat(x[:, :1], 3, axis=1))
    x = kind().recommend(surface, Aim((FAST,)), space, plan(), np.random.default_rng(1))
    assert x == pytest.approx([0.2, 0.2, 0.2], abs=0.02)


@EVERY
def test_what_was_done_is_left_as_it_is(kind: type[Optimiser]) -> None:
    done = plan().copy()
    kind().propose(fitted(), at_least(80.0), FALLING, done, np.random.default_rng(1))
    kind().recommend(fitted(), at_least(80.0), FALLING, done, np.random.default_rng(1))
    np.testing.assert_array_equal(done, plan())


@pytest.mark.parametrize(
    ("efficiency", "velocity", "setting"),
    [
        (80.0, 1.593406, [0.0283, -1.0, 1.0, 0.5575, 0.3758]),
        (90.0, 1.261381, [0.1018, -1.0, 1.0, 0.1317, 0.1593]),
    ],
    ids=["80 %", "90 %"],
)
def test_the_best_velocity_of_table_5_is_found(
    efficiency: float, velocity: float, setting: list[float]
) -> None:
    aim, space = at_least(efficiency, 0.5), Space(-np.ones(5), np.ones(5))
    x = Gradient().recommend(fitted_quadratic(), aim, space, table_5()[0], np.random.default_rng(1))
    mean, _ = predict_each(fitted_quadratic(), x[None])
    assert mean[0, 0] == pytest.approx(velocity, abs=1e-4)
    assert mean[1, 0] == pytest.approx(efficiency, abs=1e-4)
    assert x == pytest.approx(setting, abs=2e-3)
    for seed in range(5):
        x = Whale().propose(fitted_quadratic(), aim, space, table_5()[0], np.random.default_rng(seed))
        mean, _ = predict_each(fitted_quadratic(), x[None])
        assert mean[0, 0] == pytest.approx(velocity, rel=0.01)
        assert mean[1, 0] >= efficiency


def test_the_expected_gain_leads_to_unknown_settings() -> None:
    """Two settings are equally good; one half of the range is known, the other is not."""
    x = np.linspace(-1.0, 0.0, 8)[:, None]
    y = np.cos(np.pi * x)  # largest at 0, and falling to both sides
    process = GaussianProcess().fit(x, y, np.full_like(y, 1e-6), 1)
    line = Space(-np.ones(1), np.ones(1))
    for seed in range(3):
        new = ExpectedImprovement().propose(process, Aim((FAST,)), line, x, np.random.default_rng(seed))
        assert new[0] > 0.05


def test_with_two_goals_the_expected_gain_is_that_of_the_area() -> None:
    """Two goals on a line, of which the middle of the front was not run."""
    x = np.array([[-1.0], [-0.9], [-0.8], [0.8], [0.9], [1.0]])
    y = np.column_stack([x[:, 0], -(x[:, 0] ** 2) - x[:, 0]])
    process = GaussianProcess().fit(x, y, np.full_like(y, 1e-8), 1)
    aim, line = Aim((FAST, Goal(1, 1.0))), Space(-np.ones(1), np.ones(1))
    new = ExpectedImprovement().propose(process, aim, line, x, np.random.default_rng(1))
    mean, _ = process.predict(np.vstack([new[None], np.linspace(-1, 1, 101)[:, None]]))
    area = improvements(y.T, np.array([-1.2, -2.2]), mean)
    assert area[0] > 0.9 * area.max()


def test_while_no_setting_keeps_the_limits_proposals_come_nearer_to_them() -> None:
    """The proposals come nearer also where this is so improbable that no draw shows it; and no setting is
    proposed twice."""
    problem, rng = SCREEN_WITH_BAND, np.random.default_rng(1)
    inefficient = problem.space.sample(64, 1)
    inefficient = inefficient[problem.truth(inefficient)[1] < 0.5][:14]
    y, variance = problem.observe(inefficient, rng)
    process = GaussianProcess().fit(inefficient, y, variance * 1e-4, 1)
    for limit in (3.0, 8.0, 1000.0):
        aim = Aim((FAST,), (Limit(1, 1.0, limit),))
        new = ExpectedImprovement().propose(process, aim, problem.space, inefficient, rng)
        margin = aim.margin(*predict_each(process, np.vstack([new[None], problem.space.sample(256, 2)])))
        assert margin[0] > np.quantile(margin[1:], 0.9)
        assert np.abs(inefficient - new).max(axis=1).min() > 1e-3
