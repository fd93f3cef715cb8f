"""Whole numbers of steps, whatever decimal lengths a user writes."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from orchestrator.ports.clock import Interval, exact, intervals, steps_in


def test_decimals_are_exact() -> None:
    assert exact(1e-4) == Fraction(1, 10000)
    assert steps_in(0.3, 0.1) == 3  # 0.3 / 0.1 is 2.999… in floating point
    assert steps_in(1e-4, 2.2e-5) == 5
    assert steps_in(1e-5, 1e-4) == 1


def test_intervals_cover_the_duration() -> None:
    assert len(list(intervals(0.5, 1e-4))) == 5000
    assert [i.index for i in intervals(0.25, 0.1)] == [0, 1, 2]


def test_a_step_of_nothing_is_refused() -> None:
    with pytest.raises(ValueError, match="positive"):
        steps_in(1.0, 0.0)


@given(st.integers(1, 10**7), st.integers(1, 10**6), st.integers(0, 10**6))
def test_steps_fill_the_interval(length_us: int, step_us: int, index: int) -> None:
    length_s, step_s = length_us / 10**6, step_us / 10**6
    steps = steps_in(length_s, step_s)
    assert steps * exact(step_s) >= exact(length_s)
    assert steps == 1 or (steps - 1) * exact(step_s) < exact(length_s)
    interval = Interval(index, length_s)
    assert interval.end_s == Interval(index + 1, length_s).start_s


@given(st.integers(0, 10**6), st.integers(1, 10**7))
def test_times_are_the_decimals_rounded_once(index: int, length_us: int) -> None:
    length_s = length_us / 10**6
    assert Interval(index, length_s).start_s == float(index * exact(length_s))
    assert Interval(2, 0.1).end_s == 0.3  # 3 * 0.1 is 0.30000000000000004
