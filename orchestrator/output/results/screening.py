"""The screening results: rates, efficiencies, and partition curve.

``out_kg`` (exits, 2) is always the mass that left through each exit, fine (below the cut size) and
coarse.  The feed is the sum over all exits, since the mass that a steady deck gets also leaves it.
In shares of the separation a particle counts with the mass for which it stands (``Events.left_kg``); rates
and the hold-up are those of the particles themselves.
docs/theory/screening.md has the definitions.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from orchestrator.figures.estimate import Estimate
from orchestrator.figures.material import FlowsInTime, Partition, Screening, Section
from orchestrator.output.cycles import within
from orchestrator.output.results.estimate import chance, controlled, counting_deviation, share, unknown
from orchestrator.output.results.events import LOST, OVERSIZE, UNDERSIZE, Events, Exits, per_cycle
from orchestrator.ports import Array, Indices

FINE, COARSE = 0, 1
CLASSES, FEWEST_IN_CLASS = 12, 10


def fine_or_coarse(size_m: Array, cut_m: float) -> Indices:
    """Return ``FINE`` below the cut size, else ``COARSE``."""
    return np.where(size_m < cut_m, FINE, COARSE)


def placements(out_kg: Array, exits: Exits) -> dict[str, float]:
    """Return the shares of the whole deck by name; NaN where the mass to share is zero.

    ``fine_placement`` is the share of the feed's fines that pass (the recovery of undersize), and
    ``coarse_placement`` is the share of the feed's coarse that is held back.  ``efficiency`` is their sum
    less one: 1 for a perfect screen, and 0 for a mere splitter.  Without coarse particles none passes, and it
    is the fine placement.  ``misplaced`` is the mass of fines in the
    oversize and of coarse in the undersize over the feed.  ``fines_in_oversize`` is the fine share of the
    oversize.
    """
    under, over = (out_kg[exits.of(product)].sum(axis=0) for product in (UNDERSIZE, OVERSIZE))
    feed_kg = float(out_kg.sum())
    fine = share(under[FINE], under[FINE] + over[FINE])
    coarse = share(over[COARSE], under[COARSE] + over[COARSE])
    return {
        "oversize_yield": share(float(over.sum()), feed_kg),
        "efficiency": fine + (1.0 if math.isnan(coarse) else coarse) - 1.0,
        "fine_placement": fine,
        "coarse_placement": coarse,
        "misplaced": share(over[FINE] + under[COARSE], feed_kg),
        "fines_in_oversize": share(over[FINE], float(over.sum())),
    }


def counting_deviations(mass_kg: Array, group: Indices, exits: Exits) -> dict[str, float]:
    """Return the standard deviations by counting of ``placements``, from the particles that left.

    ``mass_kg`` and ``group`` are (particles,); a group is twice the exit's number, plus ``COARSE`` or
    ``FINE``.  The efficiency is the sum of two shares of different particles, so that their variances add.
    """
    out_kg = np.bincount(group, mass_kg, 2 * len(exits.names)).astype(float).reshape(-1, 2)
    shares, fine = placements(out_kg, exits), group % 2 == FINE
    over = np.isin(group // 2, exits.of(OVERSIZE))
    of = {"fine_placement": fine, "coarse_placement": ~fine, "fines_in_oversize": over}
    all_of_them = np.ones(len(group), dtype=bool)
    table = {
        name: counting_deviation(share, mass_kg[of.get(name, all_of_them)]) for name, share in shares.items()
    }
    coarse = table["coarse_placement"]
    table["efficiency"] = math.hypot(table["fine_placement"], 0.0 if math.isnan(coarse) else coarse)
    return table


def section_shares(out_kg: Array, sections: Indices, place: int) -> dict[str, float]:
    """Return the shares of the section at ``place`` of ``sections`` (numbers of exits).

    ``yield`` is the mass that passes in the section over the feed.  ``cumulative_efficiency`` is the fines
    passed up to its end over the feed's fines.  ``local_efficiency`` is the fines passed in it over the
    fines that arrive there.
    """
    fines_kg, passed_kg = float(out_kg[:, FINE].sum()), out_kg[sections, FINE]
    return {
        "yield": share(float(out_kg[sections[place]].sum()), float(out_kg.sum())),
        "cumulative_efficiency": share(float(passed_kg[: place + 1].sum()), fines_kg),
        "local_efficiency": share(passed_kg[place], fines_kg - float(passed_kg[:place].sum())),
    }


def size_classes(size_m: Array, cut_m: float | None) -> Array:
    """Return the edges (classes + 1,) of size classes, spaced evenly in the logarithm.

    An edge lies at a cut size within the range.  Neighbouring classes are joined until each has at least
    ``FEWEST_IN_CLASS`` particles; classes next to the cut size may have fewer.
    """
    low, high = float(size_m.min()), float(size_m.max())
    if high <= low * (1 + 1e-9):
        return np.array([low * 0.999, high * 1.001])
    edges = np.geomspace(low * (1 - 1e-9), high * (1 + 1e-9), CLASSES + 1)
    if cut_m is not None and low < cut_m < high:
        edges[1 + np.abs(np.log(edges[1:-1] / cut_m)).argmin()] = cut_m
    counts = np.histogram(size_m, edges)[0]
    class_edges, inside = [edges[0]], 0
    for edge, count in zip(edges[1:], counts, strict=True):
        inside += count
        if inside >= FEWEST_IN_CLASS or edge == cut_m:
            class_edges.append(edge)
            inside = 0
    if class_edges[-1] < edges[-1]:
        if len(class_edges) > 1 and class_edges[-1] != cut_m:  # too few particles for a class of their own
            class_edges.pop()
        class_edges.append(edges[-1])
    return np.array(class_edges)


def partition(under_kg: Array, over_kg: Array) -> Array:
    """Return the share (classes,) of each class that goes to the oversize; NaN for an empty class."""
    all_kg = under_kg + over_kg
    return np.divide(over_kg, all_kg, out=np.full(len(all_kg), np.nan), where=all_kg > 0)


def size_at(share: float, size_m: Array, partition_number: Array) -> float:
    """Return the size at which the partition curve first rises through ``share``; NaN if it never does.

    The curve is linear between the mean sizes (classes,) of the classes.
    """
    there = np.isfinite(partition_number)
    size, number = size_m[there], partition_number[there]
    rises = np.flatnonzero((number[:-1] < share) & (number[1:] >= share))
    if not len(rises):
        return float("nan")
    i = rises[0]
    part = (share - number[i]) / (number[i + 1] - number[i])
    return float(size[i] + part * (size[i + 1] - size[i]))


def cut_and_spread(size_m: Array, number: Array) -> tuple[float, float]:
    """Return d50 and the probable error Ep = (d75 - d25) / 2; NaN if the curve does not reach a share."""
    d25, d50, d75 = (size_at(share, size_m, number) for share in (0.25, 0.5, 0.75))
    return d50, (d75 - d25) / 2


def screening(events: Events, cut_m: float | None) -> Screening:
    """Return every metric that follows from the particles that came and left."""
    removed, counted = events.removed, events.left_in_window
    group, count = _way_and_kind(events, cut_m), len(events.exits.names)
    out_kg, flow_kg = (
        events.sums(kg, group, 2 * count).reshape(-1, count, 2) for kg in (events.left_kg, removed.mass_kg)
    )
    rates, placed = _rates(events, flow_kg), shares(events, cut_m)
    return Screening(
        cut_size_m=cut_m,
        lost_particles=int((removed.exit == LOST).sum()),
        particles=int(counted.sum()),
        fine_particles=None if cut_m is None else int((counted & (group % 2 == FINE)).sum()),
        feed_kg_per_s=rates["feed"],
        undersize_kg_per_s=rates[UNDERSIZE],
        oversize_kg_per_s=rates[OVERSIZE],
        hold_up_kg=_hold_up(events),
        in_time=_flows_in_time(events, flow_kg),
        oversize_yield_percent=placed["oversize_yield"],
        efficiency_percent=placed.get("efficiency"),
        fine_placement_percent=placed.get("fine_placement"),
        coarse_placement_percent=placed.get("coarse_placement"),
        misplaced_percent=placed.get("misplaced"),
        fines_in_oversize_percent=placed.get("fines_in_oversize"),
        recovered_percent=None if cut_m is None else _recovery(events, out_kg, cut_m),
        sections=_sections(events, out_kg, cut_m is not None),
        partition=_partition(events, cut_m),
    )


def shares(events: Events, cut_m: float | None) -> dict[str, Estimate]:
    """Return the shares of the separation in per cent by the names of ``placements``; without a cut size, the
    yield of the oversize alone."""
    exits, counted, group = events.exits, events.left_in_window, _way_and_kind(events, cut_m)
    count = len(exits.names)
    out_kg = events.sums(events.left_kg, group, 2 * count).reshape(-1, count, 2)
    chance = counting_deviations(events.left_kg[counted], group[counted], exits)

    def share_of(name: str) -> Estimate:
        found = events.figure(lambda kg: 100.0 * placements(kg, exits)[name], out_kg)
        return replace(found, counting=100.0 * chance[name] if np.isfinite(chance[name]) else None)

    return {name: share_of(name) for name in (chance if cut_m is not None else ("oversize_yield",))}


def _way_and_kind(events: Events, cut_m: float | None) -> Indices:
    """Return a number (removed,) for each particle that left: twice its exit's, plus ``COARSE`` or ``FINE``;
    negative for those that are lost."""
    removed = events.removed
    fine = fine_or_coarse(removed.sieve_size_m, cut_m or np.inf)
    return np.where(removed.exit == LOST, -2 + fine, 2 * removed.exit + fine)


def _recovery(events: Events, out_kg: Array, cut_m: float) -> Estimate:
    """Return the fines passed over the fines that came in.

    Other than in the fine placement, fines that stay on the deck count as not recovered.  In a steady run,
    those that are present at t = 0 did not come, as in the balance.
    """
    fed = events.fed
    is_fine = fine_or_coarse(fed.sieve_size_m, cut_m) == FINE
    came = np.where(is_fine & ((fed.time_s > 0) | bool(events.steady.reason)), 0, -1)
    came_kg = per_cycle(fed.time_s, events.came_kg, events.edges_s, came)[:, 0]
    passed_kg = out_kg[:, events.exits.of(UNDERSIZE), FINE].sum(axis=1)
    pairs = np.column_stack([passed_kg, came_kg])
    estimate = events.figure(lambda sums: 100.0 * share(sums[0], sums[1]), pairs)
    mass_kg = events.came_kg[(came == 0) & within(fed.time_s, *events.window_s, float(events.edges_s[1]))]
    if estimate.value is None or not len(mass_kg):
        return estimate
    return replace(estimate, counting=100.0 * counting_deviation(estimate.value / 100.0, mass_kg))


def _flows(events: Events, out_kg: Array) -> dict[str, Array]:
    """Return the masses of each cycle by the name of the flow."""
    products = {p: out_kg[:, events.exits.of(p)].sum(axis=(1, 2)) for p in (UNDERSIZE, OVERSIZE)}
    return {"feed": events.balance.fed_kg, **products}


def _rates(events: Events, out_kg: Array) -> dict[str, Estimate]:
    """Return the mean mass rates by the name of the flow."""
    return {
        name: events.rate(kg, controlled if name == "feed" else None)
        for name, kg in _flows(events, out_kg).items()
    }


def _hold_up(events: Events) -> Estimate:
    """Return the mean hold-up, which is the mass that came and has not left."""
    held_kg = events.balance.mean_held_kg
    return events.ratio(held_kg, np.ones(len(held_kg)), chance if events.has_interval else unknown)


def _flows_in_time(events: Events, out_kg: Array) -> FlowsInTime:
    """Return the mass rates of each cycle, and the hold-up at its end."""
    length_s = np.diff(events.edges_s)
    rates = {f"{name}_kg_per_s": kg / length_s for name, kg in _flows(events, out_kg).items()}
    return FlowsInTime(time_s=events.edges_s[1:], hold_up_kg=events.balance.held_kg[1:], **rates)


def _sections(events: Events, out_kg: Array, divided: bool) -> list[Section]:
    """Return the shares of every exit for undersize, in the case's order."""
    numbers = events.exits.of(UNDERSIZE)
    names = ("yield", "cumulative_efficiency", "local_efficiency") if divided else ("yield",)

    def estimate(place: int, name: str) -> Estimate:
        return events.figure(lambda kg: 100.0 * section_shares(kg, numbers, place)[name], out_kg)

    return [
        Section(
            exit=events.exits.names[number], **{f"{name}_percent": estimate(place, name) for name in names}
        )
        for place, number in enumerate(numbers)
    ]


