"""Acceleration of the iteration for the load on which particles and panel agree.

Each method learns which load was tried and which load was the answer, and returns the load to try next.  The
residual is r = answer - tried, and the iteration drives it to zero.
"""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from orchestrator.ports import Array
from orchestrator.ports.state import SavedAttributes

FIRST_SHARE = 0.5  # of the residual, as long as the effect of a try on the answer is unknown
SMALLEST = 1e-3  # least singular value of unit columns over the largest: smaller ones add nothing new


class Aitken(SavedAttributes):
    """Aitken's method, which adds a share w of the residual r.

    The share is computed anew from the last two residuals:

        tried <- tried + w r,    w <- -w r_before . (r - r_before) / |r - r_before|^2.

    Kuettler, U. and Wall, W. A., Computational Mechanics 43, 2008, 61-72, doi 10.1007/s00466-008-0255-5.  The
    last share of an interval is the first share of the next.
    """

    STATE: ClassVar = ("_share",)

    def __init__(self) -> None:
        self._share = FIRST_SHARE
        self._residual_N: Array | None = None

    def begin(self) -> None:
        self._residual_N = None
        self._share = first_share(self._share)

    def next(self, tried_N: Array, answer_N: Array) -> Array:
        residual_N = answer_N - tried_N
        if self._residual_N is not None:
            self._share = secant_share(self._share * self._residual_N, residual_N - self._residual_N)
        self._residual_N = residual_N
        return np.asarray(tried_N + self._share * residual_N)


class LeastSquares(SavedAttributes):
    """A quasi-Newton method by least squares.

    The columns of V are all changes of the residual in this interval, and the columns of W are the changes of
    the answer.  The combination c of the columns of V comes nearest to -r:

        c = argmin |V c + r|,    tried <- answer + W c.

    IQN-ILS: Degroote, J., Bathe, K.-J. and Vierendeels, J., Computers & Structures 87, 2009, 793-801, doi
    10.1016/j.compstruc.2008.11.013.  Columns of earlier intervals, which that paper uses again, made it
    slower here: contacts come and go (docs/measured/coupling.md).  The share of the residual that would have
    suited the first change best is kept for the next interval.
    """

    STATE: ClassVar = ("_share",)

    def __init__(self) -> None:
        self._share = FIRST_SHARE
        self.begin()

    def begin(self) -> None:
        self._share = first_share(self._share)
        self._residuals: list[Array] = []
        self._answers: list[Array] = []

    def next(self, tried_N: Array, answer_N: Array) -> Array:
        residual_N = answer_N - tried_N
        self._residuals.append(residual_N.ravel())
        self._answers.append(answer_N.ravel())
        if len(self._answers) == 1:
            return np.asarray(tried_N + self._share * residual_N)
        V = np.diff(self._residuals, axis=0).T
        W = np.diff(self._answers, axis=0).T
        if len(self._answers) == 2:
            self._share = secant_share(W[:, 0] - V[:, 0], V[:, 0])
        size_N = np.linalg.norm(V, axis=0)  # scales all columns to the same size, so that small ones count
        size_N[size_N == 0] = 1.0  # a repeated residual says nothing
        c = np.linalg.lstsq(V / size_N, -residual_N.ravel(), rcond=SMALLEST)[0] / size_N
        return np.asarray(answer_N + (W @ c).reshape(answer_N.shape))


def secant_share(tried_N: Array, residual_N: Array) -> float:
    """Return the share w for which  |tried + w residual|  would have been least."""
    square = float(np.vdot(residual_N, residual_N))
    return -float(np.vdot(tried_N, residual_N)) / square if square > 0 else FIRST_SHARE


def first_share(share: float) -> float:
    """Return the first share of an interval; the last interval ended with ``share``."""
    return share if 0 < share <= 1 else FIRST_SHARE
