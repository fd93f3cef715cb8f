"""Intervals in parts: the same as a finer run, and nobody else notices."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from orchestrator.case.bed.feed import Feeds
from orchestrator.coupling.schemes import SCHEMES, create_scheme
from orchestrator.coupling.schemes.scheme import State, initial_state
from orchestrator.ports.clock import Interval
from orchestrator.run.monitor.pace import Pace
from tests.coupling.line import FreeFrame, HungPlate, Sphere, members
from tests.particles.test_feed import INLET


@given(st.integers(0, 10**6), st.integers(1, 999), st.integers(-7, -3), st.integers(0, 6))
def test_parts_fill_the_interval_exactly(index: int, digits: int, ten: int, halvings: int) -> None:
    whole = Interval(index, float(f"{digits}e{ten}"))
    parts = whole.divided(2**halvings)
    assert parts[0].start_s == whole.start_s
    assert parts[-1].end_s == whole.end_s
    assert all(before.end_s == after.start_s for before, after in pairwise(parts))


@pytest.mark.parametrize(("steps", "parts", "each"), [(20, 2, 10), (20, 8, 3), (59, 4, 15)])
def test_every_part_has_whole_steps(steps: int, parts: int, each: int) -> None:
    whole = Interval(3, 1e-4)
    step_s = 1e-4 / steps * 1.0000001
    assert whole.steps(step_s) == steps
    assert {part.steps(step_s) for part in whole.divided(parts)} == {each}


def test_a_feed_comes_once_in_an_interval_and_not_in_each_part() -> None:
    feeds = Feeds([INLET], every=20)
    came = []
    for index in range(20, 60):
        for part in Interval(index, 1e-3).divided(4):
            came.append(len(feeds.due(part)))
            feeds.settle(np.ones(came[-1], dtype=bool))
    assert [number for number, count in enumerate(came) if count] == [0, 4 * 20]


def line() -> tuple[Sphere, HungPlate, FreeFrame]:
    """One that stays in touch, on all springs."""
    return Sphere(1.0, 4.0, -0.05, 0.0, stays=True), HungPlate(2.0, 3.0), FreeFrame(5.0)


def run(name: str, length_s: float, parts: list[int]) -> tuple[State, list[State], Pace]:
    """Intervals of ``length_s`` in so many parts each: the state at the end, what was recorded."""
    solvers, pace, recorded = members(*line()), Pace(length_s, 64, 1), []
    state, chosen = initial_state(solvers), create_scheme(name)
    for index, pace.parts in enumerate(parts):
        state, seen = pace.advance(chosen, solvers, Interval(index, length_s), state, lambda part: None)
        recorded.append(seen)
    return state, recorded, pace


@pytest.mark.parametrize("name", list(SCHEMES))
def test_in_parts_it_is_the_finer_run(name: str) -> None:
    in_parts, recorded, _ = run(name, 0.2, [4, 4])
    fine, fine_recorded, _ = run(name, 0.05, [1] * 8)
    np.testing.assert_array_equal(in_parts.panel.surface.position_m, fine.panel.surface.position_m)
    np.testing.assert_array_equal(in_parts.load.force_N, fine.load.force_N)
    mean_N = np.mean([record.load.force_N for record in fine_recorded[4:]], axis=0)
    np.testing.assert_allclose(recorded[1].load.force_N, mean_N, rtol=1e-15)
    mean_N = np.mean([record.panel.reaction.force_N for record in fine_recorded[4:]], axis=0)
    np.testing.assert_allclose(recorded[1].panel.reaction.force_N, mean_N, rtol=1e-15)


@pytest.mark.parametrize("name", list(SCHEMES))
def test_no_momentum_is_lost_when_the_length_changes(name: str) -> None:
    sphere, plate, frame = line()
    solvers, pace = members(sphere, plate, frame), Pace(0.2, 64, 1)
    state, chosen = initial_state(solvers), create_scheme(name)
    for index, pace.parts in enumerate([1, 2, 4, 4, 2, 1, 1]):
        state, _ = pace.advance(chosen, solvers, Interval(index, 0.2), state, lambda part: None)
    pending = chosen.pending(state, Interval(0, pace.last_s))
    momentum = sphere.v * 1.0 + plate.v * 2.0 + frame.v * 5.0
    held = pending.load_N_s[0] + pending.reaction_N_s[0]
    # in transit: what the sphere has given the plate, and the plate the frame
    assert momentum + held == pytest.approx(0.0, abs=1e-12)
    assert abs(sphere.v) > 0.005


def test_it_halves_down_to_the_shortest_and_comes_back_when_calm() -> None:
    pace = Pace(1e-4, 5, calm=3)
    assert [pace.shorten() for _ in range(3)] == [True, True, False]
    assert pace.parts == 4
    assert not pace.trusted
    assert [pace.ease() for _ in range(6)] == [False, False, True, False, False, True]
    assert pace.parts == 1
    assert not pace.trusted  # not before a calm time in whole intervals
    assert [pace.ease() for _ in range(3)] == [False] * 3
    assert pace.trusted


def test_it_waits_twice_as_long_where_it_came_back_too_early() -> None:
    pace = Pace(1e-4, 4, calm=2)
    pace.shorten()
    assert [pace.ease() for _ in range(2)] == [False, True]
    pace.shorten()
    assert [pace.ease() for _ in range(4)] == [False, False, False, True]


def test_trouble_in_between_makes_it_wait_anew() -> None:
    pace = Pace(1e-4, 2, calm=2)
    pace.shorten()
    pace.ease()
    pace.shorten()
    assert [pace.ease() for _ in range(2)] == [False, True]


def test_what_was_done_is_counted() -> None:
    _, _, pace = run("particles-first", 0.2, [1, 4, 2, 1, 1])
    assert (pace.divided, pace.finest) == (2, 4)


def test_it_is_restored() -> None:
    pace, other = Pace(1e-4, 8, calm=2), Pace(1e-4, 8, calm=2)
    for step in (pace.shorten, pace.ease, pace.ease, pace.shorten, pace.ease):
        step()
    other.restore(pace.save())
    assert vars(other) == vars(pace)
