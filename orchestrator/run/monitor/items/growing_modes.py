"""Modes of the interface that grow from interval to interval.

A coupling that is unstable on a light point leaves the unit circle at -1
(docs/theory/stability.md): the point's velocity changes its sign with every interval, and grows.
The second difference of three velocities is four times as large as what alternates, and small,
(w H)^2 of it, of what moves smoothly.  A point whose second differences turn round again and again,
each time larger than before, is taken for such a mode: what rings decays between two blows.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import sqrt

import numpy as np

from orchestrator.ports import Array, Indices, Saved
from orchestrator.ports.state import restore_attributes, save_attributes
from orchestrator.run.monitor.interface_work import SLOW_M_S, InterfaceData
from orchestrator.run.monitor.item import MonitorItem, Observation, Subject

TURNS = 8  # as often in succession
ROUND = 0.8  # of the way at least, as a cosine
GROWTH = 2.0  # as large after so many turns

_STATE = ("_before_m_per_s", "_step_m_per_s", "_change_m_per_s", "_first", "_turns")
_ALL = (*_STATE, "_quick_m_per_s", "_growing_m_per_s")


class Alternation:
    """Finds points of the surface whose velocity (points, 3) alternates between sync points, and grows.

    Points are looked at one by one only where one alternates with the share ``least`` of the
    surface's speed.
    """

    def __init__(self, velocity_m_per_s: Array, least: float) -> None:
        self._least = least
        self._quick_m_per_s, self._growing_m_per_s = SLOW_M_S, 0.0
        self._begin(velocity_m_per_s)

    def _begin(self, velocity_m_per_s: Array) -> None:
        self._before_m_per_s = velocity_m_per_s
        self._step_m_per_s, self._change_m_per_s = np.zeros((2, *velocity_m_per_s.shape))
        # making room anew takes longer than filling it
        self._room: tuple[Array, Array] = (np.empty_like(velocity_m_per_s), np.empty_like(velocity_m_per_s))
        self._first: Array = np.zeros(len(velocity_m_per_s))
        self._turns: Indices = np.zeros(len(velocity_m_per_s), dtype=np.int64)

    def add(self, velocity_m_per_s: Array) -> None:
        step_m_per_s, change_m_per_s = self._room
        np.subtract(velocity_m_per_s, self._before_m_per_s, out=step_m_per_s)
        np.subtract(step_m_per_s, self._step_m_per_s, out=change_m_per_s)
        if points := len(velocity_m_per_s):
            quick_m_per_s = sqrt(np.vdot(velocity_m_per_s, velocity_m_per_s) / points)
            self._quick_m_per_s = max(self._quick_m_per_s, quick_m_per_s)
            self._count(change_m_per_s, self._loud(change_m_per_s))
        self._before_m_per_s, self._room = (velocity_m_per_s, (self._step_m_per_s, self._change_m_per_s))
        self._step_m_per_s, self._change_m_per_s = step_m_per_s, change_m_per_s

    def _loud(self, change_m_per_s: Array) -> bool:
        """Returns whether a point may alternate fast enough to count.  The norm, no smaller than any of
        its parts, is the quickest to find."""
        least_m_per_s = 4 * self._least * self._quick_m_per_s
        if np.vdot(change_m_per_s, change_m_per_s) < least_m_per_s**2:
            return False
        return bool(max(change_m_per_s.max(), -change_m_per_s.min()) > least_m_per_s)

    def _count(self, change_m_per_s: Array, loud: bool) -> None:
        """Counts how often each point has turned round in succession."""
        self._growing_m_per_s = 0.0
        if not loud:
            if self._turns.any():
                self._turns = np.zeros_like(self._turns)
            return
        square, before, along = (
            np.einsum("ij,ij->i", *pair)
            for pair in (
                (change_m_per_s, change_m_per_s),
                (self._change_m_per_s, self._change_m_per_s),
                (change_m_per_s, self._change_m_per_s),
            )
        )
        turned = (along < -ROUND * np.sqrt(square * before)) & (square > before)
        self._turns = (self._turns + 1) * turned
        self._first = np.where(self._turns > 1, self._first, square)
        grows = (self._turns >= TURNS) & (square > GROWTH**2 * self._first)
        if grows.any():
            self._growing_m_per_s = float(np.sqrt(square[grows].max())) / 4

    def share(self) -> float:
        """Returns the speed of the fastest point that alternates and grows, of the surface's largest speed
        so far (the root mean square of all points')."""
        return self._growing_m_per_s / self._quick_m_per_s

    def begin_anew(self) -> None:
        """Forgets what alternates: intervals are of another length from now on."""
        self._growing_m_per_s = 0.0
        self._begin(self._before_m_per_s)

    def save(self) -> Saved:
        return save_attributes(self, *_ALL)

    def restore(self, saved: Saved) -> None:
        restore_attributes(self, saved, *_ALL)


class GrowingModes(MonitorItem):
    """The largest speed of a point that alternates and grows, of the largest speed of the panels so far."""

    name = "growing_modes"
    limit_key = "largest_growing_share"
    message = (
        "a mode of the interface grows: a point alternates from interval to interval with "
        "{value:.2g} of the surface's largest speed so far"
    )

    def __init__(self, subject: Subject) -> None:
        super().__init__(subject)
        self._panels = slice(0, max((panel.surface.stop for panel in subject.machine.panels), default=None))
        velocity_m_per_s = subject.start.panel.surface.velocity_m_per_s[self._panels]
        self._modes = Alternation(velocity_m_per_s, subject.case.monitor.largest_growing_share)

    def add_interval(self, data: InterfaceData) -> None:
        self._modes.add(data.panel[2].surface.velocity_m_per_s[self._panels])

    def observe(self) -> Iterator[Observation]:
        yield Observation(self._modes.share())

    def begin_anew(self) -> None:
        self._modes.begin_anew()

    def save(self) -> Saved:
        return self._modes.save()

    def restore(self, saved: Saved) -> None:
        self._modes.restore(saved)
