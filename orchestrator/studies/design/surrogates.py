"""Surrogates behind one port: what a design study needs of a model of its responses.

A surrogate is fitted to noisy responses at coded settings, and predicts them, with the covariance of
its errors, at others.  Each one is a class of its own file, chosen by its name in ``study.toml``.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from orchestrator.workbench.vocabulary import Array


class Fitted(Protocol):
    """A surrogate that has seen its data: n settings, of f factors, with m responses."""

    def predict(self, x: Array) -> tuple[Array, Array]:
        """Predict the responses at settings, (p, f), without the noise of a run.

        Return means, (m, p), and the covariances of their errors, (m, p, p).
        """
        ...

    def left_out(self) -> tuple[Array, Array]:
        """Predict each response of the data from the runs of all other settings (leave-one-out).

        Another run of its own setting would tell the answer.  Return means, (n, m), and standard deviations
        of the errors without the noise of the run, (n, m); not a number where a response is missing, or
        where the fit cannot do without the setting.
        """
        ...


@runtime_checkable
class Ensemble(Protocol):
    """A fitted surrogate of several members, each fitted to other parts of the data."""

    def explained_by_members(self) -> Array:
        """Compute the share of each response's variance, (members, m), that a member explains among the
        points that it has not seen."""
        ...


class Surrogate(Protocol):
    """A kind of model, before it has seen data."""

    def fit(self, x: Array, y: Array, variance: Array, seed: int) -> Fitted:
        """Fit to data.

        Parameters
        ----------
        x : coded settings, (n, f).
        y : responses, (n, m); not a number where a run gave none.
        variance : of the noise of each response, (n, m).
        seed : for whatever is drawn at random.

        Raises
        ------
        TooFewPoints : there is less data than the model has terms.
        """
        ...


class TooFewPoints(ValueError):
    """A model has more terms than there are points with a response."""


def settings_of(x: Array) -> npt.NDArray[np.intp]:
    """Number the settings of runs, (n, f): runs of one setting, but for rounding, have one number, (n,)."""
    return np.unique(x.round(9), axis=0, return_inverse=True)[1]


@dataclass(frozen=True)
class Calibrated:
    """A surrogate whose covariances are widened, for each response, by a factor."""

    fitted: Fitted
    factor: Array

    def predict(self, x: Array) -> tuple[Array, Array]:
        """Predict means, (m, p), and widened covariances, (m, p, p), of the responses at settings, (p, f)."""
        mean, covariance = self.fitted.predict(x)
        return mean, covariance * self.factor[:, None, None]

    def left_out(self) -> tuple[Array, Array]:
        """Predict each response, (n, m), from other settings, with widened deviations."""
        mean, deviation = self.fitted.left_out()
        return mean, deviation * np.sqrt(self.factor)


def calibrated(fitted: Fitted, y: Array, variance: Array) -> Calibrated:
    """Widen a surrogate's covariances to the errors that it makes of settings left out.

    Surrogates whose parameters were fitted to few points are surer of themselves than they may be, and what
    they recommend breaks a limit more often than it should.  ``y`` and ``variance``, (n, m), are those of the
    fit.
    """
    mean, deviation = fitted.left_out()
    known = np.isfinite(y) & np.isfinite(mean)
    squares = (y - mean) ** 2 / np.maximum(deviation**2 + variance, 1e-300)
    counts = np.maximum(known.sum(axis=0), 1)
    return Calibrated(fitted, np.maximum(np.where(known, squares, 0.0).sum(axis=0) / counts, 1.0))
