"""Panels on several ranks against the same panels in one process."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from adapters.panel import strip
from adapters.panel.common import carried
from orchestrator.coupling.metered import Stopwatch, TimedPanel
from orchestrator.coupling.panel_set import PanelSet
from orchestrator.coupling.wrappers import PanelWrapper
from orchestrator.ports import Load, Motion, Panel, PanelState
from orchestrator.ports.clock import Interval
from orchestrator.ports.plans import SolverFailed
from tests.panel.elastic_plans import BRANCHES, plan

LENGTH_S = 1e-4
STRIPS = 5


class Ranks:
    """Threads as ranks, with the collective calls that a set of panels makes."""

    def __init__(self, size: int) -> None:
        self.size = size
        self._barrier, self._given = threading.Barrier(size, timeout=20), [None] * size

    def run(self, work: Callable[[Any], Any]) -> list[Any]:
        """Return what each rank makes of its communicator."""
        with ThreadPoolExecutor(self.size) as pool:
            return list(pool.map(work, [Rank(self, number) for number in range(self.size)]))

    def gather(self, rank: int, value: Any) -> list[Any]:
        self._given[rank] = value
        self._barrier.wait()
        every = list(self._given)
        self._barrier.wait()
        return every


class Rank:
    def __init__(self, ranks: Ranks, rank: int) -> None:
        self._ranks, self.rank, self.size = ranks, rank, ranks.size

    def allgather(self, value: Any) -> list[Any]:
        return self._ranks.gather(self.rank, value)

    def Allgatherv(self, sent: Any, into: Any) -> None:
        received, counts = into
        every = self._ranks.gather(self.rank, sent.copy())
        assert [numbers.size for numbers in every] == counts.tolist()
        received[:] = np.concatenate(every)


def opened(number: int) -> Panel:
    """Strips of different lengths, and a rigid surface at the end."""
    if number == STRIPS:
        return carried.build(np.arange(12.0).reshape(4, 3), ("driven",) * 4)
    given = plan(length_m=0.3, span_m=0.3075, cells=(4 + number, 1), branches=BRANCHES)
    return TimedPanel(strip.build(replace(given, name=f"panel {number}")), "strip", "panel", Stopwatch())


class Alone(PanelWrapper):
    """A panel that cannot be joined, as one on stops."""


def test_panels_on_both_sides_of_one_that_stands_alone_are_joined() -> None:
    def with_one_alone(number: int) -> Panel:
        panel = opened(number)
        return TimedPanel(Alone(panel), "alone", "panel", Stopwatch()) if number == 2 else panel

    members = PanelSet(STRIPS + 1, with_one_alone)
    assert [group.panels for group in members._groups] == [[0, 1], [2], [3, 4], [5]]


def test_panels_that_are_open_are_closed_where_another_cannot_be_opened() -> None:
    closed: list[int] = []

    class Counted(PanelWrapper):
        def close(self) -> None:
            closed.append(0)
            super().close()

    def opened_but_one(number: int) -> Panel:
        if number == 2:
            raise SolverFailed("the third does not open")
        return Counted(opened(number))

    with pytest.raises(SolverFailed, match="the third"):
        PanelSet(STRIPS + 1, opened_but_one)
    assert len(closed) == 2


def moved(communicator: Any) -> tuple[PanelState, list[int]]:
    """The state after three intervals of random loads, and how many panels each call advances."""
    members, random = PanelSet(STRIPS + 1, opened, communicator), np.random.default_rng(7)
    at_m = members.mount.position_m
    for index in range(3):
        load = Load(random.normal(size=members.initial().surface.position_m.shape))
        step_m = 1e-4 * random.normal(size=at_m.shape)
        clamps = Motion(at_m + (index + 1) * step_m, step_m / LENGTH_S)
        state = members.advance(Interval(index, LENGTH_S), clamps, load)
    return state, [len(group.panels) for group in members._groups]


@pytest.mark.parametrize(
    ("size", "together"), [(2, [[3], [2, 1]]), (4, [[1], [2], [1], [1, 1]]), (8, [[], [1], [1], [1]] * 2)]
)
def test_ranks_join_their_panels_and_know_the_states_of_all(size: int, together: list[list[int]]) -> None:
    """The states agree to the last bit, on ranks with several panels, one or none."""
    alone, joined = moved(None)
    assert joined == [STRIPS, 1]
    for (state, groups), expected in zip(Ranks(size).run(moved), together, strict=True):
        assert groups == expected
        assert np.array_equal(state.surface.position_m, alone.surface.position_m)
        assert np.array_equal(state.surface.velocity_m_per_s, alone.surface.velocity_m_per_s)
        assert np.array_equal(state.reaction.force_N, alone.reaction.force_N)
