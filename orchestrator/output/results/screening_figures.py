"""Screening figures of a run: how much is separated, how well, and where."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from orchestrator.output.results import placement
from orchestrator.output.results.estimate import Estimate
from orchestrator.output.results.events import LOST, OVERSIZE, UNDERSIZE, per_cycle
from orchestrator.output.results.partition import cut_and_spread, partition, size_classes
from orchestrator.output.results.steady_events import Events, summed
from orchestrator.ports import Array


def screening(events: Events, cut_m: float | None) -> dict[str, Any]:
    """Every figure that needs no more than what went in and out."""
    removed, exits = events.removed, events.exits
    fine = placement.fine_or_coarse(removed.diameter_m, cut_m or np.inf)
    group = np.where(removed.exit == LOST, -1, 2 * removed.exit + fine)
    count = len(exits.names)
    out = per_cycle(removed.time_s, removed.mass_kg, events.edges_s, group, 2 * count)
    out = out.reshape(-1, count, 2)
    lost = int((removed.exit == LOST).sum())
    counted = events.counted
    figures: dict[str, Any] = {
        "cut_size_m": cut_m,
        "lost_particles": lost,
        "particles": int(counted.sum()),
        "fine_particles": int((counted & (fine == placement.FINE)).sum()),
    }
    figures |= _flows(events, out)
    yields: dict[str, Callable[..., float]] = {"oversize_yield": placement.oversize_yield}
    if cut_m is not None:
        yields |= {
            "efficiency": placement.efficiency,
            "fine_placement": placement.fine_placement,
            "coarse_placement": placement.coarse_placement,
            "misplaced": placement.misplaced,
            "fines_in_oversize": placement.fines_in_oversize,
        }
    for name, share in yields.items():
        figures[f"{name}_percent"] = events.figure(partial(_percent, share, exits=exits), out)
    if cut_m is not None:
        figures["recovered_percent"] = _recovered(events, out, cut_m)
    figures["sections"] = _sections(events, out, cut_m is not None)
    figures["partition"] = _partition(events, cut_m)
    return figures


def _percent(share: Callable[..., float], out_kg: Array, **more: Any) -> float:
    return 100.0 * share(out_kg, **more)


def _recovered(events: Events, out: Array, cut_m: float) -> Estimate:
    """Fines passed over fines that came in: unlike the fine placement, fines that stay on the
    deck count as not recovered."""
    fed = events.fed
    came = np.where(placement.fine_or_coarse(fed.diameter_m, cut_m) == placement.FINE, 0, -1)
    came_kg = per_cycle(fed.time_s, fed.mass_kg, events.edges_s, came, 1)[:, 0]
    passed_kg = out[:, events.exits.of(UNDERSIZE), placement.FINE].sum(axis=1)
    pairs = np.column_stack([passed_kg, came_kg])
    return events.figure(lambda sums: 100.0 * placement.share(sums[0], sums[1]), pairs)


def _flows(events: Events, out: Array) -> dict[str, Any]:
    """Mass rates; ``hold_up_kg`` is all that was fed and has not left."""
    fed, removed, edges_s = events.fed, events.removed, events.edges_s
    fed_kg = summed(fed.time_s, np.where(fed.time_s > 0, fed.mass_kg, 0.0), edges_s)
    held = float(fed.mass_kg[fed.time_s <= 0].sum()) + np.concatenate(
        [[0.0], np.cumsum(fed_kg - summed(removed.time_s, removed.mass_kg, edges_s))]
    )
    mean_kg = np.column_stack([(held[1:] + held[:-1]) / 2, np.ones(len(held) - 1)])
    length_s = np.diff(edges_s)
    products = {p: out[:, events.exits.of(p)].sum(axis=(1, 2)) for p in (UNDERSIZE, OVERSIZE)}
    return {
        "feed_kg_per_s": events.rate(fed_kg),
        **{f"{name}_kg_per_s": events.rate(kg) for name, kg in products.items()},
        "hold_up_kg": events.figure(lambda sums: sums[0] / sums[1], mean_kg),
        "in_time": {
            "time_s": edges_s[1:],
            "feed_kg_per_s": fed_kg / length_s,
            **{f"{name}_kg_per_s": kg / length_s for name, kg in products.items()},
            "hold_up_kg": held[1:],
        },
    }


def _sections(events: Events, out: Array, divided: bool) -> list[dict[str, Any]]:
    """Of every exit for undersize, in the case's order."""
    numbers = events.exits.of(UNDERSIZE)
    rows = []
    for place, exit_number in enumerate(numbers):
        shares: dict[str, Callable[[Array], float]] = {
            "yield": partial(placement.section_yield, section=int(exit_number))
        }
        if divided:
            shares["cumulative_efficiency"] = partial(
                placement.cumulative_efficiency, sections=numbers, last=place
            )
            shares["local_efficiency"] = partial(placement.local_efficiency, sections=numbers, section=place)
        row: dict[str, Any] = {"exit": events.exits.names[exit_number]}
        for name, share in shares.items():
            row[f"{name}_percent"] = events.figure(partial(_percent, share), out)
        rows.append(row)
    return rows


def _partition(events: Events, cut_m: float | None) -> dict[str, Any] | None:
    """Classes, partition numbers, d50 and Ep; None as long as nothing has left."""
    removed, counted = events.removed, events.counted
    if not counted.any():
        return None
    edges = size_classes(removed.diameter_m[counted], cut_m)
    classes = len(edges) - 1
    size = np.clip(np.searchsorted(edges, removed.diameter_m, side="right") - 1, 0, classes - 1)
    over = np.isin(removed.exit, events.exits.of(OVERSIZE))
    group = np.where(removed.exit == LOST, -1, 2 * size + over)
    mass = per_cycle(removed.time_s, removed.mass_kg, events.edges_s, group, 2 * classes)
    mass = mass.reshape(-1, classes, 2)
    number = np.bincount(size[counted], minlength=classes)
    summed = np.bincount(size[counted], removed.diameter_m[counted], classes)
    mean_m = np.divide(summed, number, out=np.full(classes, np.nan), where=number > 0)
    total = mass[events.window].sum(axis=0)
    d50 = events.figure(lambda s: cut_and_spread(mean_m, partition(s[:, 0], s[:, 1]))[0], mass)
    spread = events.figure(lambda s: cut_and_spread(mean_m, partition(s[:, 0], s[:, 1]))[1], mass)
    return {
        "edges_m": edges,
        "mean_m": mean_m,
        "particles": number,
        "feed_percent": 100 * total.sum(axis=1) / total.sum(),
        "oversize_percent": 100 * partition(total[:, 0], total[:, 1]),
        "d50_m": d50,
        "ep_m": spread,
    }
