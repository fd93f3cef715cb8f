"""What was fed and what left, particle by particle and by cycles, and the steady state.

The steady state is found from the mass balance in two steps.  Where it may begin: the start-up to
leave out is the one that makes the mean hold-up of the rest most certain (marginal standard error
rule; White, Simulation 69, 1997, 323-334, doi 10.1177/003754979706900601).  Whether it is one: over
the rest, what goes out equals what comes in within 2 %, and so does a straight line through the
hold-up.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from orchestrator.output.cycles import cycle_numbers, within
from orchestrator.output.results.estimate import Estimate, batch_sums, estimate
from orchestrator.ports import Array, Indices
from orchestrator.ports.physics import sphere_mass_kg

LOST = -1
UNDERSIZE, OVERSIZE = "undersize", "oversize"
FEWEST_CYCLES = 20
LARGEST_IMBALANCE = 0.02


@dataclass(frozen=True)
class EventTable:
    """Particles that came (those of t = 0 with time 0), or that left: arrays (n,).  ``position_m``
    (n, 3) and ``exit``, its number or ``LOST`` = -1, are of those that left alone."""

    id: Indices
    time_s: Array
    diameter_m: Array
    mass_kg: Array
    position_m: Array = field(default_factory=lambda: np.empty((0, 3)))
    exit: Indices = field(default_factory=lambda: np.empty(0, dtype=int))


@dataclass(frozen=True)
class Exits:
    """Names and products ("undersize" or "oversize") of the exits, by number."""

    names: tuple[str, ...]
    products: tuple[str, ...]

    def of(self, product: str) -> Indices:
        """Return the numbers of the exits of a product, in the case's order."""
        return np.array([i for i, own in enumerate(self.products) if own == product], dtype=int)


def read_events(history: Any) -> tuple[EventTable, EventTable, Exits] | None:
    """Return what an open ``history.h5`` says of particles that came and left, and of the exits; None if
    the run counted none in and out."""
    if "fed/id" not in history or "removed/id" not in history:
        return None
    removed = history["removed"]
    exits = Exits(*(tuple(map(str, removed.attrs[key])) for key in ("names", "products")))
    ways = removed["position_m"][:], removed["exit"][:].astype(int)
    return EventTable(*_particles(history["fed"])), EventTable(*_particles(removed), *ways), exits


def _particles(group: Any) -> tuple[Indices, Array, Array, Array]:
    diameter_m = group["diameter_m"][:]
    mass_kg = sphere_mass_kg(diameter_m, group["density_kg_per_m3"][:])
    return group["id"][:], group["time_s"][:], diameter_m, mass_kg


def per_cycle(
    time_s: Array, mass_kg: Array, edges_s: Array, group: Indices | None = None, groups: int = 1
) -> Array:
    """Return (cycles, groups): mass by cycle and group (a number from 0; others are not counted)."""
    cycle = cycle_numbers(time_s, float(edges_s[1] - edges_s[0]))
    group = np.zeros(len(time_s), dtype=int) if group is None else group
    counted = (cycle < len(edges_s) - 1) & (group >= 0) & (group < groups)
    table = np.zeros((len(edges_s) - 1, groups))
    np.add.at(table, (cycle[counted], group[counted]), mass_kg[counted])
    return table


@dataclass(frozen=True)
class SteadyState:
    """Cycles ``first`` to ``last`` (not included) over which to average.

    Where ``reason`` is not empty they are no steady state, and it says why.  ``imbalance`` is
    (in - out) / in over them, ``drift`` the slope of the hold-up over the rate of feed.
    """

    first: int
    last: int
    reason: str
    imbalance: float | None = None
    drift: float | None = None


def find_steady_state(fed_kg: Array, out_kg: Array, start_kg: float) -> SteadyState:
    """Find the steady state, where ``fed_kg`` and ``out_kg`` (cycles,) are the masses in each whole
    cycle, ``start_kg`` what is there at the first one's beginning."""
    cycles = len(fed_kg)
    feeding = np.flatnonzero(fed_kg)
    if not len(feeding):
        return SteadyState(0, cycles, "nothing is fed: a batch is never steady")
    last = int(feeding[-1]) + 1
    if cycles - last > 1:
        end = f"the feed stops after cycle {last}"
    else:
        last, end = cycles, "the run ends"
    if last - feeding[0] < FEWEST_CYCLES:
        fed = f"only {last - int(feeding[0])} cycles are fed before {end}"
        return SteadyState(0, cycles, f"{fed}; {FEWEST_CYCLES} are needed")
    held_kg = hold_up_kg(fed_kg, out_kg, start_kg)
    mean_kg = (held_kg[:last] + held_kg[1 : last + 1]) / 2
    first = find_truncation(mean_kg)
    window = slice(first, last)
    in_kg, gone_kg = float(fed_kg[window].sum()), float(out_kg[window].sum())
    imbalance = (in_kg - gone_kg) / in_kg
    slope_kg = float(np.polyfit(np.arange(last - first), mean_kg[window], 1)[0])
    drift = slope_kg * (last - first) / in_kg
    reason = _why_not_steady(imbalance, drift, last - first, held_kg[last], gone_kg)
    if reason:
        return SteadyState(0, cycles, reason, imbalance, drift)
    return SteadyState(first, last, "", imbalance, drift)


