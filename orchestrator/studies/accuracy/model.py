"""Settings taken together, predicted from settings taken one at a time.

Errors add up, quantity by quantity; the processor time of each part of the program (particles,
panel, frames ...) is multiplied by what each setting does to it.  The study then runs what this
proposes, so that a prediction stands beside what was measured.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from typing import Literal

import numpy as np

from orchestrator.ports import Array
from orchestrator.studies.accuracy.refinement import Setting


@dataclass(frozen=True)
class Option:
    """A setting that was measured: error by quantity against the best of its axis, and what it
    does to the processor time of each part (ratio to the case as it is)."""

    axis: str
    setting: Setting
    error: dict[str, float]
    ratio: dict[str, float]


@dataclass(frozen=True)
class Proposal:
    """One option of each axis."""

    options: tuple[Option, ...]
    error: float
    processor_s: float

    @property
    def settings(self) -> dict[str, Setting]:
        """Those that differ from the case as it is."""
        return {one.axis: one.setting for one in self.options if one.setting.sets}


class Model:
    """``axes``: options by axis; ``parts_s``: processor time of the case as it is, by part;
    ``remaining``: error by quantity that even the best options have."""

    def __init__(
        self,
        axes: Mapping[str, list[Option]],
        parts_s: Mapping[str, float],
        remaining: Mapping[str, float],
        judged_by: Sequence[str],
    ) -> None:
        self._axes = list(axes.values())
        errors = [[_row(one.error, judged_by) for one in axis] for axis in self._axes]
        ratios = [[_row(one.ratio, parts_s, 1.0) for one in axis] for axis in self._axes]
        lengths = [[np.log([one.setting.h or 1.0]) for one in axis] for axis in self._axes]
        error = _combined(np.add, errors, len(judged_by)) + _row(remaining, judged_by)
        self._worst = error.max(axis=-1, initial=0.0)
        self._length = _combined(np.add, lengths, 1)[..., 0]
        self._cost_s = _combined(np.multiply, ratios, len(parts_s)) @ _row(parts_s, parts_s)

    def cheapest(self, tolerance: float) -> Proposal | None:
        """Returns the cheapest with an error of at most ``tolerance``; None where there is none."""
        if not (self._worst <= tolerance).any():
            return None
        return self._proposal(int(np.where(self._worst <= tolerance, self._cost_s, np.inf).argmin()))

    def best(self, budget_s: float, ties: Literal["cheapest", "finest"]) -> Proposal | None:
        """Returns that of the least error for at most so much processor time; None where none is so
        cheap.  Times are measured, so that what is finest must not go by them."""
        within = np.flatnonzero(self._cost_s <= budget_s)
        if not len(within):
            return None
        preferred = (self._cost_s if ties == "cheapest" else self._length).flat[within]
        return self._proposal(int(within[np.lexsort((preferred, self._worst.flat[within]))[0]]))

    def _proposal(self, flat: int) -> Proposal:
        at = np.unravel_index(flat, self._cost_s.shape)
        chosen = tuple(axis[number] for axis, number in zip(self._axes, at, strict=True))
        return Proposal(chosen, float(self._worst[at]), float(self._cost_s[at]))


def _row(
    values: Mapping[str, float], names: Sequence[str] | Mapping[str, float], otherwise: float = 0.0
) -> Array:
    return np.array([values.get(name, otherwise) for name in names])


def _combined(how: np.ufunc, axes: list[list[Array]], width: int) -> Array:
    """Returns (n_1, n_2, ..., width) of every choice of one row from each axis."""
    start = np.full(width, how.identity, dtype=float)
    return reduce(lambda before, rows: how(before[..., None, :], np.array(rows)), axes, start)
