"""The noise of each run: told by the run, by replicates, or by neither."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator.ports import Array
from orchestrator.studies.design.data import Data, completed_variance
from orchestrator.studies.design.scales import SCALES
from orchestrator.studies.design.space import Space
from orchestrator.studies.design.trials import Measured, Outcome, Trial

LIKELY, UNLIKELY = 13.2, 13.4
"""Sums of squares around 13.2767, which 4 independent errors of one standard deviation exceed with a
probability of 0.01 (the 99 % quantile of chi-square with 4 degrees of freedom, as in any table)."""


def replicates(sum_of_squares: float) -> tuple[Array, Array]:
    """Return five runs of the centre whose errors have a sum of squares, and two other runs."""
    x = np.array([[0.0]] * 5 + [[-1.0], [1.0]])
    side = np.sqrt(sum_of_squares / 4)
    return x, np.array([3 - side, 3 + side, 3.0, 3 - side, 3 + side, 1.0, 5.0])


def test_replicates_that_scatter_as_much_as_they_should_widen_nothing() -> None:
    x, y = replicates(LIKELY)
    variance, factor = completed_variance(x, y, np.ones(7))
    assert factor == 1.0
    assert variance.tolist() == [1.0] * 7


def test_replicates_that_scatter_more_widen_the_noise_of_all_runs() -> None:
    x, y = replicates(UNLIKELY)
    variance, factor = completed_variance(x, y, np.ones(7))
    assert factor == pytest.approx(np.sqrt(UNLIKELY / 4))
    assert variance == pytest.approx(UNLIKELY / 4)


def test_runs_that_tell_no_noise_are_widened_with_the_others() -> None:
    x, y = replicates(UNLIKELY)
    variance, factor = completed_variance(x, y, np.array([1.0] * 5 + [np.nan, 1.0]))
    assert factor > 1.0
    assert variance == pytest.approx(UNLIKELY / 4)


def test_replicates_without_noise_of_their_own_are_held_against_that_of_the_others() -> None:
    x, y = replicates(UNLIKELY)
    variance, factor = completed_variance(x, y, np.array([np.nan] + [1.0] * 6))
    assert factor == pytest.approx(np.sqrt(UNLIKELY / 4))
    assert variance == pytest.approx(UNLIKELY / 4)


def test_replicates_at_several_settings_are_put_together() -> None:
    """Two at each of four settings; what differs from setting to setting is no noise."""
    x = np.repeat(np.array([[-1.0], [0.0], [0.5], [1.0]]), 2, axis=0)
    y = np.repeat([10.0, 20.0, 30.0, 40.0], 2) + np.tile([-1.0, 1.0], 4) * np.sqrt(LIKELY / 8)
    assert completed_variance(x, y, np.ones(8))[1] == 1.0
    wide = np.repeat([10.0, 20.0, 30.0, 40.0], 2) + np.tile([-1.0, 1.0], 4) * np.sqrt(UNLIKELY / 8)
    assert completed_variance(x, wide, np.ones(8))[1] == pytest.approx(np.sqrt(UNLIKELY / 4))


def test_the_scatter_of_replicates_is_the_noise_where_runs_tell_none() -> None:
    x, y = replicates(8.0)
    variance, factor = completed_variance(x, y, np.full(7, np.nan))
    assert factor == 1.0
    assert variance == pytest.approx(2.0)


def test_two_replicates_that_agree_by_luck_do_not_make_runs_exact() -> None:
    """Nine settings of a plane with a noise of 0.5, and two equal runs of the centre.  By hand: one degree of
    freedom without scatter and three of the residuals make 3/4 of the latter's variance."""
    rng = np.random.default_rng(3)
    x = np.vstack([rng.uniform(-1, 1, (9, 2)), np.zeros((2, 2))])
    y = 2 + x @ [1.0, -3.0] + 0.5 * rng.standard_normal(11)
    y[-1] = y[-2]
    terms = np.column_stack([np.ones(11), x, x[:, 0] * x[:, 1], x**2])
    squares = float(np.linalg.lstsq(terms, y, rcond=None)[1][0])
    variance, _ = completed_variance(x, y, np.full(11, np.nan))
    assert variance == pytest.approx(0.75 * squares / (11 - 6))


def test_a_run_that_tells_no_noise_has_the_median_noise_of_the_others() -> None:
    x, y = replicates(1.0)
    stated = np.array([1.0, 2.0, np.nan, 1.0, 1.0, 5.0, 7.0])
    variance, _ = completed_variance(x, y, stated)
    assert variance.tolist() == [1.0, 2.0, 1.5, 1.0, 1.0, 5.0, 7.0]


def test_without_any_knowledge_the_noise_is_what_no_smooth_surface_explains() -> None:
    """The standard deviation of 0.3 is known to 0.04 from forty runs."""
    x = Space(-np.ones(2), np.ones(2)).sample(40, 1)
    y = np.sin(2.0 * x[:, 0]) - x[:, 1] + 0.3 * np.random.default_rng(1).standard_normal(40)
    variance, factor = completed_variance(x, y, np.full(40, np.nan))
    assert np.sqrt(variance) == pytest.approx(0.3, abs=0.08)
    assert factor == 1.0


def test_data_on_a_plane_are_taken_to_have_a_thousandth_of_their_variance_as_noise() -> None:
    y = np.array([1.0, 2.0, 3.0])
    variance, _ = completed_variance(np.array([[-1.0], [0.0], [1.0]]), y, np.full(3, np.nan))
    assert variance == pytest.approx(1e-3 * 2 / 3)


def test_a_response_that_some_replicates_lack_is_judged_by_the_others() -> None:
    x, y = replicates(UNLIKELY)
    x, y = np.vstack([x, x[:3]]), np.concatenate([y, [np.nan] * 3])
    assert completed_variance(x, y, np.ones(10))[1] == pytest.approx(np.sqrt(UNLIKELY / 4))


def test_data_are_on_the_scales_of_their_responses_and_failed_runs_are_none() -> None:
    """The slope of the logit of a percentage p is 100 / (p (100 - p))."""
    outcomes = [
        Outcome(Trial(3, "plan", (1.0,), 2), "done", "", {"share": Measured(80.0, 0.4)}),
        Outcome(Trial(2, "plan", (0.0,), 1), "failed", "it jams", {"share": Measured(10.0, 1.0)}),
        Outcome(Trial(1, "centre", (0.0,), 0), "done", "", {"speed": Measured(2.0, 0.1)}),
    ]
    data = Data.of(outcomes, {"speed": SCALES["plain"], "share": SCALES["percent"]})
    assert data.numbers.tolist() == [1, 3]
    assert data.x.tolist() == [[0.0], [1.0]]
    assert data.y[0, 0] == 2.0
    assert np.isnan(data.y[[0, 1], [1, 0]]).all()
    assert data.y[1, 1] == pytest.approx(np.log(4.0))
    assert data.variance[1, 1] == pytest.approx((0.4 * 100 / (80 * 20)) ** 2)
