"""Gaussian process with a linear trend, a Matern 5/2 covariance and the known noise of each point.

Source: C. E. Rasmussen, C. K. I. Williams, Gaussian Processes for Machine Learning, MIT Press 2006,
sections 2.2, 2.7 (trend), 4.2 (Matern), 5.4.2 (leave-one-out); scikit-learn does the algebra.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.linalg import cho_solve
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import ConstantKernel, DotProduct, Matern

from orchestrator.studies.design.surrogates import TooFewPoints

Array = npt.NDArray[np.float64]
LENGTHS = (0.4, 20.0)  # of the coded range of 2: shorter ones cannot be told from noise by so few points
TREND = 100.0  # prior variance of the plane, in variances of the data: vague
STARTS = 2  # restarts of the likelihood's maximisation beside the first


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
    if known.sum() < x.shape[1] + 2:
        raise TooFewPoints(f"{known.sum()} points for a plane of {x.shape[1] + 1} terms and its process")
    mean, scale = float(y[known].mean()), float(y[known].std()) or 1.0
    kernel = ConstantKernel(0.3, (1e-4, 1e2)) * Matern([2.0] * x.shape[1], LENGTHS, nu=2.5)
    trend = ConstantKernel(TREND, "fixed") * DotProduct(1.0, "fixed")
    noise = np.maximum(variance[known] / scale**2, 1e-8)
    process = GaussianProcessRegressor(
        kernel + trend, alpha=noise, n_restarts_optimizer=STARTS, random_state=seed
    )
    process.fit(x[known], (y[known] - mean) / scale)
    return _Process(process, noise, known, mean, scale)


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

    def left_out(self) -> tuple[Array, Array]:
        inverse = cho_solve((self.process.L_, True), np.eye(len(self.noise)))
        variance = 1.0 / np.diag(inverse)
        mean = self.process.y_train_ - inverse @ self.process.y_train_ * variance
        latent = np.maximum(variance - self.noise, 0.0)
        return self.mean + self.scale * mean, self.scale * np.sqrt(latent)


@dataclass(frozen=True)
class FittedProcess:
    """The processes of all responses."""

    processes: list[_Process]
    points: int

    def predict(self, x: Array) -> tuple[Array, Array]:
        """Predict means, (m, p), and covariances, (m, p, p), of the responses at settings, (p, f)."""
        predicted = [one.predict(x) for one in self.processes]
        return np.array([mean for mean, _ in predicted]), np.array([cov for _, cov in predicted])

    def left_out(self) -> tuple[Array, Array]:
        """Predict each response, (n, m), from the others, with the lengths kept as they are."""
        mean, deviation = np.full((2, self.points, len(self.processes)), np.nan)
        for i, one in enumerate(self.processes):
            mean[one.known, i], deviation[one.known, i] = one.left_out()
        return mean, deviation
