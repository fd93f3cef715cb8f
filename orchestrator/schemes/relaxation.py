"""Ways to the load that particles and panel agree on.

Each is told which load was tried and which was the answer, and says what to try next.  The residual
is r = answer - tried; zero is wanted.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from orchestrator.ports import Array, Saved
from orchestrator.state import put_back, taken

FIRST_SHARE = 0.5  # of the residual, before anything is known of how the answer depends on the try
MOST_COLUMNS = 40
NEW = 1e-3

Column = tuple[Array, Array]
"""A change of the residual, and of the answer, (numbers,) each."""


class Aitken:
    """A share w of the residual, found anew from the last two of them:

        tried <- tried + w r,    w <- -w r_before . (r - r_before) / |r - r_before|^2.

    Kuettler, U. and Wall, W. A., Computational Mechanics 43, 2008, 61-72,
    doi 10.1007/s00466-008-0255-5.  The last share of an interval is the next one's first.
    """

    def __init__(self) -> None:
        self._share = FIRST_SHARE
        self._residual_N: Array | None = None

    def begin(self) -> None:
        self._residual_N = None

    def next(self, tried_N: Array, answer_N: Array) -> Array:
        residual_N = answer_N - tried_N
        if self._residual_N is not None:
            change_N = residual_N - self._residual_N
            square = float(np.vdot(change_N, change_N))
            if square > 0:
                self._share *= -float(np.vdot(self._residual_N, change_N)) / square
        self._residual_N = residual_N
        return np.asarray(tried_N + self._share * residual_N)

    def save(self) -> Saved:
        """At a sync point."""
        return taken(self, "_share")

    def restore(self, saved: Saved) -> None:
        put_back(self, saved, "_share")


class LeastSquares:
    """Quasi-Newton by least squares: of all changes of the residual that were seen, the columns of
    V, the combination c that comes nearest to -r, and the same one of the changes of the answer, W:

        c = argmin |V c + r|,    tried <- answer + W c.

    IQN-ILS: Degroote, J., Bathe, K.-J. and Vierendeels, J., Computers & Structures 87, 2009,
    793-801, doi 10.1016/j.compstruc.2008.11.013.  Columns of earlier intervals are used again, the
    newest first.
    """

    def __init__(self) -> None:
        self._residuals: list[Array] = []  # of this interval
        self._answers: list[Array] = []
        self._columns: list[Column] = []  # of earlier ones

    def begin(self) -> None:
        self._columns = self._all()[:MOST_COLUMNS]
        self._residuals, self._answers = [], []

    def next(self, tried_N: Array, answer_N: Array) -> Array:
        residual_N = np.ravel(answer_N - tried_N)
        self._residuals.append(residual_N)
        self._answers.append(np.ravel(answer_N))
        columns = independent(self._all())
        if not columns:
            return np.asarray(tried_N + FIRST_SHARE * (answer_N - tried_N))
        V, W = (np.column_stack(part) for part in zip(*columns, strict=True))
        c = -np.linalg.lstsq(V, residual_N, rcond=None)[0]
        return np.asarray(answer_N + (W @ c).reshape(answer_N.shape))

    def save(self) -> Saved:
        """At a sync point."""
        columns = np.array(self._all()[:MOST_COLUMNS])  # (columns, 2, numbers)
        return {"columns": columns}

    def restore(self, saved: Saved) -> None:
        self._columns = [(V, W) for V, W in saved["columns"]]
        self._residuals, self._answers = [], []

    def _all(self) -> list[Column]:
        """The newest first."""
        changes = zip(_changes(self._residuals), _changes(self._answers), strict=True)
        return [*changes, *self._columns]


def independent(columns: list[Column]) -> list[Column]:
    """Those whose change of the residual is new, by ``NEW`` of its size, to the ones before it.

    QR filter: Haelterman, R., Bogaers, A. E. J., Scheufele, K., Uekermann, B. and Mehl, M.,
    Computers & Structures 171, 2016, 9-17, doi 10.1016/j.compstruc.2016.04.001.
    """
    kept: list[Column] = []
    basis: list[Array] = []
    for column in columns:
        new = column[0].copy()
        for direction in basis:
            new -= np.dot(direction, new) * direction
        size = float(np.linalg.norm(new))
        if size > NEW * float(np.linalg.norm(column[0])):
            basis.append(new / size)
            kept.append(column)
    return kept


def _changes(values: list[Array]) -> list[Array]:
    """From one to the next, the last first."""
    return [after - before for before, after in pairwise(values)][::-1]