def hold_up_kg(fed_kg: Array, out_kg: Array, start_kg: float) -> Array:
    """Return what is in the machine at the (cycles + 1,) edges of the cycles."""
    return np.asarray(start_kg + np.concatenate([[0.0], np.cumsum(fed_kg - out_kg)]))


def find_truncation(values: Array) -> int:
    """Return how many of the first values to leave out: at most half of them, at least ``FEWEST_CYCLES``
    staying."""
    candidates = range(min(len(values) // 2, len(values) - FEWEST_CYCLES) + 1)
    errors = [float(values[d:].var()) / (len(values) - d) for d in candidates]
    return int(np.argmin(errors))


def _why_not_steady(imbalance: float, drift: float, cycles: int, held_kg: float, gone_kg: float) -> str:
    """Return why a state is not steady.  By Little's law, with more on the deck than left it, particles
    stay longer than the cycles last."""
    largest = 100 * LARGEST_IMBALANCE
    for what, value in (("in less out", imbalance), ("the growth of the hold-up", drift)):
        if abs(value) > LARGEST_IMBALANCE:
            share = f"{100 * value:+.1f} % of the feed over the last {cycles} cycles"
            return f"{what} is {share}; up to {largest:g} % counts as steady"
    if held_kg > gone_kg:
        return f"the last {cycles} cycles are shorter than the particles' residence time"
    return ""


@dataclass(frozen=True)
class Events:
    """What went in and out, and the whole cycles' ``edges_s``.  Particles of t = 0 are there at the start,
    not fed."""

    fed: EventTable
    removed: EventTable
    exits: Exits
    edges_s: Array

    @cached_property
    def balance_kg(self) -> tuple[Array, Array, float]:
        """What was fed and what left in each cycle, (cycles,) each, and what was there at the start."""
        later = self.fed.time_s > 0
        fed_kg = per_cycle(self.fed.time_s[later], self.fed.mass_kg[later], self.edges_s)[:, 0]
        out_kg = per_cycle(self.removed.time_s, self.removed.mass_kg, self.edges_s)[:, 0]
        return fed_kg, out_kg, float(self.fed.mass_kg[~later].sum())

    @cached_property
    def steady(self) -> SteadyState:
        """The cycles over which to average."""
        return find_steady_state(*self.balance_kg)

    @property
    def window(self) -> slice:
        """The same cycles."""
        return slice(self.steady.first, self.steady.last)

    @property
    def window_s(self) -> tuple[float, float]:
        """When they begin and end."""
        return float(self.edges_s[self.steady.first]), float(self.edges_s[self.steady.last])

    @property
    def left_in_window(self) -> Any:
        """(removed,) which of the particles left through an exit within them."""
        inside = within(self.removed.time_s, *self.window_s, float(self.edges_s[1]))
        return inside & (self.removed.exit != LOST)

    def figure(self, statistic: Callable[[Array], float], cycles: Array) -> Estimate:
        """Return ``statistic`` of sums of ``cycles`` (cycles, ...); with an interval if it is steady."""
        if self.steady.reason:
            value = statistic(cycles[self.window].sum(axis=0))
            return Estimate(float(value) if np.isfinite(value) else None)
        return estimate(statistic, batch_sums(cycles[self.window]))

    def ratio(self, part: Array, whole: Array) -> Estimate:
        """Return the sum of ``part`` over the sum of ``whole``, (cycles,) each."""
        return self.figure(lambda sums: sums[0] / sums[1], np.column_stack([part, whole]))

    def rate(self, per_cycle: Array) -> Estimate:
        """Return the rate of something summed per cycle (cycles,), per second."""
        return self.ratio(per_cycle, np.full(len(per_cycle), float(self.edges_s[1] - self.edges_s[0])))
