"""The contract of a surrogate of the design chain, tested of each of them."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

from orchestrator.ports import Array
from orchestrator.studies.design.campaign import explained
from orchestrator.studies.design.models import SURROGATES
from orchestrator.studies.design.space import Space
from orchestrator.studies.design.surrogates import Fitted, Surrogate, TooFewPoints, calibrated

POINTS = 24
SQUARE = Space(-np.ones(2), np.ones(2))
X = SQUARE.sample(POINTS, 1)
NEW = SQUARE.sample(16, 7)
EVERY = pytest.mark.parametrize("kind", SURROGATES.values(), ids=SURROGATES)


def planes(x: Array) -> Array:
    """Compute two responses, (n, 2), of settings, of different size."""
    return np.column_stack([3.0 + 2.0 * x[:, 0] - x[:, 1], 800.0 - 50.0 * x[:, 0] + 20.0 * x[:, 1]])


def noisy() -> tuple[Array, Array]:
    """Return responses with noise, and its variances."""
    y = planes(X)
    deviation = 0.05 * y.std(axis=0)
    noise = deviation * np.random.default_rng(3).standard_normal(y.shape)
    return y + noise, np.broadcast_to(deviation**2, y.shape).copy()


@cache
def fit(kind: Callable[[], Surrogate]) -> Fitted:
    """Fit a surrogate to the noisy planes."""
    y, variance = noisy()
    return kind().fit(X, y, variance, 1)


@EVERY
def test_predictions_have_a_mean_and_a_covariance_for_each_response(kind: type[Surrogate]) -> None:
    fitted = fit(kind)
    for count in (1, 16):
        mean, cov = fitted.predict(NEW[:count])
        assert (mean.shape, cov.shape) == ((2, count), (2, count, count))
    mean, deviation = fitted.left_out()
    assert mean.shape == deviation.shape == (POINTS, 2)


@EVERY
def test_covariances_are_symmetric_and_positive(kind: type[Surrogate]) -> None:
    twice = np.vstack([NEW, NEW[:4], X[:4]])  # the same setting twice, and settings that were run
    for cov in fit(kind).predict(twice)[1]:
        np.testing.assert_allclose(cov, cov.T, rtol=1e-9, atol=1e-12 * np.trace(cov))
        assert np.linalg.eigvalsh(cov).min() > -1e-9 * np.trace(cov)
        assert (np.diagonal(cov) > 0).all()


@EVERY
def test_settings_are_predicted_alike_alone_and_together(kind: type[Surrogate]) -> None:
    fitted = fit(kind)
    mean, cov = fitted.predict(NEW)
    for i in (0, 5):
        one_mean, one_cov = fitted.predict(NEW[[i]])
        np.testing.assert_allclose(one_mean[:, 0], mean[:, i], rtol=1e-9)
        np.testing.assert_allclose(one_cov[:, 0, 0], cov[:, i, i], rtol=1e-6)


@EVERY
def test_a_plane_is_followed_within_its_noise(kind: type[Surrogate]) -> None:
    mean, _ = fit(kind).predict(NEW)
    assert (np.abs(mean.T - planes(NEW)) < 0.25 * planes(X).std(axis=0)).all()


@EVERY
def test_each_point_is_predicted_from_the_others(kind: type[Surrogate]) -> None:
    y, variance = noisy()
    mean, deviation = fit(kind).left_out()
    known = np.isfinite(mean)
    assert known.mean() > 0.8  # of a network, a point may have tested no member
    inside = np.abs(y - mean) <= 1.96 * np.sqrt(deviation**2 + variance)
    assert inside[known].mean() > 0.85
    q2 = [1.0 - np.var((y - mean)[known[:, i], i]) / np.var(y[:, i]) for i in range(2)]
    assert min(q2) > 0.97


@EVERY
def test_a_point_that_is_left_out_has_no_say_in_its_own_prediction(kind: type[Surrogate]) -> None:
    """Its response is moved by half of all responses' spread; its prediction moves far less."""
    y, variance = noisy()
    moved = y.copy()
    moved[5] += 0.5 * y.std(axis=0)
    before = fit(kind).left_out()[0][5]
    after = kind().fit(X, moved, variance, 1).left_out()[0][5]
    assert (np.abs(after - before) < 0.06 * y.std(axis=0)).all()


@EVERY
def test_a_run_is_not_predicted_from_another_run_of_its_setting(kind: type[Surrogate]) -> None:
    """Sixteen settings, run three times each, have responses without any order, which nothing can predict."""
    own = np.random.default_rng(3).standard_normal((16, 1))
    x, y = np.repeat(X[:16], 3, axis=0), np.repeat(own, 3, axis=0)
    mean, _ = kind().fit(x, y, np.full_like(y, 1e-4), 1).left_out()
    assert explained(y[:, 0], mean[:, 0]) < 0.0


