"""The particles that were fed and that left, one by one and by cycles, and the steady state.

The steady state follows from the mass balance in two steps.  The first step finds its begin: leaving out
the start-up makes the mean hold-up of the rest as certain as possible (marginal standard error
rule; White, Simulation 69, 1997, 323-334, doi 10.1177/003754979706900601).  The second step checks the
rest: a straight line through the hold-up must not rise or fall by more than 2 % of the feed, and the mass
out must equal the mass in within 2 %, apart from chance.  In less out is the difference of the hold-up at
two times, which a few large stones decide where a slice is narrow: it may be larger by twice the standard
deviation of such a difference, from the scatter of the hold-up about the line.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from orchestrator.case.bed.saved_bed import grains_of, shapes_in
from orchestrator.figures.estimate import Estimate
from orchestrator.figures.results import BATCH
from orchestrator.output.cycles import cycle_numbers, within
from orchestrator.output.results.estimate import FEWEST_INDEPENDENT, IntervalOf, batch_sums, estimate
from orchestrator.output.results.listed_feed import ListedFeed
from orchestrator.ports import Array, Indices

LOST = -1
UNDERSIZE, OVERSIZE = "undersize", "oversize"
FEWEST_CYCLES = 20
LARGEST_IMBALANCE = 0.02
ROUNDING = 1e-12  # of sums of masses
CHANCE = 2 * 2**0.5  # times the scatter of the hold-up: two standard deviations of a difference of two


@dataclass(frozen=True)
class EventTable:
    """Particles that came or left, in arrays (n,); particles that are present at t = 0 came at time 0.

    Only particles that left have ``position_m`` (n, 3), ``exit``, the exit's number or ``LOST`` = -1, and
    what was counted of them, by panels in the order of the deck: ``contacts``, ``over_s`` and
    ``within_reach_s`` (n, panels), and ``last_panel`` (n,), that of the last contact (``ports.Removed``).
    """

    id: Indices
    time_s: Array
    sieve_size_m: Array
    mass_kg: Array
    position_m: Array = field(default_factory=lambda: np.empty((0, 3)))
    exit: Indices = field(default_factory=lambda: np.empty(0, dtype=int))
    contacts: Indices = field(default_factory=lambda: np.empty((0, 0), dtype=int))
    over_s: Array = field(default_factory=lambda: np.empty((0, 0)))
    within_reach_s: Array = field(default_factory=lambda: np.empty((0, 0)))
    last_panel: Indices = field(default_factory=lambda: np.empty(0, dtype=int))

    def part(self, rows: Any) -> EventTable:
        """Return the particles that a mask (n,) chooses."""
        return EventTable(
            **{name: column[rows] if len(column) else column for name, column in vars(self).items()}
        )


@dataclass(frozen=True)
class Exits:
    """The names and the products ("undersize" or "oversize") of the exits, by number."""

    names: tuple[str, ...]
    products: tuple[str, ...]

    def of(self, product: str) -> Indices:
        """Return the numbers of the exits of a product, in the case's order."""
        return np.array([i for i, own in enumerate(self.products) if own == product], dtype=int)


def read_events(history: Any) -> tuple[EventTable, EventTable, Exits] | None:
    """Return the particles that came, the particles that left, and the exits from an open ``history.h5``.

    Return None if the run did not count particles in and out.
    """
    if "fed/id" not in history or "removed/id" not in history:
        return None
    removed = history["removed"]
    exits = Exits(*(tuple(map(str, removed.attrs[key])) for key in ("names", "products")))
    ways = removed["position_m"][:], removed["exit"][:].astype(int)
    kinds = {"contacts": int, "over_s": float, "within_reach_s": float, "last_panel": int}
    counted = (removed[name][:].astype(kind) for name, kind in kinds.items())
    return EventTable(*_particles(history["fed"])), EventTable(*_particles(removed), *ways, *counted), exits


def _particles(group: Any) -> tuple[Indices, Array, Array, Array]:
    grains = grains_of(group, shapes_in(group.attrs))
    return group["id"][:], group["time_s"][:], grains.sieve_size_m, grains.mass_kg


def per_cycle(
    time_s: Array, mass_kg: Array, edges_s: Array, group: Indices | None = None, groups: int = 1
) -> Array:
    """Return the mass (cycles, groups) by cycle and group; other group numbers are left out."""
    cycle = cycle_numbers(time_s, float(edges_s[1] - edges_s[0]))
    return sums_by(cycle, len(edges_s) - 1, mass_kg, group, groups)


def sums_by(
    part: Indices, parts: int, mass_kg: Array, group: Indices | None = None, groups: int = 1
) -> Array:
    """Return the mass (parts, groups) of particles by the part and the group of each; other numbers of
    either are left out."""
    group = np.zeros(len(part), dtype=int) if group is None else group
    counted = (part >= 0) & (part < parts) & (group >= 0) & (group < groups)
    table = np.zeros((parts, groups))
    np.add.at(table, (part[counted], group[counted]), mass_kg[counted])
    return table


