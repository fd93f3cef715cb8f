"""What was fed and what left, particle by particle and by cycles, and the steady state.

The steady state is found from the mass balance in two steps.  Where it may begin: the start-up to
leave out is the one that makes the mean hold-up of the rest most certain (marginal standard error
rule; White, Simulation 69, 1997, 323-334, doi 10.1177/003754979706900601).  Whether it is one: over
the rest, what goes out equals what comes in within 2 %, and so does a straight line through the
hold-up.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from orchestrator.output.cycles import cycle_numbers, within
from orchestrator.output.results.estimate import Estimate, batch_sums, estimate
from orchestrator.ports import Array, Indices
from orchestrator.ports.physics import sphere_mass_kg

LOST = -1
UNDERSIZE, OVERSIZE = "undersize", "oversize"


@dataclass(frozen=True)
class FedParticles:
    """Particles of t = 0 (with time 0) and those fed since; arrays (n,)."""

    id: Indices
    time_s: Array
    diameter_m: Array
    mass_kg: Array


@dataclass(frozen=True)
class RemovedParticles:
    """Particles that left; ``position_m`` (n, 3), ``exit`` (n,) a number, ``LOST`` = -1."""

    id: Indices
    time_s: Array
    position_m: Array
    diameter_m: Array
    mass_kg: Array
    exit: Indices


@dataclass(frozen=True)
class Exits:
    """Names and products ("undersize" or "oversize") of the exits, by number."""

    names: tuple[str, ...]
    products: tuple[str, ...]

    def of(self, product: str) -> Indices:
        """Returns the numbers of the exits of a product, in the case's order."""
        return np.array([i for i, own in enumerate(self.products) if own == product], dtype=int)


def read_events(history: Any) -> tuple[FedParticles, RemovedParticles, Exits] | None:
    """Returns what an open ``history.h5`` says; None if the run counted no particles in and out."""
    if "fed/id" not in history or "removed/id" not in history:
        return None
    fed, removed = history["fed"], history["removed"]
    exits = Exits(*(tuple(map(str, removed.attrs[key])) for key in ("names", "products")))
    return (
        FedParticles(fed["id"][:], fed["time_s"][:], fed["diameter_m"][:], _mass_kg(fed)),
        RemovedParticles(
            removed["id"][:],
            removed["time_s"][:],
            removed["position_m"][:],
            removed["diameter_m"][:],
            _mass_kg(removed),
            removed["exit"][:].astype(int),
        ),
        exits,
    )


def _mass_kg(table: Any) -> Array:
    return sphere_mass_kg(table["diameter_m"][:], table["density_kg_per_m3"][:])


def per_cycle(time_s: Array, mass_kg: Array, edges_s: Array, group: Indices, groups: int) -> Array:
    """Returns (cycles, groups): mass by cycle and group (a number from 0; others are not counted)."""
    cycle = cycle_numbers(time_s, float(edges_s[1] - edges_s[0]))
    counted = (cycle < len(edges_s) - 1) & (group >= 0) & (group < groups)
    table = np.zeros((len(edges_s) - 1, groups))
    np.add.at(table, (cycle[counted], group[counted]), mass_kg[counted])
    return table