@EVERY
def test_other_units_of_a_response_give_the_same_answer(kind: type[Surrogate]) -> None:
    y, variance = noisy()
    units = np.array([1024.0, 1.0 / 1024.0])
    other = kind().fit(X, y * units, variance * units**2, 1)
    (mean, cov), (other_mean, other_cov) = fit(kind).predict(NEW), other.predict(NEW)
    np.testing.assert_allclose(other_mean, mean * units[:, None], rtol=1e-3)
    deviations, others = (np.sqrt(np.diagonal(each, axis1=1, axis2=2)) for each in (cov, other_cov))
    np.testing.assert_allclose(others, deviations * units[:, None], rtol=0.02)
    for left, other_left in zip(fit(kind).left_out(), other.left_out(), strict=True):
        np.testing.assert_allclose(other_left, left * units, rtol=0.02)


@EVERY
def test_missing_responses_are_left_out(kind: type[Surrogate]) -> None:
    y, variance = noisy()
    y[[3, 8], 0] = np.nan
    y[20, 1] = np.nan
    fitted = kind().fit(X, y, variance, 1)
    mean, cov = fitted.predict(NEW)
    assert np.isfinite(mean).all()
    assert np.isfinite(cov).all()
    assert (np.abs(mean.T - planes(NEW)) < 0.25 * planes(X).std(axis=0)).all()
    left, deviation = fitted.left_out()
    assert not np.isfinite(left[np.isnan(y)]).any()
    assert not np.isfinite(deviation[np.isnan(y)]).any()
    assert np.isfinite(left).mean() > 0.8


@EVERY
def test_a_constant_response_is_predicted_as_such(kind: type[Surrogate]) -> None:
    y, variance = noisy()
    y[:, 1] = 5.0
    fitted = kind().fit(X, y, np.where(np.array([True, False]), variance, 1e-6), 1)
    mean, cov = fitted.predict(NEW)
    assert mean[1] == pytest.approx(np.full(len(NEW), 5.0), abs=1e-6)
    assert np.isfinite(cov).all()


@EVERY
def test_one_seed_gives_one_answer(kind: type[Surrogate]) -> None:
    y, variance = noisy()
    first, again = fit(kind), kind().fit(X, y, variance, 1)
    pairs = zip(
        (*first.predict(NEW), *first.left_out()), (*again.predict(NEW), *again.left_out()), strict=True
    )
    for a, b in pairs:
        np.testing.assert_array_equal(a, b)


@EVERY
@pytest.mark.parametrize("count", [0, 3])
def test_too_few_points_are_said(kind: type[Surrogate], count: int) -> None:
    y, variance = noisy()
    with pytest.raises(TooFewPoints, match=rf"\b{count}\b"):
        kind().fit(X[:count], y[:count], variance[:count], 1)
    y[count:, 1] = np.nan  # there are enough of the other response
    with pytest.raises(TooFewPoints, match=rf"\b{count}\b"):
        kind().fit(X, y, variance, 1)


@EVERY
def test_data_are_left_as_they_are(kind: type[Surrogate]) -> None:
    y, variance = noisy()
    copies = X.copy(), y.copy(), variance.copy()
    kind().fit(X, y, variance, 1).predict(NEW)
    for array, copy in zip((X, y, variance), copies, strict=True):
        np.testing.assert_array_equal(array, copy)


@EVERY
def test_a_surrogate_that_is_too_sure_is_widened_to_its_errors(kind: type[Surrogate]) -> None:
    """Responses scatter four times as much as is said of their noise."""
    y, variance = noisy()
    y = planes(X) + 4.0 * (y - planes(X))
    y[3, 0] = np.nan
    own = kind().fit(X, y, variance * 1e-6, 1)
    wide = calibrated(own, y, variance * 1e-6)
    mean, deviation = wide.left_out()
    squares = (y - mean) ** 2 / (deviation**2 + wide.factor * variance * 1e-6)
    assert (np.nanmean(squares, axis=0) < 1.001).all()
    np.testing.assert_array_equal(wide.predict(NEW)[0], own.predict(NEW)[0])
    for cov, own_cov, factor in zip(wide.predict(NEW)[1], own.predict(NEW)[1], wide.factor, strict=True):
        assert factor >= 1.0
        np.testing.assert_allclose(cov, factor * own_cov, rtol=1e-9)


@EVERY
def test_a_surrogate_that_errs_less_than_it_says_is_left_as_it_is(kind: type[Surrogate]) -> None:
    y, variance = noisy()
    assert calibrated(fit(kind), y, variance * 100.0).factor.tolist() == [1.0, 1.0]
