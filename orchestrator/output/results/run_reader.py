"""The reader of a run; nothing else in the program opens ``history.h5`` or ``summary.json``."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
import numpy.typing as npt

from orchestrator.case.deck.line import DeckLine, deck_line
from orchestrator.case.deck.openings import half_depths_m, smaller_sides_m
from orchestrator.case.deck.panels import axes, single_panels
from orchestrator.case.file.folder import UnreadableFile, open_hdf5, read_json
from orchestrator.case.file.slice import share
from orchestrator.case.provenance import read_provenance
from orchestrator.case.tables.case import Case
from orchestrator.figures.results import Results, Summary, parse_results
from orchestrator.output.cycles import count_whole_cycles, counted_cycle_s, cycle_s, is_driven, within
from orchestrator.output.records.history import HISTORY_FORMAT
from orchestrator.output.records.run_folder import HISTORY, SUMMARY, check_format
from orchestrator.output.records.summary import SUMMARY_FORMAT
from orchestrator.ports import Array
from orchestrator.preflight.judge import JudgedCase, load_judged


class RunReader:
    """The folder of a run, open for reading.

    Each file is read when it is first needed.  This raises OSError or ValueError if the file is missing or
    damaged, and OtherFormat if another version of flipflow wrote it.  Use the reader in a ``with``
    statement, or call ``close`` after reading time series.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def __enter__(self) -> RunReader:
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    def close(self) -> None:
        """Close the time series, if they were opened."""
        if "history" in self.__dict__:
            self.history.close()

    @cached_property
    def summary(self) -> Summary:
        """The table of ``summary.json``."""
        file = self.folder / SUMMARY
        table: Any = read_json(file)
        if not isinstance(table, dict):
            raise UnreadableFile(f"{file}: holds no table")
        check_format(file, table.get("format_version"), SUMMARY_FORMAT)
        return table

    @property
    def results(self) -> Results:
        """The results in the summary; empty where the run has none."""
        return parse_results(self.summary)

    @cached_property
    def provenance(self) -> Mapping[str, Any]:
        """The table of ``provenance.json``."""
        return read_provenance(self.folder)

    @cached_property
    def history(self) -> Any:
        """The open file of time series."""
        file = self.folder / HISTORY
        history = open_hdf5(file)
        try:
            check_format(file, history.attrs.get("format_version"), HISTORY_FORMAT)
        except BaseException:
            history.close()
            raise
        return history

    @cached_property
    def judged(self) -> JudgedCase:
        """The judged case of the run.  Raises CaseError if it cannot be read."""
        return load_judged(self.folder / "case.toml")

    @cached_property
    def case(self) -> Case:
        """The case of the run.  Raises CaseError if it cannot be read."""
        return self.judged.case

    @property
    def share_of_width(self) -> float:
        """The share of the machine's width that was run; 1 without a slice."""
        return share(self.case.whole_machine)

    @property
    def end_s(self) -> float:
        """The last recorded output time; 0 if there is none."""
        return float(self.history["energy/time_s"][-1]) if "energy" in self.history else 0.0

    @property
    def cycle_s(self) -> float:
        """The machine's cycle, or a fiftieth of the run if nothing drives the machine."""
        return counted_cycle_s(self.case)

    def shaft_speeds_rad_per_s(self, start_s: float, end_s: float) -> dict[str, float]:
        """Return the mean speeds of shafts that motors turn in a span, by the names of the exciters."""
        speeds = {}
        for name in self.names("shafts"):
            time_s, angle_rad = (
                self.read_between(f"shafts/{name}", what, start_s, end_s) for what in ("time_s", "angle_rad")
            )
            if len(time_s) > 1:
                speeds[name] = float(np.polyfit(time_s - start_s, angle_rad, 1)[0])
        return speeds

    def turn_s(self, start_s: float, end_s: float) -> float:
        """Return the period of the first harmonic in a span: the machine's cycle, by the speeds at which
        motors really turned their shafts.

        It is the machine's cycle as the case names it if the span is shorter than a turn.
        """
        speeds_rad_per_s = self.shaft_speeds_rad_per_s(start_s, end_s)
        if not speeds_rad_per_s or min(speeds_rad_per_s.values()) * (end_s - start_s) < 2 * np.pi:
            return self.cycle_s
        return cycle_s(self.case, speeds_rad_per_s)

    @property
    def is_driven(self) -> bool:
        """True if an exciter or a drive gives the machine a cycle."""
        return is_driven(self.case)

    @property
    def edges_s(self) -> Array:
        """The times (cycles + 1,) at which whole cycles begin and end."""
        return self.cycle_s * np.arange(count_whole_cycles(self.end_s, self.cycle_s) + 1)

    @property
    def stop_s(self) -> float:
        """The time at which the first exciter begins to run down; infinite if none does."""
        stops_s = [row.stop_s for row in self.case.screen.exciters.values() if row.stop_s is not None]
        return min(stops_s, default=np.inf)

    @property
    def second_half_s(self) -> tuple[float, float]:
        """The begin and the end of the second half of the whole cycles before an exciter runs down."""
        edges_s = self.edges_s
        edges_s = edges_s[: max(2, int(np.searchsorted(edges_s, self.stop_s * (1 + 1e-9), side="right")))]
        return float(edges_s[(len(edges_s) - 1) // 2]), float(edges_s[-1])

    @property
    def deck_axes(self) -> Array:
        """The matrix (3, 3) whose columns are the deck axes in the world."""
        return axes(self.case)

    @property
    def deck(self) -> DeckLine | None:
        """The line of the deck at t = 0, or None if the panels form no line."""
        names = self.names("panels")
        lines_m = [self.history[f"panels/{name}/centre_line_m"][0] for name in names]
        half_m = {
            panel.name: half
            for panel, half in zip(single_panels(self.case), half_depths_m(self.case), strict=True)
        }
        return deck_line(lines_m, [half_m[name] for name in names])

    @property
    def counted_panels(self) -> list[str]:
        """The panels whose contacts with particles were counted, in the order of the deck."""
        if not self.history["removed/contacts"].shape[1]:
            return []
        return [str(name) for name in self.history["removed"].attrs["panels"]]

    def has(self, path: str) -> bool:
        """Return whether the time series have a group or a dataset ``path``."""
        return path in self.history

    def names(self, group: str) -> list[str]:
        """Return the names in a group in natural order, in which deck-2 stands before deck-10.

        Return none if the group is missing.
        """
        return sorted(self.history.get(group, {}), key=_words_and_numbers)

    def read(self, path: str) -> Array:
        """Return a whole dataset.  Raises KeyError if it is missing."""
        return np.asarray(self.history[path][:])

    def read_between(self, group: str, name: str, start_s: float, end_s: float) -> Array:
        """Return the rows of a dataset that are later than ``start_s`` and not later than ``end_s``."""
        time_s = self.read(f"{group}/time_s")
        return self.read(f"{group}/{name}")[within(time_s, start_s, end_s, self.cycle_s)]

    def output_rows(self, group: str, start_s: float, end_s: float) -> npt.NDArray[np.bool_]:
        """Return the mask of a group's rows at output times later than ``start_s`` and up to ``end_s``.

        A run also writes a row where it ends, and goes on from there if it is resumed.  Such a row is left
        out between output times, unless there are no others: it would count as much as a whole interval.
        """
        time_s = self.read(f"{group}/time_s")
        inside = within(time_s, start_s, end_s, self.cycle_s)
        if len(time_s) < 2:
            return inside
        number = time_s / np.diff(time_s).max()  # output times are whole multiples of their distance
        even = inside & (np.abs(number - np.round(number)) < 1e-3)
        return even if even.any() else inside

    def read_cycles(self, group: str, start_s: float, end_s: float) -> dict[str, Array]:
        """Return the columns of a group of ``point_cycles`` or ``panel_cycles`` for the cycles in a span.

        ``start_s`` and ``end_s`` must be two of ``edges_s``.
        """
        return {name: self.read_between(group, name, start_s, end_s) for name in self.names(group)}

    def series_s(self) -> Array:
        """Return the times of the rows of the series; empty if the series record nothing."""
        for kind in ("frames", "forces", "probes"):
            for name in self.names(kind):
                return self.read(f"{kind}/{name}/time_s")
        return np.empty(0)


def _words_and_numbers(name: str) -> list[str | int]:
    """Return the words and the numbers of a name in turn, by which names are put into natural order."""
    return [int(part) if part.isdecimal() else part for part in re.split(r"(\d+)", name)]


def cut_size_m(case: Case) -> float | None:
    """Return ``output.cut_size_m``, or else the smaller side of the largest openings, or else None.

    The given size is that of real particles; coarse ones stand for them, and so does what cuts them.
    """
    if case.output.cut_size_m is not None:
        return case.output.cut_size_m * case.particles.coarse_graining
    return max(smaller_sides_m(case), default=None)


def summary_of(folder: Path) -> Mapping[str, Any]:
    """Return the content of ``summary.json`` in a run's folder, or {} without a readable file.

    Raises OtherFormat where another version of flipflow wrote it.
    """
    try:
        return RunReader(folder).summary
    except (OSError, ValueError):
        return {}
