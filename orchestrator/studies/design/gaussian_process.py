"""Gaussian process with a linear trend, a Matern 5/2 covariance and the known noise of each point.

Source: C. E. Rasmussen, C. K. I. Williams, Gaussian Processes for Machine Learning, MIT Press 2006,
sections 2.2, 2.7 (trend), 4.2 (Matern); scikit-learn does the algebra.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt
from sklearn.exceptions import ConvergenceWarning
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import ConstantKernel, DotProduct, Kernel, Matern

from orchestrator.ports import Array
from orchestrator.studies.design.surrogates import TooFewPoints, settings_of

LENGTHS = (0.4, 20.0)  # of the coded range of 2: shorter ones cannot be told from noise by so few points
TREND = 100.0  # prior variance of the plane, in variances of the data: vague
STARTS = 2  # restarts of the likelihood's maximisation beside the first


class GaussianProcess:
    """Each response by a process of its own."""

    def fit(self, x: Array, y: Array, variance: Array, seed: int) -> FittedProcess:
        """Fit by maximum likelihood of the lengths and the variance.

        Raises TooFewPoints where a response is known at fewer settings than its plane has terms.
        """
        processes = [_fit_one(x, y[:, i], variance[:, i], seed) for i in range(y.shape[1])]
        return FittedProcess(processes, len(x))


def _fit_one(x: Array, y: Array, variance: Array, seed: int) -> _Process:
    known = np.isfinite(y)
    if (count := len(np.unique(settings_of(x[known])))) < x.shape[1] + 2:
        raise TooFewPoints(f"{count} points for a plane of {x.shape[1] + 1} terms and its process")
    mean, scale = float(y[known].mean()), float(y[known].std()) or 1.0
    kernel = ConstantKernel(0.3, (1e-4, 1e2)) * Matern([2.0] * x.shape[1], LENGTHS, nu=2.5)
    trend = ConstantKernel(TREND, "fixed") * DotProduct(1.0, "fixed")
    noise = np.maximum(variance[known] / scale**2, 1e-8)
    process = _maximise_likelihood(kernel + trend, x[known], (y[known] - mean) / scale, noise, STARTS, seed)
    return _Process(process, noise, known, mean, scale)


def _maximise_likelihood(
    kernel: Kernel, x: Array, y: Array, noise: Array, restarts: int, seed: int
) -> GaussianProcessRegressor:
    """Fit a process whose lengths and variance make the data most likely, starting from those of
    ``kernel``."""
    process = GaussianProcessRegressor(kernel, alpha=noise, n_restarts_optimizer=restarts, random_state=seed)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)  # lengths may end at their bounds
        return process.fit(x, y)


@dataclass(frozen=True)
class _Process:
    """One response; ``mean`` and ``scale`` bring it to the order of one."""

    process: GaussianProcessRegressor
    noise: Array
    known: npt.NDArray[np.bool_]
    mean: float
    scale: float

    def predict(self, x: Array) -> tuple[Array, Array]:
        mean, covariance = self.process.predict(x, return_cov=True)
        return self.mean + self.scale * mean, self.scale**2 * covariance

    @cached_property
    def left_out(self) -> tuple[Array, Array]:
        """Predictions of each point by a process fitted anew to all other settings: with lengths kept from
        all data they would look better than they are."""
        x, y = self.process.X_train_, self.process.y_train_
        mean, deviation = np.empty((2, len(y)))
        settings = settings_of(x)
        for number in np.unique(settings):
            mine, others = settings == number, settings != number
            process = _maximise_likelihood(
                self.process.kernel_, x[others], y[others], self.noise[others], 0, 0
            )
            mean[mine], deviation[mine] = process.predict(x[mine], return_std=True)
        return self.mean + self.scale * mean, self.scale * deviation


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
        """Predict each response, (n, m), from other settings, with the lengths fitted to these."""
        mean, deviation = np.full((2, self.points, len(self.processes)), np.nan)
        for i, process in enumerate(self.processes):
            mean[process.known, i], deviation[process.known, i] = process.left_out
        return mean, deviation