FEWEST_CYCLES = 20
LARGEST_IMBALANCE = 0.02


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
    """Finds the steady state, where ``fed_kg`` and ``out_kg`` (cycles,) are the masses in each whole
    cycle, ``start_kg`` what is there at the first one's beginning."""
    cycles = len(fed_kg)
    feeding = np.flatnonzero(fed_kg)
    if not len(feeding):
        return SteadyState(0, cycles, "nothing is fed: a batch is never steady")
    last = int(feeding[-1]) + 1
    held_kg = start_kg + np.concatenate([[0.0], np.cumsum(fed_kg - out_kg)])
    if cycles - last > 1:
        end = f"the feed stops after cycle {last}"
    else:
        last, end = cycles, "the run ends"
    if last - feeding[0] < FEWEST_CYCLES:
        fed = f"only {last - int(feeding[0])} cycles are fed before {end}"
        return SteadyState(0, cycles, f"{fed}; {FEWEST_CYCLES} are needed")
    mean_kg = (held_kg[:last] + held_kg[1 : last + 1]) / 2
    first = find_truncation(mean_kg)
    window = slice(first, last)
    in_kg, gone_kg = float(fed_kg[window].sum()), float(out_kg[window].sum())
    imbalance = (in_kg - gone_kg) / in_kg
    slope_kg = float(np.polyfit(np.arange(last - first), mean_kg[window], 1)[0])
    drift = slope_kg * (last - first) / in_kg
    reason = _why_not(imbalance, drift, last - first, held_kg[last], gone_kg)
    if reason:
        return SteadyState(0, cycles, reason, imbalance, drift)
    return SteadyState(first, last, "", imbalance, drift)


def find_truncation(values: Array) -> int:
    """Returns how many of the first values to leave out: at most half of them, at least ``FEWEST_CYCLES``
    staying."""
    candidates = range(min(len(values) // 2, len(values) - FEWEST_CYCLES) + 1)
    errors = [float(values[d:].var()) / (len(values) - d) for d in candidates]
    return int(np.argmin(errors))


def _why_not(imbalance: float, drift: float, cycles: int, held_kg: float, gone_kg: float) -> str:
    """Little's law: with more on the deck than left it, they stay longer than the cycles last."""
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
    """What went in and out, the whole cycles' ``edges_s``, and the steady ones of them."""

    fed: FedParticles
    removed: RemovedParticles
    exits: Exits
    edges_s: Array
    steady: SteadyState

    @property
    def window(self) -> slice:
        """The cycles over which to average."""
        return slice(self.steady.first, self.steady.last)

    @property
    def lasting_s(self) -> float:
        """How long these are."""
        return float(self.edges_s[self.steady.last] - self.edges_s[self.steady.first])

    @property
    def counted(self) -> Any:
        """(removed,) which of the particles left through an exit within them."""
        start_s, end_s = (float(self.edges_s[edge]) for edge in (self.steady.first, self.steady.last))
        inside = within(self.removed.time_s, start_s, end_s, float(self.edges_s[1]))
        return inside & (self.removed.exit != LOST)

    def figure(self, statistic: Callable[[Array], float], cycles: Array) -> Estimate:
        """Returns ``statistic`` of sums of ``cycles`` (cycles, ...); with an interval if it is steady."""
        if self.steady.reason:
            value = statistic(cycles[self.window].sum(axis=0))
            return Estimate(float(value) if np.isfinite(value) else None)
        return estimate(statistic, batch_sums(cycles[self.window]))

    def rate(self, per_cycle: Array) -> Estimate:
        """Returns the rate of something summed per cycle (cycles,), per second."""
        length_s = float(self.edges_s[1] - self.edges_s[0])
        pairs = np.column_stack([per_cycle, np.full(len(per_cycle), length_s)])
        return self.figure(lambda sums: sums[0] / sums[1], pairs)


def balance_events(fed: FedParticles, removed: RemovedParticles, exits: Exits, edges_s: Array) -> Events:
    """Returns the events with the steady state found.  Particles of t = 0 are there at the start, not fed."""
    later = fed.time_s > 0
    fed_kg = sum_per_cycle(fed.time_s[later], fed.mass_kg[later], edges_s)
    out_kg = sum_per_cycle(removed.time_s, removed.mass_kg, edges_s)
    start_kg = float(fed.mass_kg[~later].sum())
    return Events(fed, removed, exits, edges_s, find_steady_state(fed_kg, out_kg, start_kg))


def sum_per_cycle(time_s: Array, mass_kg: Array, edges_s: Array) -> Array:
    """Returns the (cycles,) mass in each of the cycles."""
    return per_cycle(time_s, mass_kg, edges_s, np.zeros(len(time_s), dtype=int), 1)[:, 0]
