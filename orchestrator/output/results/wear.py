"""Wear of the panels: how deep in an hour, where, and how long they last."""

from __future__ import annotations

from typing import Any

import numpy as np

from orchestrator.case.deck.line import DeckLine
from orchestrator.case.deck.panels import single_panels
from orchestrator.output.cycles import cycle_numbers
from orchestrator.output.results.bed import mean_by_cycles
from orchestrator.output.results.run_reader import RunReader
from orchestrator.ports import Array

HOUR_S = 3600.0


def wear_metrics(
    run: RunReader, start_s: float, end_s: float, is_steady: bool, deck: DeckLine | None
) -> dict[str, Any] | None:
    """Returns the wear from the output times from ``start_s`` to ``end_s``; intervals only where it is
    steady. None if fewer than two output times lie there."""
    names = [panel.name for panel in single_panels(run.case)]
    time = run.read(f"wear/{names[0]}/time_s")
    there = np.flatnonzero((time >= start_s - 1e-9) & (time <= end_s + 1e-9))
    if len(there) < 2:
        return None
    first, last = int(there[0]), int(there[-1])
    span = slice(first, last + 1)
    cycle = cycle_numbers(time[span][1:], run.cycle_s, float(time[first]))
    panels, rates = {}, []
    for panel in single_panels(run.case):
        mean_m, depth_m = (run.read(f"wear/{panel.name}/{name}") for name in ("mean_m", "depth_m"))
        hours = (time[last] - time[first]) / HOUR_S
        depth_m_per_h = (depth_m[last] - depth_m[first]) / hours
        growth_m_per_h = np.diff(mean_m[span]) / np.diff(time[span]) * HOUR_S
        rates.append(depth_m_per_h)
        panels[panel.name] = {
            "worn_m3": float(run.read(f"wear/{panel.name}/worn_m3")[-1]),
            "mean_m_per_h": mean_by_cycles(growth_m_per_h, cycle, is_steady),
            **_deepest(depth_m_per_h, panel.table.thickness_m),
            "depth_m_per_h": depth_m_per_h,
        }
    table: dict[str, Any] = {"start_s": time[first], "end_s": time[last], "panels": panels}
    return table | {"profile": _profile(run, names, rates, deck) if deck else None}


def _deepest(depth_m_per_h: Array, thickness_m: float) -> dict[str, Any]:
    """The patch that wears fastest: its rate, its middle as shares of length and width, and when
    it is worn through."""
    row, column = np.unravel_index(int(np.nanargmax(depth_m_per_h)), depth_m_per_h.shape)
    rate = float(depth_m_per_h[row, column])
    middle = (np.array([row, column]) + 0.5) / depth_m_per_h.shape
    return {
        "largest_m_per_h": rate,
        "largest_at": middle,
        "worn_through_h": thickness_m / rate if rate > 0 else None,
    }


def _profile(run: RunReader, names: list[str], rates: list[Array], deck: DeckLine) -> dict[str, Array]:
    """Means across the width, along the deck."""
    points = [run.history[f"panels/{name}/centre_line_m"].shape[1] for name in names]
    along, mean, passed = [], [], 0
    for number, forth in deck.panels:
        station_m = deck.station_m[passed : passed + points[number]]
        passed += points[number]
        rows = rates[number] if forth else rates[number][::-1]
        middle = (np.arange(len(rows)) + 0.5) / len(rows)
        along.append(station_m[0] + middle * (station_m[-1] - station_m[0]))
        mean.append(np.nanmean(rows, axis=1))
    return {"along_m": np.concatenate(along), "mean_m_per_h": np.concatenate(mean)}
