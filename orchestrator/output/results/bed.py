"""The bed on the deck: depth, velocity, hold-up and residence, where it passes, what is stuck."""

from __future__ import annotations

from typing import Any

import numpy as np

from orchestrator.case.deck.line import DeckLine
from orchestrator.output.cycles import cycle_numbers, within
from orchestrator.output.records.deck_record import bins_m
from orchestrator.output.results.estimate import Estimate, batch_sums, estimate, mean
from orchestrator.output.results.events import (
    OVERSIZE,
    UNDERSIZE,
    Events,
    FedParticles,
    RemovedParticles,
    per_cycle,
)
from orchestrator.output.results.run_reader import RunReader
from orchestrator.output.results.screening import share
from orchestrator.ports import Array, Indices


def bed_metrics(run: RunReader, start_s: float, end_s: float, is_steady: bool) -> dict[str, Any]:
    """Returns the bed's metrics over the output times from ``start_s`` to ``end_s``, of which there must
    be one; intervals only where it is steady.

    All are means over time, in which a bin or a deck without particles has no mass and a depth of
    0; velocities are means over the mass, to which an empty one gives nothing.
    """
    time = run.read("profile/time_s")
    window = within(time, start_s, end_s, run.cycle_s)
    mass, velocity, depth = (
        np.nan_to_num(run.read(f"profile/{name}")[window])
        for name in ("mass_kg", "velocity_m_per_s", "depth_m")
    )
    along = run.read("profile/along_m")[0]
    cycle = cycle_numbers(time[window], run.cycle_s, start_s)
    kg, momentum = mass.sum(axis=1), (mass * velocity).sum(axis=1)
    total = mass.sum(axis=0)
    present = run.read_between("bed", "particles", start_s, end_s)
    return {
        "output_times": int(window.sum()),
        "particles": float(present.mean()),
        "on_deck_kg": mean_by_cycles(kg, cycle, is_steady),
        "velocity_m_per_s": ratio_by_cycles(momentum, kg, cycle, is_steady),
        "largest_depth_m": mean_by_cycles(depth.max(axis=1), cycle, is_steady),
        "profile": {
            "along_m": along,
            "mass_kg_per_m": mass.mean(axis=0) / (along[1] - along[0]),
            "velocity_m_per_s": np.divide(
                (mass * velocity).sum(axis=0), total, out=np.full(len(total), np.nan), where=total > 0
            ),
            "depth_m": depth.mean(axis=0),
        },
    }


def retained_metrics(run: RunReader, start_s: float, end_s: float, is_steady: bool) -> dict[str, Any]:
    """Returns stickers and blinded openings over the same times."""
    time = run.read("held/time_s")
    window = within(time, start_s, end_s, run.cycle_s)
    cycle = cycle_numbers(time[window], run.cycle_s, start_s)
    names = {"stickers": "stickers", "sticking_kg": "mass_kg", "blinded_openings": "openings"}
    return {
        name: mean_by_cycles(run.read(f"held/{series}")[window], cycle, is_steady)
        for name, series in names.items()
    }


def mean_by_cycles(values: Array, cycle: Indices, is_steady: bool) -> Estimate:
    """Returns the mean of values at output times, with its interval from cycles."""
    if not is_steady:
        return Estimate(float(values.mean()))
    which, index = np.unique(cycle, return_inverse=True)
    sums = np.bincount(index, values, len(which)) / np.bincount(index)
    return mean(sums)


def ratio_by_cycles(part: Array, whole: Array, cycle: Indices, is_steady: bool) -> Estimate:
    """Returns the sum of ``part`` over the sum of ``whole``, both at output times; None where that is 0."""
    which, index = np.unique(cycle, return_inverse=True)
    sums = np.array([np.bincount(index, one, len(which)) for one in (part, whole)], float).T
    if not is_steady:
        return Estimate(share(*sums.sum(axis=0)))
    return estimate(lambda total: share(*total), batch_sums(sums))


def residence_s(fed: FedParticles, removed: RemovedParticles) -> Array:
    """Returns the (removed,) time from entering to leaving; NaN for particles that were never fed."""
    _, known, place = np.intersect1d(removed.id, fed.id, return_indices=True)
    entered = np.full(len(removed.id), np.nan)
    entered[known] = fed.time_s[place]
    return np.asarray(removed.time_s - entered)


def passing_kg_per_s_m(along_m: Array, mass_kg: Array, edges_m: Array, lasting_s: float) -> Array:
    """Returns the (bins,) mass passed per length of deck and time; what is outside ``edges_m`` counts to
    the nearest bin."""
    inside = np.clip(along_m, edges_m[0], edges_m[-1])
    passed = np.histogram(inside, edges_m, weights=mass_kg)[0]
    return np.asarray(passed / np.diff(edges_m) / lasting_s)


def transport(events: Events, deck: DeckLine | None) -> dict[str, Any]:
    """Returns the residence of the oversize, and where along the deck the undersize passes."""
    removed, counted = events.removed, events.counted
    over = counted & np.isin(removed.exit, events.exits.of(OVERSIZE))
    stay = residence_s(events.fed, removed)
    over &= np.isfinite(stay)
    sums = per_cycle(
        np.tile(removed.time_s[over], 2),
        np.concatenate([(removed.mass_kg * stay)[over], removed.mass_kg[over]]),
        events.edges_s,
        np.repeat([0, 1], int(over.sum())),
        2,
    )
    table: dict[str, Any] = {"residence_s": events.figure(lambda s: share(s[0], s[1]), sums)}
    if deck is not None:
        length = deck.length_m
        table["residence_velocity_m_per_s"] = events.figure(lambda s: length * share(s[1], s[0]), sums)
        edges = bins_m(deck)
        under = counted & np.isin(removed.exit, events.exits.of(UNDERSIZE))
        station = np.interp(removed.position_m[under] @ deck.along, deck.over_m, deck.station_m)
        table["passing"] = {
            "along_m": (edges[1:] + edges[:-1]) / 2,
            "rate_kg_per_s_m": passing_kg_per_s_m(station, removed.mass_kg[under], edges, events.lasting_s),
        }
    return table
