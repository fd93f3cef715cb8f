"""The bed on the deck: depth, velocity, hold-up, residence, passing rate and retained particles."""

from __future__ import annotations

import numpy as np

from orchestrator.case.deck.line import DeckLine
from orchestrator.case.deck.openings import openings_m
from orchestrator.case.deck.panels import single_panels
from orchestrator.figures.estimate import Estimate
from orchestrator.figures.material import Bed, BulkMean, Held, Passing, Profile, Transport
from orchestrator.output.cycles import ROUNDING, cycle_numbers
from orchestrator.output.records.deck_record import HELD_CYCLES, bins_m
from orchestrator.output.records.history import COLUMNS
from orchestrator.output.results.estimate import IntervalOf, mean_by_cycles, ratio_by_cycles, share
from orchestrator.output.results.events import OVERSIZE, UNDERSIZE, Events, EventTable, per_cycle
from orchestrator.output.results.run_reader import RunReader
from orchestrator.ports import Array


def bed_metrics(
    run: RunReader, start_s: float, end_s: float, is_steady: bool, interval_of: IntervalOf
) -> Bed:
    """Return the bed's metrics over the output times from ``start_s`` to ``end_s`` (at least one).

    All metrics are means over time.  A bin or a deck without particles counts with no mass and a depth of
    0.  ``mean_depth_m`` is the mean along the deck, ``largest_depth_m`` the largest along it at each time.
    Velocities are means by mass.  Only a steady bed has confidence intervals.
    """
    time_s = run.read("profile/time_s")
    window = run.output_rows("profile", start_s, end_s)
    mass_kg, velocity_m_per_s, depth_m = (
        np.nan_to_num(run.read(f"profile/{name}")[window])
        for name in ("mass_kg", "velocity_m_per_s", "depth_m")
    )
    along_m = run.read("profile/along_m")[0]
    cycle = cycle_numbers(time_s[window], run.cycle_s, start_s)
    momentum = mass_kg * velocity_m_per_s
    on_deck_kg, in_bin_kg = mass_kg.sum(axis=1), mass_kg.sum(axis=0)
    nowhere = np.full(len(in_bin_kg), np.nan)
    return Bed(
        output_times=int(window.sum()),
        particles=float(run.read("bed/particles")[run.output_rows("bed", start_s, end_s)].mean()),
        on_deck_kg=mean_by_cycles(on_deck_kg, cycle, is_steady, interval_of),
        load_kg_per_m2=mean_by_cycles(on_deck_kg / deck_area_m2(run), cycle, is_steady, interval_of),
        velocity_m_per_s=ratio_by_cycles(momentum.sum(axis=1), on_deck_kg, cycle, is_steady, interval_of),
        mean_depth_m=mean_by_cycles(depth_m.mean(axis=1), cycle, is_steady, interval_of),
        largest_depth_m=mean_by_cycles(depth_m.max(axis=1), cycle, is_steady, interval_of),
        profile=Profile(
            along_m=along_m,
            mass_kg_per_m=mass_kg.mean(axis=0) / (along_m[1] - along_m[0]),
            velocity_m_per_s=np.divide(momentum.sum(axis=0), in_bin_kg, out=nowhere, where=in_bin_kg > 0),
            depth_m=depth_m.mean(axis=0),
        ),
    )


def deck_area_m2(run: RunReader) -> float:
    """Return the area of the deck, cross beams included: its length times the mean width of the panels, of
    which longer ones count more.

    Raises KeyError if the panels form no deck.
    """
    along_m = run.read("profile/along_m")[0]
    length_m = len(along_m) * (along_m[1] - along_m[0])
    panels = [panel.rectangle for panel in single_panels(run.case)]
    width_m = np.average([at.width_m for at in panels], weights=[at.length_m for at in panels])
    return float(length_m * width_m)


