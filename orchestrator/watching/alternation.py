"""Modes of the interface that grow from interval to interval.

A coupling that is unstable on a light point leaves the unit circle at -1
(docs/theory/stability.md): the point's velocity changes its sign with every interval, and grows.
The second difference of three velocities is four times as large as what alternates, and small,
(w H)^2 of it, of what moves smoothly.  A point whose second differences turn round again and again,
each time larger than before, is taken for such a mode: what rings decays between two blows.
"""

from __future__ import annotations

import numpy as np

from orchestrator.ports import Array, Indices, Saved
from orchestrator.state import put_back, taken
from orchestrator.watching.created_energy import SLOW_M_S

TURNS = 10  # as often in succession
ROUND = 0.8  # of the way at least, as a cosine
GROWTH = 2.0  # as large after so many turns

_STATE = ("_before_m_s", "_twice_before_m_s", "_change_m_s", "_square", "_first", "_turns")
_ALL = (*_STATE, "_fastest_m_s", "alternating_m_s")


class Alternation:
    """Of the surface's points, (points, 3) velocities at successive sync points."""

    def __init__(self, velocity_m_s: Array) -> None:
        self._fastest_m_s = 0.0
        self.alternating_m_s = 0.0
        self._begin(velocity_m_s)

    def _begin(self, velocity_m_s: Array) -> None:
        self._before_m_s = self._twice_before_m_s = velocity_m_s
        self._change_m_s = np.zeros_like(velocity_m_s)
        self._square: Array = np.zeros(len(velocity_m_s))
        self._first: Array = np.zeros(len(velocity_m_s))
        self._turns: Indices = np.zeros(len(velocity_m_s), dtype=np.int64)

    def add(self, velocity_m_s: Array) -> None:
        change_m_s = velocity_m_s - 2 * self._before_m_s + self._twice_before_m_s
        square = np.einsum("ij,ij->i", change_m_s, change_m_s)
        along = np.einsum("ij,ij->i", change_m_s, self._change_m_s)
        turned = (along < -ROUND * np.sqrt(square * self._square)) & (square > self._square)
        self._turns = (self._turns + 1) * turned
        self._first = np.where(self._turns > 1, self._first, square)
        self._twice_before_m_s, self._before_m_s = self._before_m_s, velocity_m_s
        self._change_m_s, self._square = change_m_s, square
        self._fastest_m_s = max(self._fastest_m_s, float(np.abs(velocity_m_s).max(initial=0.0)))
        self.alternating_m_s = 0.0
        if self._turns.max(initial=0) >= TURNS:
            grows = (self._turns >= TURNS) & (square > GROWTH**2 * self._first)
            self.alternating_m_s = float(np.sqrt(square[grows].max(initial=0.0))) / 4

    def share(self) -> float:
        """Speed of the fastest point that alternates and grows, of the largest speed so far."""
        return self.alternating_m_s / max(self._fastest_m_s, SLOW_M_S)

    def begin_anew(self) -> None:
        """Begins anew, where intervals are of another length."""
        self.alternating_m_s = 0.0
        self._begin(self._before_m_s)

    def save(self) -> Saved:
        return taken(self, *_ALL)

    def restore(self, saved: Saved) -> None:
        put_back(self, saved, *_ALL)
