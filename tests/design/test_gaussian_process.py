"""The Gaussian process against the textbook's formulas, written out here.

Source: C. E. Rasmussen, C. K. I. Williams, Gaussian Processes for Machine Learning, MIT Press 2006,
Eqs. 2.23, 2.24, 2.30 and 4.17.
"""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator.ports import Array
from orchestrator.studies.design.gaussian_process import LENGTHS, TREND, GaussianProcess
from orchestrator.studies.design.space import Space
from orchestrator.studies.design.surrogates import TooFewPoints
from tests.design.table5 import RESPONSES, surface, table_5

SIX = np.array([[-1.0, -0.6], [-0.4, 0.9], [0.1, -0.2], [0.5, 0.7], [0.8, -0.9], [1.0, 0.2]])
VALUES = np.array([3.1, 2.2, 4.0, 5.3, 1.9, 4.4])
NOISE = np.array([0.01, 0.04, 0.02, 0.01, 0.09, 0.03])
NEW = np.array([[0.0, 0.0], [-0.8, 0.8], [0.5, 0.7]])


def covariance(a: Array, b: Array, height: float, lengths: Array) -> Array:
    """Compute the prior covariance of settings, (n, f) and (p, f): Matern 5/2 with a plane."""
    distance = np.sqrt(5.0 * (((a[:, None] - b[None]) / lengths) ** 2).sum(axis=2))
    matern = height * (1.0 + distance + distance**2 / 3.0) * np.exp(-distance)
    return np.asarray(matern + TREND * (1.0 + a @ b.T))


def fitted_height_and_lengths(y: Array = VALUES, noise: Array = NOISE) -> tuple[float, Array]:
    """Return the hyperparameters that were fitted to six points, for responses of variance 1."""
    kernel = GaussianProcess().fit(SIX, y[:, None], noise[:, None], 1).processes[0].process.kernel_
    return kernel.k1.k1.constant_value, np.array(kernel.k1.k2.length_scale)


def wavy(x: Array) -> Array:
    """Compute a response, (n,), that no plane follows."""
    return np.asarray(2.0 + x[:, 0] - 0.5 * x[:, 1] + np.sin(3.0 * x[:, 0]) * np.cos(2.0 * x[:, 1]))


def test_predictions_are_those_of_the_textbook() -> None:
    fitted = GaussianProcess().fit(SIX, VALUES[:, None], NOISE[:, None], 1)
    mean, cov = fitted.predict(NEW)
    centre, scale = VALUES.mean(), VALUES.std()
    height, lengths = fitted_height_and_lengths()
    inverse = np.linalg.inv(covariance(SIX, SIX, height, lengths) + np.diag(NOISE) / scale**2)
    across = covariance(NEW, SIX, height, lengths)
    expected = centre + across @ inverse @ (VALUES - centre)
    np.testing.assert_allclose(mean[0], expected, rtol=1e-9)
    left = covariance(NEW, NEW, height, lengths) - across @ inverse @ across.T
    np.testing.assert_allclose(cov[0], scale**2 * left, atol=1e-9)


def test_lengths_and_height_make_the_data_most_likely() -> None:
    y, noise = wavy(SIX), np.full(6, 1e-4)
    scale = y.std()
    height, lengths = fitted_height_and_lengths(y, noise)

    def likelihood(height: float, lengths: Array) -> float:
        matrix = covariance(SIX, SIX, height, lengths) + np.diag(noise) / scale**2
        residual = (y - y.mean()) / scale
        return float(-0.5 * residual @ np.linalg.solve(matrix, residual) - 0.5 * np.linalg.slogdet(matrix)[1])

    best = likelihood(height, lengths)
    for factor in (0.9, 1.1):
        assert likelihood(factor * height, lengths) < best + 1e-6
        for i in range(2):
            other = lengths.copy()
            other[i] = np.clip(factor * lengths[i], *LENGTHS)
            assert likelihood(height, other) < best + 1e-6


def test_data_without_noise_are_met() -> None:
    x = Space(-np.ones(2), np.ones(2)).sample(15, 1)
    fitted = GaussianProcess().fit(x, wavy(x)[:, None], np.zeros((15, 1)), 1)
    mean, cov = fitted.predict(x)
    np.testing.assert_allclose(mean[0], wavy(x), atol=1e-5)
    assert np.sqrt(np.diagonal(cov[0]).max()) < 1e-3


