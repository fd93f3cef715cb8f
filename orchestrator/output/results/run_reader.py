"""A run's folder, opened for its results."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from orchestrator.case.deck.opening_places import smaller_sides_m
from orchestrator.case.deck.panels import axes
from orchestrator.case.tables.case import Case
from orchestrator.output.records.summary import counted_cycle_s, is_driven
from orchestrator.ports import Array
from orchestrator.preflight.levels import load


@dataclass(frozen=True)
class RunData:
    """``history`` is the open file; ``end_s`` the simulated time; ``cycle_s`` the machine's cycle,
    or a part of the run where nothing drives it (``is_driven``)."""

    case: Case
    history: Any
    end_s: float
    cycle_s: float
    is_driven: bool

    @property
    def edges_s(self) -> Array:
        """(cycles + 1,) where whole cycles begin and end; a little short of one counts as one."""
        whole = int(self.end_s / self.cycle_s + 1e-6) if self.end_s > 0 else 0
        return self.cycle_s * np.arange(whole + 1)

    @property
    def deck_axes(self) -> Array:
        """(3, 3): columns are the deck axes in the world."""
        return axes(self.case)

    def read(self, path: str) -> Array:
        """A whole dataset."""
        return np.asarray(self.history[path][:])

    def series_s(self) -> Array:
        """Times of the rows of the series; none where nothing is recorded in them."""
        for kind in ("frames", "forces", "probes"):
            for name in self.names(kind):
                return self.read(f"{kind}/{name}/time_s")
        return np.empty(0)

    def cycles(self, path: str, start_s: float, end_s: float) -> dict[str, Array]:
        """Rows of ``point_cycles`` or ``panel_cycles``, by column, of the cycles between two of
        ``edges_s``; at least one where the run lasted so long."""
        rows = self.history[path]
        ends_s = rows["time_s"][:]
        inside = (ends_s > start_s + 1e-9) & (ends_s <= end_s + 1e-9)
        return {name: column[:][inside] for name, column in rows.items()}

    def names(self, group: str) -> list[str]:
        """Groups in a group; none if it is not there."""
        return list(self.history.get(group, {}))


def run_data(folder: Path, history: Any) -> RunData:
    """Raises CaseError if the case in the folder cannot be read."""
    case = load(folder / "case.toml").case
    end_s = float(history["energy/time_s"][-1]) if "energy" in history else 0.0
    return RunData(case, history, end_s, counted_cycle_s(case), is_driven(case))


def cut_size_m(case: Case) -> float | None:
    """``output.cut_size_m``, or the smaller side of the largest openings; None without either."""
    if case.output.cut_size_m is not None:
        return case.output.cut_size_m
    return max(smaller_sides_m(case), default=None)
