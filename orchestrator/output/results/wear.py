"""The wear of the panels: its rate, its places, and the panels' life."""

from __future__ import annotations

import numpy as np

from orchestrator.case.deck.line import DeckLine
from orchestrator.case.deck.panels import single_panels
from orchestrator.figures.machine import PanelWear, Wear, WearProfile
from orchestrator.output.cycles import cycle_numbers
from orchestrator.output.results.estimate import ratio_by_cycles
from orchestrator.output.results.run_reader import RunReader
from orchestrator.ports import Array

HOUR_S = 3600.0


def wear_metrics(run: RunReader, start_s: float, end_s: float, is_steady: bool) -> Wear | None:
    """Return the wear between the output times from ``start_s`` to ``end_s``.

    Only a steady state has confidence intervals.  Return None with fewer than two output times.
    """
    panels = {panel.name: panel for panel in single_panels(run.case)}
    group = f"wear/{next(iter(panels))}"
    time_s = run.read(f"{group}/time_s")
    inside = (time_s >= start_s - 1e-9) & (time_s <= end_s + 1e-9)
    even = inside & run.output_rows(group, -1.0, end_s)  # the row at the start of the window, too
    there = np.flatnonzero(even if even.sum() > 1 else inside)
    if len(there) < 2:
        return None
    time_s = time_s[there]
    passed_h = np.diff(time_s) / HOUR_S
    cycle = cycle_numbers(time_s[1:], run.cycle_s, float(time_s[0]))
    table = {}
    for name, panel in panels.items():
        mean_m, depth_m = (run.read(f"wear/{name}/{column}")[there] for column in ("mean_m", "depth_m"))
        depth_m_per_h = (depth_m[-1] - depth_m[0]) / passed_h.sum()
        place, largest_m_per_h = _deepest(depth_m_per_h)
        table[name] = PanelWear(
            worn_m3=float(run.read(f"wear/{name}/worn_m3")[-1]),
            mean_m_per_h=ratio_by_cycles(np.diff(mean_m), passed_h, cycle, is_steady),
            largest_m_per_h=largest_m_per_h,
            largest_at=place,
            worn_through_h=panel.table.thickness_m / largest_m_per_h if largest_m_per_h > 0 else None,
            depth_m_per_h=depth_m_per_h,
        )
    names = run.names("panels")  # as the deck's line counts them
    rates = [table[name].depth_m_per_h for name in names]
    profile = _profile(run, names, rates, run.deck) if run.deck else None
    return Wear(start_s=float(time_s[0]), end_s=float(time_s[-1]), panels=table, profile=profile)


def _deepest(depth_m_per_h: Array) -> tuple[Array, float]:
    """Return the middle of the patch that wears fastest, as shares of length and width, and its rate."""
    row, column = np.unravel_index(int(np.nanargmax(depth_m_per_h)), depth_m_per_h.shape)
    return (np.array([row, column]) + 0.5) / depth_m_per_h.shape, float(depth_m_per_h[row, column])


def _profile(run: RunReader, names: list[str], rates: list[Array], deck: DeckLine) -> WearProfile:
    """Return the wear rates along the deck, as means across the width."""
    points = [run.history[f"panels/{name}/centre_line_m"].shape[1] for name in names]
    along, mean, passed = [], [], 0
    for number, forth in deck.panels:
        station_m = deck.station_m[passed : passed + points[number]]
        passed += points[number]
        rows = rates[number] if forth else rates[number][::-1]
        middle = (np.arange(len(rows)) + 0.5) / len(rows)
        along.append(station_m[0] + middle * (station_m[-1] - station_m[0]))
        mean.append(np.nanmean(rows, axis=1))
    return WearProfile(along_m=np.concatenate(along), mean_m_per_h=np.concatenate(mean))
