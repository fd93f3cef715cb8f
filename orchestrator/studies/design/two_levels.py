"""A dear level that is predicted from a cheap one: many cheap runs give the shape, few dear ones correct it.

The dear response is y(x) = rho y_cheap(x) + d(x) with a factor rho and a Gaussian process d.  Source: M. C.
Kennedy, A. O'Hagan, Biometrika 87 (2000) 1, doi:10.1093/biomet/87.1.1; fitted one level after the other as by
L. Le Gratiet, J. Garnier, Int. J. Uncertain. Quantif. 4 (2014) 365,
doi:10.1615/Int.J.UncertaintyQuantification.2014006914.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchestrator.studies.design.surrogates import Fitted, Surrogate
from orchestrator.workbench.vocabulary import Array

NO_NOISE = 1e-8  # of the variance of the data: a case without random numbers has none


@dataclass(frozen=True)
class TwoLevels:
    """A surrogate of the dear level on top of a fitted one of the cheap level; ``correction`` fits d."""

    cheap: Fitted
    correction: Surrogate

    def fit(self, x: Array, y: Array, variance: Array, seed: int) -> FittedLevels:
        """Fit the factor of each response by weighted least squares, and the correction to the rest.

        A cheap level that does not make predictions of left-out runs better is left out: its factor is 0.
        Raises TooFewPoints where the correction has more terms than there are points.
        """
        mean = self.cheap.predict(x)[0].T
        factor = np.array([_factor(mean[:, i], y[:, i], variance[:, i]) for i in range(y.shape[1])])
        errors = [self._errors(x, y - rho * mean, variance, seed) for rho in (np.zeros_like(factor), factor)]
        factor = np.where(errors[1] < errors[0], factor, 0.0)
        correction = self.correction.fit(x, y - factor * mean, variance, seed)
        return FittedLevels(self.cheap, correction, factor, x)

    def _errors(self, x: Array, rest: Array, variance: Array, seed: int) -> Array:
        """Compute the mean square error, (m,), of predicting each run from the others."""
        left_out, _ = self.correction.fit(x, rest, variance, seed).left_out()
        return np.asarray(np.nanmean((rest - left_out) ** 2, axis=0))


def _factor(mean: Array, y: Array, variance: Array) -> float:
    """Return the slope of a straight line of y over the cheap level's mean, both (n,)."""
    known = np.isfinite(y)
    if known.sum() < 2 or np.ptp(mean[known]) == 0.0:
        return 0.0
    noise = np.maximum(variance[known], NO_NOISE * np.var(y[known]) or 1.0)
    slope, _ = np.polyfit(mean[known], y[known], 1, w=1.0 / np.sqrt(noise))
    return float(slope)


@dataclass(frozen=True)
class FittedLevels:
    """The fitted levels; ``factor`` (m,) is rho of each response, ``x`` (n, f) are the settings of the
    data."""

    cheap: Fitted
    correction: Fitted
    factor: Array
    x: Array

    def predict(self, x: Array) -> tuple[Array, Array]:
        """Predict means, (m, p), and covariances, (m, p, p), of the dear responses at settings, (p, f)."""
        (mean, covariance), (low_mean, low_covariance) = self.correction.predict(x), self.cheap.predict(x)
        return (
            mean + self.factor[:, None] * low_mean,
            covariance + self.factor[:, None, None] ** 2 * low_covariance,
        )

    def left_out(self) -> tuple[Array, Array]:
        """Predict each dear response, (n, m), from the other dear runs, all cheap ones, and the factor of all
        runs."""
        mean, deviation = self.correction.left_out()
        cheap_mean, covariance = self.cheap.predict(self.x)
        cheap_variance = np.diagonal(covariance, axis1=1, axis2=2).T
        return mean + self.factor * cheap_mean.T, np.sqrt(deviation**2 + self.factor**2 * cheap_variance)