def retained_metrics(
    run: RunReader, start_s: float, end_s: float, is_steady: bool, interval_of: IntervalOf
) -> Held:
    """Return the openings, and means of what sticks and of what they hold over the output times of a window.

    Those of the run's first cycles, in which no particle can have lain for long enough, do not count.
    """
    openings = len(openings_m(run.case))
    names = {"stickers": "stickers", "sticking_kg": "mass_kg", "blinded_openings": "openings"}
    window = run.output_rows("held", start_s, end_s)
    time_s = run.read("held/time_s")
    window &= time_s >= time_s[0] + (HELD_CYCLES - ROUNDING) * run.cycle_s
    if not window.any():
        shares = ("pegged_percent", "blinded_percent")
        return Held(openings=openings, **dict.fromkeys([*names, *shares], Estimate(None)))
    cycle = cycle_numbers(time_s[window], run.cycle_s, start_s)
    pegged_kg, blinded = (run.read(f"held/{series}")[window] for series in ("pegged_kg", "openings"))
    on_deck_kg = np.nan_to_num(run.read("profile/mass_kg")[window]).sum(axis=1)
    every_opening = np.full(len(cycle), float(openings))
    means = {
        name: mean_by_cycles(run.read(f"held/{series}")[window], cycle, is_steady, interval_of)
        for name, series in names.items()
    }
    return Held(
        openings=openings,
        pegged_percent=ratio_by_cycles(100.0 * pegged_kg, on_deck_kg, cycle, is_steady, interval_of),
        blinded_percent=ratio_by_cycles(100.0 * blinded, every_opening, cycle, is_steady, interval_of),
        **means,
    )


def residence_s(fed: EventTable, removed: EventTable) -> Array:
    """Return the time (removed,) in s from entering to leaving; NaN for particles that were never fed."""
    _, known, place = np.intersect1d(removed.id, fed.id, return_indices=True)
    entered_s = np.full(len(removed.id), np.nan)
    entered_s[known] = fed.time_s[place]
    return np.asarray(removed.time_s - entered_s)


def passing_kg_per_s_m(along_m: Array, mass_kg: Array, edges_m: Array, lasting_s: float) -> Array:
    """Return the mass (bins,) passed per length of deck and time.

    A particle outside ``edges_m`` counts to the nearest bin.
    """
    inside = np.clip(along_m, edges_m[0], edges_m[-1])
    passed = np.histogram(inside, edges_m, weights=mass_kg)[0]
    return np.asarray(passed / np.diff(edges_m) / lasting_s)


def transport(events: Events, deck: DeckLine | None) -> Transport:
    """Return the residence time of the oversize, and the passing rate of the undersize along the deck.

    Nobody knows when, and where, the particles of a bed at the start entered, so that they do not count.
    In a steady run, residence times begin when the last of them has left, since those that stay briefly
    leave first.
    """
    removed, counted = events.removed, events.left_in_window
    stay_s = residence_s(events.fed, removed)
    over = counted & np.isin(removed.exit, events.exits.of(OVERSIZE)) & np.isfinite(stay_s)
    at_start = over & np.isin(removed.id, events.fed.id[events.fed.time_s <= 0])
    over &= ~at_start
    if not events.steady.reason:
        over &= removed.time_s > removed.time_s[at_start].max(initial=0.0)
    sums = np.hstack(
        [
            per_cycle(removed.time_s[over], weight[over], events.edges_s)
            for weight in (removed.mass_kg * stay_s, removed.mass_kg)
        ]
    )
    residence = events.figure(lambda s: share(s[0], s[1]), sums)
    if deck is None:
        return Transport(residence_s=residence)
    length_m = deck.length_m
    edges_m = bins_m(deck)
    under = counted & np.isin(removed.exit, events.exits.of(UNDERSIZE))
    station_m = np.interp(removed.position_m[under] @ deck.along, deck.over_m, deck.station_m)
    start_s, end_s = events.window_s
    rate = passing_kg_per_s_m(station_m, removed.mass_kg[under], edges_m, end_s - start_s)
    return Transport(
        residence_s=residence,
        residence_velocity_m_per_s=events.figure(lambda s: length_m * share(s[1], s[0]), sums),
        passing=Passing(along_m=(edges_m[1:] + edges_m[:-1]) / 2, rate_kg_per_s_m=rate),
    )


def mean_bulk(run: RunReader) -> dict[str, BulkMean] | None:
    """Return the means in the second half of the run for each box of ``[bulk]``; None without boxes."""
    boxes = {}
    for name in run.names("bulk"):
        late = run.read(f"bulk/{name}/time_s") > run.end_s / 2
        mass_kg, density_kg_per_m3, slope_deg = (
            run.read(f"bulk/{name}/{key}")[late] for key in COLUMNS["bulk"]
        )
        known_deg = slope_deg[np.isfinite(slope_deg)]
        boxes[name] = BulkMean(
            mass_kg=float(mass_kg.mean()),
            density_kg_per_m3=float(density_kg_per_m3.mean()),
            slope_deg=float(known_deg.mean()) if len(known_deg) else None,
        )
    return boxes or None
