"""Time in whole numbers: sync intervals, and whole solver steps inside each.

Times given by a user are decimal numbers; dividing them as floats (0.3 / 0.1 = 2.999…) loses a
step now and then.  Here they become exact fractions first.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import cache

SAMPLES_PER_S = 2500  # rate of shapes and series: enough for accelerations up to 500 Hz


@cache
def exact(value_s: float) -> Fraction:
    """Return the decimal number that a user wrote as a fraction: 1e-4 is 1/10000 exactly."""
    return Fraction(repr(float(value_s)))


def times_s(count: int, length_s: float) -> float:
    """Return a whole number of times a length, rounded once: a quotient of whole numbers is."""
    length = exact(length_s)
    return count * length.numerator / length.denominator


@dataclass(frozen=True)
class Interval:
    """One interval of a row of equal ones that begins at t = 0.

    Parameters
    ----------
    index
        The interval's number, from 0.
    length_s
        The length of each in s.
    parts
        1 for a sync interval; n where the row consists of n equal parts of each sync interval.

    Examples
    --------
    >>> Interval(3, 0.1).end_s
    0.4
    >>> Interval(0, 1e-3).steps(3e-4)
    4
    """

    index: int
    length_s: float
    parts: int = 1

    def divided(self, parts: int) -> list[Interval]:
        """Return the equal parts of a sync interval; halves of halves of a decimal number are exact."""
        first, length_s = parts * self.index, self.length_s / parts
        return [Interval(first + part, length_s, parts) for part in range(parts)]

    @property
    def start_s(self) -> float:
        """The time at which the interval begins."""
        return times_s(self.index, self.length_s)

    @property
    def end_s(self) -> float:
        """The time at which the interval ends."""
        return times_s(self.index + 1, self.length_s)

    def steps(self, largest_step_s: float) -> int:
        """Return the fewest equal steps of at most ``largest_step_s`` that fill the interval."""
        return steps_in(self.length_s, largest_step_s)


@cache
def steps_in(length_s: float, largest_step_s: float) -> int:
    """Return the fewest equal steps of at most ``largest_step_s`` that fill ``length_s``.  Raises ValueError
    for a step that is not positive."""
    if largest_step_s <= 0:
        raise ValueError(f"a step must be positive, got {largest_step_s} s")
    return max(1, -(-exact(length_s) // exact(largest_step_s)))


def intervals(duration_s: float, length_s: float, first: int = 0) -> Iterator[Interval]:
    """Yield the sync intervals, from number ``first``, that cover ``duration_s``; the last may reach
    beyond it."""
    for index in range(first, steps_in(duration_s, length_s)):
        yield Interval(index, length_s)


def sample_s(interval_s: float) -> Fraction:
    """Return the time between two samples in s: a whole number of sync intervals of length ``interval_s``."""
    return max(1, round(1 / SAMPLES_PER_S / interval_s)) * exact(interval_s)