def _partition(events: Events, cut_m: float | None) -> Partition | None:
    """Return the size classes with their partition numbers, d50 and Ep; None if nothing has left."""
    removed, counted = events.removed, events.left_in_window
    if not counted.any():
        return None
    edges = size_classes(removed.sieve_size_m[counted], cut_m)
    classes = len(edges) - 1
    size = np.clip(np.searchsorted(edges, removed.sieve_size_m, side="right") - 1, 0, classes - 1)
    over = np.isin(removed.exit, events.exits.of(OVERSIZE))
    group = np.where(removed.exit == LOST, -1, 2 * size + over)
    mass_kg = events.sums(events.left_kg, group, 2 * classes).reshape(-1, classes, 2)
    number = np.bincount(size[counted], minlength=classes)
    summed_m = np.bincount(size[counted], removed.sieve_size_m[counted], classes)
    mean_m = np.divide(summed_m, number, out=np.full(classes, np.nan), where=number > 0)
    total_kg = mass_kg[events.window].sum(axis=0)
    return Partition(
        edges_m=edges,
        mean_m=mean_m,
        particles=number.astype(float),
        feed_percent=100 * total_kg.sum(axis=1) / total_kg.sum(),
        oversize_percent=100 * partition(*total_kg.T),
        d50_m=events.figure(lambda kg: cut_and_spread(mean_m, partition(*kg.T))[0], mass_kg),
        ep_m=events.figure(lambda kg: cut_and_spread(mean_m, partition(*kg.T))[1], mass_kg),
    )
