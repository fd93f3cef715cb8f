"""The means and extremes of every cycle of the machine, taken at every sync point.

A series with few rows misses the peaks between them, and a series with one row in a cycle always
shows the same phase.  This module therefore keeps the largest and the smallest values while the run
goes on.  ``history.h5`` gets one row for each cycle: ``point_cycles/<name>`` for frames and for
probes on frames and panels, and ``panel_cycles/<name>`` for panels.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from orchestrator.coupling.machine import Machine
from orchestrator.coupling.schemes.scheme import State
from orchestrator.output.cycles import cycle_number
from orchestrator.output.records.history import History, groups
from orchestrator.output.records.panel_lines import PanelLines, panel_pull_N, sum_of_products
from orchestrator.ports import Array, Indices, Motion, Saved
from orchestrator.ports.geometry import Rectangle
from orchestrator.ports.state import SavedAttributes

LEAST, MEAN, MOST = range(3)
POINT_VALUES, PANEL_VALUES = 5, 8
TOGETHER = 32  # sync points evaluated together, which costs little more than evaluating two
Columns = dict[str, tuple[int, int | slice]]
POINT_COLUMNS: Columns = {  # from the displacement since t = 0 (3), its size and the speed
    "least_m": (LEAST, slice(0, 3)),
    "mean_m": (MEAN, slice(0, 3)),
    "most_m": (MOST, slice(0, 3)),
    "farthest_m": (MOST, 3),
    "fastest_m_per_s": (MOST, 4),
}
PANEL_COLUMNS: Columns = {  # from the values that ``CycleRecord._panel_values`` returns
    "pull_least_N": (LEAST, 0),
    "pull_mean_N": (MEAN, 0),
    "pull_most_N": (MOST, 0),
    "clamp_most_N": (MOST, 1),
    "load_mean_N": (MEAN, slice(2, 5)),
    "stretch_least": (LEAST, 5),
    "stretch_most": (MOST, 5),
    "sag_most_m": (MOST, 6),
    "middle_least_m": (LEAST, 7),
    "middle_most_m": (MOST, 7),
}


class CycleRecord(SavedAttributes):
    """The record of the current cycle's means and extremes; ``cycles.py`` defines the cycle of a sync point.

    A cycle that the end of the run cuts short gets a row like the others.  Sync points are kept until there
    are ``TOGETHER``, or until the cycle or the run ends; the outcome is the same to the last bit.
    """

    STATE: ClassVar = ("_cycle", "_last_s", "_count", "_least", "_most", "_sum")

    def __init__(
        self,
        machine: Machine,
        start: State,
        rectangles: Sequence[Rectangle],
        cycle_s: float,
        history: History,
    ) -> None:
        """Begin the first cycle; ``rectangles`` are the places of the panels, in the machine's order."""
        self._history, self._cycle_s = history, cycle_s
        on_frames = [probe for probe in machine.probes if probe.on == "frame"]
        touched = {p.name: p.index for p in machine.probes if p.on == "surface"}
        self._points = [*machine.frames, *(probe.name for probe in on_frames), *touched]
        self._frames = machine.members.frames
        self._carrier = np.array([*range(len(machine.frames)), *(p.index for p in on_frames)], dtype=np.int64)
        self._arm_m = np.zeros((len(self._carrier), 3))
        self._arm_m[len(machine.frames) :] = [probe.arm_m for probe in on_frames] or np.empty((0, 3))
        self._touched = np.fromiter(touched.values(), np.int64)
        start_m = start.panel.surface.position_m
        self._start_m, _ = self._motion_of_points(start.panel.surface)
        self._panels = [panel.name for panel in machine.panels]
        lines = [panel.centre_line for panel in machine.panels]
        self._on_lines: Indices = np.concatenate([np.empty(0, dtype=np.int64), *lines])
        if self._panels:
            self._lines = PanelLines(rectangles, [start_m[line] for line in lines])
            self._along = np.array([rectangle.along for rectangle in rectangles])
        self._kept: list[tuple[Array, Array, Array, Array]] = []
        self._cycle, self._last_s, self._count = 0, 0.0, 0
        size = POINT_VALUES * len(self._points) + PANEL_VALUES * len(self._panels)
        self._least, self._most = np.full(size, np.inf), np.full(size, -np.inf)
        self._sum = np.zeros(size)

    def add_sync_point(self, time_s: float, state: State, forces_N: Array) -> None:
        """Add a sync point; ``forces_N`` (5, panels, 3) are the mean forces of the panels over the interval
        that ends here, in the order of ``series.FORCES``."""
        cycle = cycle_number(time_s, self._cycle_s)
        if cycle != self._cycle:
            self.close()
        surface = state.panel.surface
        position_m, velocity_m_per_s = self._motion_of_points(surface)
        line_m = surface.position_m.take(self._on_lines, axis=0)  # a fifth of the time of an index
        self._kept.append((position_m, velocity_m_per_s, line_m, forces_N))
        self._cycle, self._last_s, self._count = cycle, time_s, self._count + 1
        if len(self._kept) == TOGETHER:
            self._evaluate()

    def save(self) -> Saved:
        self._evaluate()
        return super().save()

    def close(self) -> None:
        """Write the row of the current cycle if it has a sync point."""
        if not self._count:
            return
        self._evaluate()
        table = np.stack([self._least, self._sum / self._count, self._most])
        of_points, of_panels = np.split(table, [POINT_VALUES * len(self._points)], axis=1)
        for kind, names, columns, values in (
            ("point_cycles", self._points, POINT_COLUMNS, of_points.reshape(3, -1, POINT_VALUES)),
            ("panel_cycles", self._panels, PANEL_COLUMNS, of_panels.reshape(3, -1, PANEL_VALUES)),
        ):
            row = {column: values[which, :, place] for column, (which, place) in columns.items()}
            row["sync_points"] = np.full(len(names), float(self._count))
            for group, of_group in groups(kind, names, row):
                self._history.add(group, self._last_s, of_group)
        self._count, self._sum[:] = 0, 0.0
        self._least[:], self._most[:] = np.inf, -np.inf

    def _evaluate(self) -> None:
        """Take the sync points that are kept into the means and extremes."""
        if not self._kept:
            return
        position_m, velocity_m_per_s, line_m, forces_N = map(np.stack, zip(*self._kept, strict=True))
        self._kept.clear()
        values = np.concatenate(
            [self._point_values(position_m, velocity_m_per_s), self._panel_values(line_m, forces_N)], axis=1
        )
        np.minimum(self._least, values.min(axis=0), out=self._least)
        np.maximum(self._most, values.max(axis=0), out=self._most)
        for row in values:  # one after the other, so that the sum does not depend on who is kept together
            self._sum += row

    def _motion_of_points(self, surface: Motion) -> tuple[Array, Array]:
        """Return positions and velocities (points, 3) at the last sync point."""
        position_m, velocity_m_per_s = self._frames.pose().carried(self._carrier, self._arm_m)
        touched = surface.part(self._touched)
        return (
            np.concatenate([position_m, touched.position_m]),
            np.concatenate([velocity_m_per_s, touched.velocity_m_per_s]),
        )

    def _point_values(self, position_m: Array, velocity_m_per_s: Array) -> Array:
        """Return the ``POINT_VALUES`` values of each point at n times, (n, all values), from its motion (n,
        points, 3)."""
        moved_m = position_m - self._start_m
        sizes = [np.sqrt(sum_of_products(x, x))[..., None] for x in (moved_m, velocity_m_per_s)]
        values: Array = np.concatenate([moved_m, *sizes], axis=2)
        return values.reshape(len(moved_m), POINT_VALUES * len(self._points))

    def _panel_values(self, line_m: Array, forces_N: Array) -> Array:
        """Return the ``PANEL_VALUES`` values of each panel at n times, (n, all values).

        They are its pull, the larger force on a clamp, its load (3), the stretch of its middle line, and
        the largest height of this line and the height of its middle over the chord between its ends.
        ``line_m`` are the lines' points (n, points, 3), ``forces_N`` has the shape (n, 5, panels, 3).
        """
        if not self._panels:
            return np.empty((len(line_m), 0))
        load_N, _, first_N, second_N, _ = np.moveaxis(forces_N, 1, 0)
        sizes_N = [np.sqrt(sum_of_products(x, x)) for x in (first_N, second_N)]
        single = (
            panel_pull_N(first_N, second_N, self._along),
            np.maximum(*sizes_N),
            *np.moveaxis(load_N, 2, 0),
            self._lines.stretch(line_m),
            *self._lines.heights_m(line_m),
        )
        values: Array = np.stack(single, axis=2)
        return values.reshape(len(line_m), PANEL_VALUES * len(self._panels))