def test_noisy_data_are_smoothed_and_repeated_runs_count_as_their_mean() -> None:
    """Two runs of a setting with the noise of one each are one run of half the variance."""
    twice = np.vstack([SIX, SIX[:1]])
    both = np.append(VALUES, 3.5)
    fitted = GaussianProcess().fit(twice, both[:, None], np.full((7, 1), 0.04), 1)
    merged = np.array([3.3, *VALUES[1:]])
    variance = np.array([0.02, *[0.04] * 5])
    process = fitted.processes[0]
    scale = both.std()
    kernel = process.process.kernel_
    height, lengths = kernel.k1.k1.constant_value, np.array(kernel.k1.k2.length_scale)
    inverse = np.linalg.inv(covariance(SIX, SIX, height, lengths) + np.diag(variance) / scale**2)
    expected = both.mean() + covariance(NEW, SIX, height, lengths) @ inverse @ (merged - both.mean())
    np.testing.assert_allclose(fitted.predict(NEW)[0][0], expected, rtol=1e-8)
    at_first = fitted.predict(SIX[:1])[0][0, 0]
    assert 3.1 < at_first < 3.5


@pytest.mark.parametrize(("offset", "factor"), [(0.0, 1000.0), (-273.15, 1.0), (5.0, -0.001)])
def test_other_units_of_a_response_give_the_same_answer(offset: float, factor: float) -> None:
    fitted = GaussianProcess().fit(SIX, VALUES[:, None], NOISE[:, None], 1)
    other = GaussianProcess().fit(SIX, offset + factor * VALUES[:, None], factor**2 * NOISE[:, None], 1)
    (mean, cov), (other_mean, other_cov) = fitted.predict(NEW), other.predict(NEW)
    np.testing.assert_allclose(other_mean, offset + factor * mean, rtol=1e-5)
    np.testing.assert_allclose(other_cov, factor**2 * cov, rtol=1e-3, atol=1e-9 * factor**2)
    left, other_left = fitted.left_out(), other.left_out()
    np.testing.assert_allclose(other_left[0], offset + factor * left[0], rtol=1e-4)
    np.testing.assert_allclose(other_left[1], abs(factor) * left[1], rtol=1e-3)


def test_leaving_a_point_out_is_fitting_anew_without_it() -> None:
    x = Space(-np.ones(2), np.ones(2)).sample(12, 2)
    y, variance = wavy(x)[:, None], np.full((12, 1), 0.01)
    mean, deviation = GaussianProcess().fit(x, y, variance, 1).left_out()
    for i in range(12):
        others = np.arange(12) != i
        expected, cov = GaussianProcess().fit(x[others], y[others], variance[others], 1).predict(x[[i]])
        assert mean[i, 0] == pytest.approx(expected[0, 0], abs=0.02)
        assert deviation[i, 0] == pytest.approx(np.sqrt(cov[0, 0, 0]), rel=0.05)


def test_a_response_that_a_run_does_not_have_is_left_out_of_its_fit_alone() -> None:
    x = Space(-np.ones(2), np.ones(2)).sample(14, 3)
    y = np.column_stack([wavy(x), x[:, 0] - x[:, 1]])
    holes = y.copy()
    holes[[2, 7, 11], 0] = np.nan
    variance = np.full_like(y, 1e-3)
    mean, cov = GaussianProcess().fit(x, holes, variance, 1).predict(NEW)
    known = np.isfinite(holes[:, 0])
    first = GaussianProcess().fit(x[known], y[known, :1], variance[known, :1], 1)
    np.testing.assert_allclose(mean[0], first.predict(NEW)[0][0], rtol=1e-9)
    np.testing.assert_allclose(cov[0], first.predict(NEW)[1][0], rtol=1e-9)
    second = GaussianProcess().fit(x, y[:, 1:], variance[:, 1:], 1)
    np.testing.assert_allclose(mean[1], second.predict(NEW)[0][0], rtol=1e-9)
    left, _ = GaussianProcess().fit(x, holes, variance, 1).left_out()
    np.testing.assert_array_equal(np.isfinite(left), np.isfinite(holes))


def test_points_far_from_all_data_are_less_sure() -> None:
    x = np.column_stack([np.linspace(-1, 0, 10), np.zeros(10)])
    fitted = GaussianProcess().fit(x, np.sin(6 * x[:, :1]), np.full((10, 1), 1e-4), 1)
    _, cov = fitted.predict(np.array([[-0.5, 0.0], [0.3, 0.0], [1.0, 0.0]]))
    deviations = np.sqrt(np.diagonal(cov[0]))
    assert deviations[0] < deviations[1] < deviations[2]


@pytest.mark.parametrize("response", RESPONSES)
def test_table_5_is_predicted_about_as_well_as_by_its_quadratic(response: str) -> None:
    x, y = table_5()
    y = y[:, [RESPONSES.index(response)]]
    mean, _ = GaussianProcess().fit(x, y, np.full_like(y, 1e-3 * y.var()), 1).left_out()
    explained = 1.0 - ((y - mean) ** 2).sum() / ((y - y.mean()) ** 2).sum()
    assert surface(response).quality()["r2_predicted"] - 0.03 < explained < 0.98


def test_a_plane_and_its_process_need_points() -> None:
    with pytest.raises(TooFewPoints, match=r"\b3\b.*\b3\b"):
        GaussianProcess().fit(SIX[:3], VALUES[:3, None], NOISE[:3, None], 1)
