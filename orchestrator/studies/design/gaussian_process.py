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
from sklearn.gaussian_process.kernels import ConstantKernel, DotProduct, Kernel, Matern, WhiteKernel

from orchestrator.studies.design.surrogates import TooFewPoints, settings_of
from orchestrator.workbench.vocabulary import Array

LENGTHS = (0.4, 20.0)  # of the coded range of 2: shorter ones cannot be told from noise by so few points
TREND = 100.0  # prior variance of the plane, in variances of the data: vague
LEAST_NOISE = 1e-3  # of the data's variance, where nothing but the data tells of the noise
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
        raise TooFewPoints(f"{count} settings for a plane of {x.shape[1] + 1} terms and its process")
    mean, scale = float(y[known].mean()), float(y[known].std()) or 1.0
    noise = np.maximum(variance[known] / scale**2, 1e-8)
    kernel = _plane_and_process(x.shape[1])
    process = _maximise_likelihood(kernel, x[known], (y[known] - mean) / scale, noise, STARTS, seed)
    return _Process(process, noise, known, mean, scale)


def _plane_and_process(factors: int) -> Kernel:
    """Return the covariance of a response of variance one."""
    process = ConstantKernel(0.3, (1e-4, 1e2)) * Matern([2.0] * factors, LENGTHS, nu=2.5)
    return process + ConstantKernel(TREND, "fixed") * DotProduct(1.0, "fixed")


def likely_noise(x: Array, y: Array) -> float:
    """Return the variance of the noise that makes a response, (n,), at settings, (n, f), most likely, where
    nothing else tells of it: at least a thousandth of the data's variance."""
    scale = float(y.std()) if len(y) else 0.0
    if len(y) < x.shape[1] + 2 or scale == 0.0:
        return LEAST_NOISE * scale**2
    kernel = _plane_and_process(x.shape[1]) + WhiteKernel(0.1, (LEAST_NOISE, 1.0))
    process = _maximise_likelihood(kernel, x, (y - y.mean()) / scale, 1e-8, 0, 0)
    return float(process.kernel_.k2.noise_level) * scale**2


def _maximise_likelihood(
    kernel: Kernel, x: Array, y: Array, noise: Array | float, restarts: int, seed: int
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
