"""Gaussian process with a linear trend, a Matern 5/2 covariance and the known noise of each point.

Source: C. E. Rasmussen, C. K. I. Williams, Gaussian Processes for Machine Learning, MIT Press 2006,
sections 2.2, 2.7 (trend), 4.2 (Matern) and 5.4 (likelihood).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt
from scipy.linalg import LinAlgError, cho_solve, cholesky, solve_triangular
from scipy.optimize import minimize
from scipy.spatial.distance import cdist

from orchestrator.ports import Array
from orchestrator.studies.design.surrogates import TooFewPoints

HEIGHT, LENGTH = 0.3, 2.0  # where the maximisation of the likelihood begins
HEIGHTS = (1e-4, 1e2)  # of the process, in variances of the data
LENGTHS = (0.4, 20.0)  # of the coded range of 2: shorter ones cannot be told from noise by so few points
TREND = 100.0  # prior variance of the plane, in variances of the data: vague
STARTS = 2  # of the likelihood's maximisation, at random, beside the first


class GaussianProcess:
    """Each response by a process of its own."""

    def fit(self, x: Array, y: Array, variance: Array, seed: int) -> FittedProcess:
        """Fit by maximum likelihood of the lengths and the variance.

        Raises
        ------
        TooFewPoints : a response is known at fewer points than its plane has terms.
        """
        processes = [_fit_one(x, y[:, i], variance[:, i], seed) for i in range(y.shape[1])]
        return FittedProcess(processes, len(x))


def _fit_one(x: Array, y: Array, variance: Array, seed: int) -> _Process:
    known = np.isfinite(y)
    factors = x.shape[1]
    if known.sum() < factors + 2:
        raise TooFewPoints(f"{known.sum()} points for a plane of {factors + 1} terms and its process")
    mean, scale = float(y[known].mean()), float(y[known].std()) or 1.0
    noise = np.maximum(variance[known] / scale**2, 1e-8)
    bounds = np.log([HEIGHTS] + [LENGTHS] * factors)
    shape = STARTS, 1 + factors
    draws = np.random.RandomState(seed).uniform(bounds[:, 0], bounds[:, 1], shape)
    starts = np.vstack([np.log([HEIGHT] + [LENGTH] * factors), draws])
    process = _most_likely(x[known], (y[known] - mean) / scale, noise, starts)
    return _Process(process, known, mean, scale)


@dataclass(frozen=True)
class _Process:
    """One response; ``mean`` and ``scale`` bring it to the order of one."""

    process: Posterior
    known: npt.NDArray[np.bool_]
    mean: float
    scale: float

    def predict(self, x: Array) -> tuple[Array, Array]:
        mean, covariance = self.process.predict(x)
        return self.mean + self.scale * mean, self.scale**2 * covariance

    @cached_property
    def left_out(self) -> tuple[Array, Array]:
        """Predictions of each point by a process fitted anew to all others: with lengths kept from all data
        they would look better than they are."""
        fitted = self.process
        x, y, noise, start = fitted.x, fitted.y, fitted.noise, fitted.logarithms[None]
        mean, variance = np.empty((2, len(y)))
        for i in range(len(y)):
            others = np.arange(len(y)) != i
            mean[[i]], variance[[i]] = _most_likely(x[others], y[others], noise[others], start).predict(
                x[[i]]
            )
        return self.mean + self.scale * mean, self.scale * np.sqrt(np.maximum(variance, 0.0))


class Posterior:
    """A process of given height and lengths that has seen its data: responses ``y`` at settings ``x``."""

    def __init__(self, x: Array, y: Array, noise: Array, logarithms: Array) -> None:
        self.x, self.y, self.noise, self.logarithms = x, y, noise, logarithms
        self.height, self.lengths = float(np.exp(logarithms[0])), np.exp(logarithms[1:])
        self._factor = cholesky(self._covariance(x, x) + np.diag(noise), lower=True)
        self._weights = cho_solve((self._factor, True), y)

    def predict(self, x: Array) -> tuple[Array, Array]:
        """Predict means, (p,), and covariances, (p, p), at settings, (p, f)."""
        across = self._covariance(x, self.x)
        seen = solve_triangular(self._factor, across.T, lower=True)
        return across @ self._weights, self._covariance(x, x) - seen.T @ seen

    def _covariance(self, one: Array, other: Array) -> Array:
        distance = np.sqrt(5.0) * cdist(one / self.lengths, other / self.lengths)
        matern = self.height * (1.0 + distance + distance**2 / 3.0) * np.exp(-distance)
        return np.asarray(matern + TREND * (1.0 + one @ other.T))


def _most_likely(x: Array, y: Array, noise: Array, starts: Array) -> Posterior:
    """Fit a process whose height and lengths make the data most likely, the best of several ``starts``,
    (s, 1 + f): logarithms of the height and of the lengths."""
    bounds = np.log([HEIGHTS] + [LENGTHS] * x.shape[1])
    squares = ((x.T[:, :, None] - x.T[:, None, :]) ** 2).reshape(x.shape[1], -1)
    fixed, ones = TREND * (1.0 + x @ x.T) + np.diag(noise), np.eye(len(x))

    def unlikeliness(logarithms: Array) -> tuple[float, Array]:
        """Compute minus the logarithm of the likelihood but for a constant, and its gradient."""
        inverse_squares = np.exp(-2.0 * logarithms[1:])
        square = 5.0 * (inverse_squares @ squares).reshape(fixed.shape)
        distance = np.sqrt(square)
        falling = np.exp(logarithms[0] - distance)
        matern = (1.0 + distance + square / 3.0) * falling
        try:
            factor = cholesky(matern + fixed, lower=True, check_finite=False)
        except LinAlgError:
            return np.inf, np.zeros_like(logarithms)
        inverse = cho_solve((factor, True), ones, check_finite=False)
        weights = cho_solve((factor, True), y, check_finite=False)
        slope = 0.5 * (inverse - np.outer(weights, weights))
        along_lengths = 5.0 / 3.0 * inverse_squares * (squares @ (slope * (1.0 + distance) * falling).ravel())
        value = 0.5 * y @ weights + np.log(np.diag(factor)).sum()
        return float(value), np.array([(slope * matern).sum(), *along_lengths])

    ends = [minimize(unlikeliness, start, jac=True, method="L-BFGS-B", bounds=bounds) for start in starts]
    return Posterior(x, y, noise, min(ends, key=lambda end: end.fun).x)


@dataclass(frozen=True)
class FittedProcess:
    """The fitted processes of all responses."""

    processes: list[_Process]
    points: int

    def predict(self, x: Array) -> tuple[Array, Array]:
        """Predict means, (m, p), and covariances, (m, p, p), of the responses at settings, (p, f)."""
        predicted = [process.predict(x) for process in self.processes]
        return np.array([mean for mean, _ in predicted]), np.array([cov for _, cov in predicted])

    def left_out(self) -> tuple[Array, Array]:
        """Predict each response, (n, m), from the others, with the lengths fitted to these."""
        mean, deviation = np.full((2, self.points, len(self.processes)), np.nan)
        for i, process in enumerate(self.processes):
            mean[process.known, i], deviation[process.known, i] = process.left_out
        return mean, deviation