@dataclass(frozen=True)
class SteadyState:
    """The cycles from ``first`` up to ``last``, without ``last``, over which to average.

    If they are not steady, ``reason`` says why; otherwise it is empty.  ``imbalance`` is (in - out) / in
    over the cycles, and ``drift`` is the slope of the hold-up over the rate of feed.
    """

    first: int
    last: int
    reason: str
    imbalance: float | None = None
    drift: float | None = None


@dataclass(frozen=True)
class Balance:
    """The mass balance by whole cycles: the masses ``fed_kg`` and ``out_kg`` in each cycle, (cycles,) each,
    the mass ``held_kg`` (cycles + 1,) in the machine at the edges of the cycles, and its mean over each
    cycle, ``mean_held_kg`` (cycles,)."""

    fed_kg: Array
    out_kg: Array
    held_kg: Array
    mean_held_kg: Array


def find_steady_state(balance: Balance) -> SteadyState:
    """Find the steady state from the mass balance."""
    fed_kg, out_kg, held_kg = balance.fed_kg, balance.out_kg, balance.held_kg
    cycles = len(fed_kg)
    feeding = np.flatnonzero(fed_kg)
    if not len(feeding):
        return SteadyState(0, cycles, BATCH)
    last = int(feeding[-1]) + 1
    if cycles - last > 1:
        end = f"the feed stops after cycle {last}"
    else:
        last, end = cycles, "the run ends"
    if last - feeding[0] < FEWEST_CYCLES:
        fed = f"only {last - int(feeding[0])} cycles are fed before {end}"
        return SteadyState(0, cycles, f"{fed}; {FEWEST_CYCLES} are needed")
    mean_kg = balance.mean_held_kg[:last]
    first = find_truncation(mean_kg)
    window = slice(first, last)
    in_kg, gone_kg = float(fed_kg[window].sum()), float(out_kg[window].sum())
    imbalance = (in_kg - gone_kg) / in_kg
    slope_kg, scatter_kg = _line(mean_kg[window])
    drift = slope_kg * (last - first) / in_kg
    limits = LARGEST_IMBALANCE + CHANCE * scatter_kg / in_kg, LARGEST_IMBALANCE
    if reason := _why_not_steady(imbalance, drift, limits, last - first, held_kg[last], gone_kg):
        return SteadyState(0, cycles, reason, imbalance, drift)
    return SteadyState(first, last, "", imbalance, drift)


