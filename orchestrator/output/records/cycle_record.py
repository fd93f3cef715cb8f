"""Means and extremes of every cycle of the machine, taken at every sync point.

A series that is written seldom misses the peaks between its rows, and one that is written once in
a cycle always sees the same phase.  So the largest and the smallest values are kept here while
the run goes on, and ``history.h5`` gets one row for each cycle: ``point_cycles/<name>`` of frames
and probes on frames and panels, ``panel_cycles/<name>`` of panels.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from orchestrator.coupling.machine import Machine
from orchestrator.coupling.schemes.scheme import State
from orchestrator.output.cycles import cycle_numbers
from orchestrator.output.records.history import History
from orchestrator.output.records.panel_lines import PanelLines, panel_pull_N
from orchestrator.ports import Array, Indices
from orchestrator.ports.geometry import Rectangle
from orchestrator.ports.state import SavedAttributes

Rows = dict[str, dict[str, Array | float]]


class CycleRecord(SavedAttributes):
    """Keeps the extremes of the cycle that goes on (``cycles.py`` says which sync points it holds).  A
    cycle that the end of the run cuts short has a row like others."""

    STATE: ClassVar = ("_cycle", "_last_s", "_count", "_least", "_most", "_sum")

    def __init__(
        self,
        machine: Machine,
        start: State,
        rectangles: Sequence[Rectangle],
        cycle_s: float,
        history: History,
    ) -> None:
        """``rectangles``: where the panels are mounted, in the machine's order."""
        self._history, self._cycle_s = history, cycle_s
        self._points = Points(machine, start)
        self._panels = Panels(machine, start, rectangles)
        self._cycle, self._last_s, self._count = 0, 0.0, 0
        size = self._points.size + self._panels.size
        self._least, self._most = np.full(size, np.inf), np.full(size, -np.inf)
        self._sum = np.zeros(size)

    def sync_point(self, time_s: float, state: State, forces_N: Array) -> None:
        """Takes note of a sync point; ``forces_N`` (5, panels, 3) are the panels' forces over the interval
        that ends here, in the order of ``series.FORCES``."""
        cycle = int(cycle_numbers(time_s, self._cycle_s))
        if cycle != self._cycle and self._count:
            self._row()
        values = np.concatenate([self._points.at(state), self._panels.at(state, forces_N)])
        self._cycle, self._last_s, self._count = cycle, time_s, self._count + 1
        np.minimum(self._least, values, out=self._least)
        np.maximum(self._most, values, out=self._most)
        self._sum += values

    def close(self) -> None:
        """Adds the row of the cycle that has begun."""
        if self._count:
            self._row()

    def _row(self) -> None:
        middle = self._points.size
        table = np.stack([self._least, self._sum / self._count, self._most])
        rows = self._points.rows(table[:, :middle]) | self._panels.rows(table[:, middle:])
        for group, values in rows.items():
            self._history.add(group, self._last_s, {"sync_points": float(self._count), **values})
        self._count, self._sum[:] = 0, 0.0
        self._least[:], self._most[:] = np.inf, -np.inf


class Points:
    """Centres of mass of the frames, and probes on frames and panels: by point, the displacement
    since t = 0 (3), its size and the speed."""

    def __init__(self, machine: Machine, start: State) -> None:
        carried = machine.centres | {p.name: p.index for p in machine.probes if p.on == "clamps"}
        touched = {p.name: p.index for p in machine.probes if p.on == "surface"}
        self._names = [*carried, *touched]
        self._carried = np.fromiter(carried.values(), np.int64)
        self._touched = np.fromiter(touched.values(), np.int64)
        self._start_m = self._taken(start.clamps.position_m, start.panel.surface.position_m)
        self.size = 5 * len(self._names)

    def at(self, state: State) -> Array:
        clamps, surface = state.clamps, state.panel.surface
        moved_m = self._taken(clamps.position_m, surface.position_m) - self._start_m
        velocity_m_per_s = self._taken(clamps.velocity_m_per_s, surface.velocity_m_per_s)
        sizes = [np.sqrt(np.einsum("ij,ij->i", x, x)) for x in (moved_m, velocity_m_per_s)]
        return np.column_stack([moved_m, *sizes]).ravel()

    def rows(self, table: Array) -> Rows:
        """Returns the columns of each, from least, mean and most of their values, (3, 5 n)."""
        values = zip(self._names, *table.reshape(3, -1, 5), strict=True)
        return {
            f"point_cycles/{name}": {
                "least_m": low[:3],
                "mean_m": middle[:3],
                "most_m": high[:3],
                "farthest_m": float(high[3]),
                "fastest_m_per_s": float(high[4]),
            }
            for name, low, middle, high in values
        }

    def _taken(self, carried: Array, touched: Array) -> Array:
        return np.vstack([carried[self._carried], touched[self._touched]])


class Panels:
    """By panel: pull, largest force on a clamp, load (3), stretch of the middle line, its largest
    height over the chord between its ends, and its middle's."""

    def __init__(self, machine: Machine, start: State, rectangles: Sequence[Rectangle]) -> None:
        self._names = [panel.name for panel in machine.panels]
        self.size = 8 * len(self._names)
        if not self._names:
            return
        lines = [panel.centre_line for panel in machine.panels]
        start_m = start.panel.surface.position_m
        self._points: Indices = np.concatenate(lines)
        self._lines = PanelLines(rectangles, [start_m[line] for line in lines])
        self._along = np.array([rectangle.along for rectangle in rectangles])

    def at(self, state: State, forces_N: Array) -> Array:
        if not self._names:
            return np.empty(0)
        load_N, _, first_N, second_N, _ = forces_N
        clamp_N = np.linalg.norm([first_N, second_N], axis=2).max(axis=0)
        place_m = state.panel.surface.position_m[self._points]
        columns = (
            panel_pull_N(first_N, second_N, self._along),
            clamp_N,
            load_N,
            self._lines.stretch(place_m),
            *self._lines.heights_m(place_m),
        )
        return np.column_stack(columns).ravel()

    def rows(self, table: Array) -> Rows:
        """Returns the columns of each, from least, mean and most of their values, (3, 8 n)."""
        values = zip(self._names, *table.reshape(3, -1, 8), strict=True)
        return {
            f"panel_cycles/{name}": {
                "pull_least_N": float(low[0]),
                "pull_mean_N": float(middle[0]),
                "pull_most_N": float(high[0]),
                "clamp_most_N": float(high[1]),
                "load_mean_N": middle[2:5],
                "stretch_least": float(low[5]),
                "stretch_most": float(high[5]),
                "sag_most_m": float(high[6]),
                "middle_least_m": float(low[7]),
                "middle_most_m": float(high[7]),
            }
            for name, low, middle, high in values
        }
