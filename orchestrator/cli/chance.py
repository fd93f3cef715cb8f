"""``flipflow plan --for``: what it takes until chance leaves a result within a tolerance, and its price.

The half width of the interval of a share of the material falls with the root of  counted seconds x width of
the slice x runs  (docs/measured/accuracy.md).  Each run with another seed fills its deck anew, and of that
time nothing is counted.  The particles' part of the processor time grows with the width and with the filling
of the deck; all other parts grow with the simulated time alone.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product

from orchestrator.cli.planning import Timing

MOST_S = 1e6
"""A longer run is not planned."""


@dataclass(frozen=True)
class Basis:
    """What a measured run says about chance and price.

    ``half_width`` is that of the result's 95 % interval, over ``counted_s`` that follow ``settling_s``.
    ``timing`` has the processor time of its start and of its stepping (``timing.wall_s`` with
    ``processor_s``), and ``width_m`` is the width of its slice, None without one.  ``least_s`` is the least
    time that must be counted, ``longest_s`` the longest run that its feed allows, and ``every_s`` what a
    duration is a multiple of.
    """

    half_width: float
    counted_s: float
    settling_s: float
    simulated_s: float
    processor_s: float
    timing: Timing
    width_m: float | None = None
    least_s: float = 0.0
    longest_s: float = MOST_S
    every_s: float = 0.1

    def price_s(self, duration_s: float, width_ratio: float = 1.0, cost_ratio: float = 1.0) -> float:
        """Return the processor time of a run whose width and cost of a second are these times its own."""
        start_s, share = self.timing.study_start_s, self.timing.particles
        stepping_s = (self.processor_s - start_s) * (1 + share * (width_ratio - 1)) * cost_ratio
        return self.timing.wall_s(start_s + stepping_s, duration_s)

    @cached_property
    def stepping_s(self) -> float:
        """The processor time that this run took after its start."""
        return self.price_s(self.simulated_s) - self.timing.start_s


@dataclass(frozen=True)
class Numerics:
    """Settings of a study, with the bound of the error of the result, in its unit, and what a second costs
    relative to the case as it is.  ``at_most`` is None where the error is not known, and counts as none.
    """

    label: str = "the case as it is"
    sets: tuple[str, ...] = ()
    at_most: float | None = None
    ratio: float = 1.0


@dataclass(frozen=True)
class Way:
    """A way to the tolerance: ``runs`` of a duration, a width and settings, side by side on ``cores``.

    ``goes_on`` says that the one run is the measured run, continued.
    """

    basis: Basis
    numerics: Numerics
    runs: int = 1
    width_m: float | None = None
    cores: int = 1
    goes_on: bool = False

    @property
    def width_ratio(self) -> float:
        """The width over that of the measured run."""
        if self.width_m is None or self.basis.width_m is None:
            return 1.0
        return self.width_m / self.basis.width_m

    def half_width(self, duration_s: float) -> float:
        """Return the half width of the interval of the mean over the runs."""
        counted_s = (duration_s - self.basis.settling_s) * self.width_ratio * self.runs
        return self.basis.half_width * math.sqrt(self.basis.counted_s / counted_s)

    def duration_s(self, half_width: float) -> float:
        """Return the shortest duration with a half width, whole multiples of ``every_s``."""
        basis = self.basis
        counted_s = basis.counted_s * (basis.half_width / half_width) ** 2 / self.width_ratio / self.runs
        duration_s = basis.settling_s + max(counted_s, basis.least_s)
        if self.goes_on:
            duration_s = max(duration_s, basis.simulated_s)
        return math.ceil(duration_s / basis.every_s * (1 - 1e-9)) * basis.every_s

    def price_s(self, duration_s: float) -> float:
        """Return the processor time of all runs, without what the measured run has taken already."""
        one_s = self.basis.price_s(duration_s, self.width_ratio, self.numerics.ratio)
        return self.runs * one_s - (self.basis.stepping_s if self.goes_on else 0.0)

    def wall_s(self, duration_s: float) -> float:
        """Return the time that the runs take, each on a core of its own."""
        return self.price_s(duration_s) / self.runs * math.ceil(self.runs / self.cores)

    def longest_s(self, wall_s: float) -> float | None:
        """Return the longest duration within a wall time; None where it ends before enough is counted."""
        basis, least_s = self.basis, self.basis.settling_s + self.basis.least_s
        most = math.floor(basis.longest_s / basis.every_s + 1e-9)
        least = math.ceil(max(least_s, basis.simulated_s * self.goes_on) / basis.every_s * (1 - 1e-9))
        if most < least or self.wall_s(least * basis.every_s) > wall_s:
            return None
        while least < most:  # bisection: the price grows with the duration
            middle = (least + most + 1) // 2
            least, most = (
                (middle, most) if self.wall_s(middle * basis.every_s) <= wall_s else (least, middle - 1)
            )
        return least * basis.every_s


@dataclass(frozen=True)
class Priced:
    """A way with a duration: its half width by chance, and its price as processor and as wall time."""

    way: Way
    duration_s: float

    @property
    def half_width(self) -> float:
        """The half width by chance."""
        return self.way.half_width(self.duration_s)

    @property
    def price_s(self) -> float:
        """The processor time."""
        return self.way.price_s(self.duration_s)

    @property
    def wall_s(self) -> float:
        """The wall time."""
        return self.way.wall_s(self.duration_s)

    @property
    def error(self) -> float:
        """The half width by chance, and the bound of the error of numerics where it is known."""
        return self.half_width + (self.way.numerics.at_most or 0.0)


@dataclass(frozen=True)
class ChancePlan:
    """All ways to a tolerance, which is in the unit of the result, and the time that there is for them.

    ``can_go_on`` says whether the measured run can be continued; ``widths_m`` are the widths of a slice.
    """

    basis: Basis
    tolerance: float
    budget_s: float
    cores: int = 1
    can_go_on: bool = False
    widths_m: tuple[float, ...] = ()
    numerics: tuple[Numerics, ...] = (Numerics(),)

    @cached_property
    def ways(self) -> tuple[Way, ...]:
        """Every way; numbers of runs go up to the number of cores."""
        widths_m: Sequence[float | None] = self.widths_m or (self.basis.width_m,)
        every = product(self.numerics, range(1, self.cores + 1), widths_m)
        made = [Way(self.basis, one, runs, width_m, self.cores) for one, runs, width_m in every]
        own = [one for one in self.numerics if not one.sets]
        going_on = [Way(self.basis, one, 1, self.basis.width_m, self.cores, True) for one in own]
        return (*(going_on if self.can_go_on else ()), *made)

    @cached_property
    def within(self) -> list[Priced]:
        """All ways that reach the tolerance, whatever time they take, from cheap to dear.

        Those whose error of numerics is known to be within it come first.
        """
        found = self._within()
        return sorted(found, key=lambda one: (one.way.numerics.at_most is None, one.price_s, one.way.runs))

    def _within(self) -> Iterator[Priced]:
        for way in self.ways:
            left = self.tolerance - (way.numerics.at_most or 0.0)
            if left > 0 and (duration_s := way.duration_s(left)) <= self.basis.longest_s:
                yield Priced(way, duration_s)

    @property
    def choice(self) -> Priced | None:
        """The cheapest way that fits into the time; None where there is none."""
        return next((one for one in self.within if one.wall_s <= self.budget_s), None)

    @property
    def best(self) -> Priced | None:
        """What leaves the least error within the time; None where not even the shortest run fits."""
        lasting = ((way, way.longest_s(self.budget_s)) for way in self.ways)
        priced = (Priced(way, duration_s) for way, duration_s in lasting if duration_s is not None)
        return min(priced, key=lambda one: (one.error, one.price_s), default=None)