def find_truncation(values: Array) -> int:
    """Return the number of first values to leave out by the marginal standard error rule.

    At most half of the values are left out, and at least ``FEWEST_CYCLES`` stay.
    """
    candidates = range(min(len(values) // 2, len(values) - FEWEST_CYCLES) + 1)
    rounding = (ROUNDING * float(np.abs(values).max())) ** 2  # a variance below is that of equal values
    errors = [max(float(values[d:].var()), rounding) / (len(values) - d) for d in candidates]
    return int(np.argmin(errors))


def _line(values: Array) -> tuple[float, float]:
    """Return the slope of a straight line through equally spaced values, and their standard deviation from
    the line."""
    number = np.arange(len(values))
    line = np.polyfit(number, values, 1)
    return float(line[0]), float(
        np.sqrt(np.sum((values - np.polyval(line, number)) ** 2) / (len(values) - 2))
    )


def _why_not_steady(
    imbalance: float, drift: float, limits: tuple[float, float], cycles: int, held_kg: float, gone_kg: float
) -> str:
    """Return why a state is not steady; empty if it is.

    ``limits`` are the largest imbalance and the largest drift.  If the deck holds more mass than left it, the
    particles stay longer than the cycles last (Little's law).
    """
    of = ("in less out", imbalance), ("the growth of the hold-up", drift)
    for (what, value), largest in zip(of, limits, strict=True):
        if abs(value) > largest:
            share = f"{100 * value:+.1f} % of the feed over the last {cycles} cycles"
            return f"{what} is {share}; up to {100 * largest:.2g} % counts as steady"
    if held_kg > gone_kg:
        return f"the last {cycles} cycles are shorter than the particles' residence time"
    return ""


@dataclass(frozen=True)
class Events:
    """The particles that came and left, the ``edges_s`` of the whole cycles, and when feeds start or stop.

    Particles that are present at t = 0 do not count as fed.  ``listed`` is the feed for which they stand; by
    default each stands for itself.
    """

    fed: EventTable
    removed: EventTable
    exits: Exits
    edges_s: Array
    feed_changes_s: tuple[float, ...] = ()
    listed: ListedFeed | None = None

    @cached_property
    def came_kg(self) -> Array:
        """The mass (fed,) for which each particle that came stands, in shares of the separation."""
        return self._represented_kg(self.fed)

    @cached_property
    def left_kg(self) -> Array:
        """The mass (removed,) for which each particle that left stands, in shares of the separation."""
        return self._represented_kg(self.removed)

    def _represented_kg(self, table: EventTable) -> Array:
        if self.listed is None:
            return table.mass_kg
        return table.mass_kg * self.listed.weight(table.sieve_size_m)

    @property
    def parts(self) -> int:
        """The number of parts into which sums over the particles that left are divided: the cycles."""
        return len(self.edges_s) - 1

    @cached_property
    def part(self) -> Indices:
        """The number (removed,) of the part in which each particle that left counts: the cycle in which it
        left."""
        return cycle_numbers(self.removed.time_s, float(self.edges_s[1] - self.edges_s[0]))

    def sums(self, mass_kg: Array, group: Indices | None = None, groups: int = 1) -> Array:
        """Return the mass (parts, groups) of the particles that left, of which each counts with ``mass_kg``
        (removed,), by part and by group."""
        return sums_by(self.part, self.parts, mass_kg, group, groups)

    @cached_property
    def balance(self) -> Balance:
        """The mass balance; a particle counts in the mean of the cycle in which it comes or leaves with the
        share of the cycle that is left."""
        later = self.fed.time_s > 0
        came_s, came_kg = self.fed.time_s[later], self.fed.mass_kg[later]
        left_s, left_kg = self.removed.time_s, self.removed.mass_kg
        cycle_s = float(self.edges_s[1] - self.edges_s[0])

        def by_cycle(time_s: Array, mass_kg: Array) -> tuple[Array, Array]:
            rest = cycle_numbers(time_s, cycle_s) + 1 - time_s / cycle_s
            parts = (per_cycle(time_s, kg, self.edges_s)[:, 0] for kg in (mass_kg, mass_kg * rest))
            return next(parts), next(parts)

        (fed_kg, fed_mean_kg), (out_kg, out_mean_kg) = by_cycle(came_s, came_kg), by_cycle(left_s, left_kg)
        start_kg = float(self.fed.mass_kg[~later].sum())
        held_kg = start_kg + np.concatenate([[0.0], np.cumsum(fed_kg - out_kg)])
        return Balance(fed_kg, out_kg, held_kg, held_kg[:-1] + fed_mean_kg - out_mean_kg)

    @cached_property
    def steady(self) -> SteadyState:
        """The steady state, or the cycles over which to average without one.

        The mass may balance although one feed stops and another one starts, which has other sizes.
        """
        state = find_steady_state(self.balance)
        inside_s = self.edges_s[[state.first + 1, state.last - 1]]
        changes_s = [at_s for at_s in self.feed_changes_s if inside_s[0] < at_s < inside_s[1]]
        if state.reason or not changes_s:
            return state
        reason = f"a feed starts or stops at {changes_s[0]:g} s, within the cycles that would be averaged"
        return replace(state, first=0, last=len(self.edges_s) - 1, reason=reason)

    @property
    def window(self) -> slice:
        """The slice of the cycles over which to average."""
        return slice(self.steady.first, self.steady.last)

    @property
    def window_s(self) -> tuple[float, float]:
        """The begin and the end of the cycles over which to average."""
        return float(self.edges_s[self.steady.first]), float(self.edges_s[self.steady.last])

    @property
    def left_in_window(self) -> Any:
        """The mask (removed,) of particles that left through an exit in the cycles over which to average."""
        inside = within(self.removed.time_s, *self.window_s, float(self.edges_s[1]))
        return inside & (self.removed.exit != LOST)

    @property
    def has_interval(self) -> bool:
        """Whether the cycles over which to average are long enough for intervals of what depends on the bed.

        The bed forgets within the mean stay of its mass (Little's law), so that each stay counts as one
        independent value.
        """
        held_kg, fed_kg = (mass[self.window] for mass in (self.balance.mean_held_kg, self.balance.fed_kg))
        return bool(FEWEST_INDEPENDENT * held_kg.mean() <= fed_kg.sum() * (1 + ROUNDING))

    def figure(
        self, statistic: Callable[[Array], float], cycles: Array, interval_of: IntervalOf | None = None
    ) -> Estimate:
        """Return the estimate of a statistic of the sum of ``cycles`` (parts, ...).

        The estimate has an interval in a steady state.
        """
        if self.steady.reason:
            value = statistic(cycles[self.window].sum(axis=0))
            return Estimate(float(value) if np.isfinite(value) else None)
        return estimate(statistic, batch_sums(cycles[self.window]), interval_of)

    def ratio(self, part: Array, whole: Array, interval_of: IntervalOf | None = None) -> Estimate:
        """Return the sum of ``part`` over the sum of ``whole``, (cycles,) each."""
        return self.figure(lambda sums: sums[0] / sums[1], np.column_stack([part, whole]), interval_of)

    def rate(self, per_cycle: Array, interval_of: IntervalOf | None = None) -> Estimate:
        """Return the rate per second of a quantity (cycles,) that is summed over each cycle."""
        cycle_s = float(self.edges_s[1] - self.edges_s[0])
        return self.ratio(per_cycle, np.full(len(per_cycle), cycle_s), interval_of)
