"""The single numbers of a run's results as rows: one row for each number, with its interval and unit."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from orchestrator.case.file.errors import CaseError
from orchestrator.case.file.folder import FolderUnusable, admit
from orchestrator.figures.figure import AXES, Figure
from orchestrator.figures.results import entry_at, why_transient
from orchestrator.figures.short_names import SHORT_NAMES, named
from orchestrator.output.records import trust
from orchestrator.output.records.run_folder import SUMMARY
from orchestrator.output.results.run_reader import RunReader

HALF_WIDTH = ".half_width"
PUT_ASIDE = re.compile(r"-unfinished-\d+$")
"""The end of the name of a run that a study put aside (studies/points.py)."""
RUNS_OVER = ("along_m", "edges_m", "end_s", "time_s")
"""Keys of the places, sizes and times over which the lists of a table run."""
OF_THE_WIDTH = {"share_of_width", "slice_width_m"}
"""Numbers of every run, however short: they say what was run and are no results."""
BY_PATH = "short names are of the whole width, and what their paths give is of the slice"
VECTOR, ITS_WIDTHS = "amplitude_m", "half_width_m"
"""Keys of a vector of estimates, and of their half widths beside it."""


@dataclass(frozen=True)
class Result:
    """A number of a run's results.

    ``name`` is a short name or a path of keys of ``results`` in ``summary.json``, joined by dots.
    ``half_width`` is half the width of its 95 % confidence interval, None where there is none.  ``figure``
    says what it is.
    """

    name: str
    value: float
    half_width: float | None
    figure: Figure
    is_short: bool = False

    @property
    def unit(self) -> str:
        """Its unit; "1" of a pure number."""
        return self.figure.unit

    @property
    def floor(self) -> float:
        """The size up to which a run does not resolve differences."""
        return self.figure.floor

    def over(self, share: float) -> Result:
        """Return the result of the whole width from that of a slice; with a short name it is that already."""
        if self.is_short or not self.figure.is_extensive:
            return self
        half_width = None if self.half_width is None else self.half_width / share
        return replace(self, value=self.value / share, half_width=half_width)


@dataclass(frozen=True)
class RunResults:
    """All results of a run, by name.

    ``share_of_width`` is the slice's share of the machine's width, 1 for the whole width.  ``unsteady`` says
    why a run that is fed is not steady, and ``unsettled`` why the motion of a machine is not; they are empty
    for the others.
    """

    folder: Path
    case: str
    level: str
    status: str
    results: dict[str, Result]
    share_of_width: float = 1.0
    unsteady: str = ""
    unsettled: str = ""

    def of_the_whole_width(self) -> RunResults:
        """Return the run with its masses, rates, numbers, forces and powers scaled to the whole width."""
        scaled = {name: result.over(self.share_of_width) for name, result in self.results.items()}
        return replace(self, results=scaled)

    def rows(self) -> list[dict[str, str | float | None]]:
        """Return a row of a tidy table for each result."""
        run = {"run": str(self.folder), "case": self.case, "level": self.level, "status": self.status}
        return [
            {
                **run,
                "result": result.name,
                "kind": "short name" if result.is_short else "path",
                "value": result.value,
                "half_width": result.half_width,
                "unit": result.unit,
            }
            for result in self.results.values()
        ]


def single_numbers(value: Any, where: str = "") -> Iterator[tuple[str, float]]:
    """Yield every single number of a run's results with its keys, joined by dots.

    The value of an estimate has the keys of the estimate; its half width, if it has one, has the additional
    key ``half_width``.  The components of a vector have the keys x, y and z, and the tables of a list have
    their ``exit`` or their number as key.  Words, and results along the deck, by size or over time, are left
    out, whatever their length.
    """
    parts: Mapping[str, Any] = {}
    if isinstance(value, int | float):
        yield where.removeprefix("."), value
    elif isinstance(value, dict) and set(value) >= {"value", "half_width", "batches"}:
        parts = {"": value["value"], HALF_WIDTH: value["half_width"]}
    elif isinstance(value, dict):
        parts = {f".{key}": part for key, part in _entries(value).items()}
    elif isinstance(value, list) and value and isinstance(value[0], dict):
        parts = {f".{row.get('exit', number)}": row for number, row in enumerate(value)}
    elif isinstance(value, list) and len(value) == 3:
        parts = dict(zip((f".{axis}" for axis in AXES), value, strict=True))
    for key, part in parts.items():
        yield from single_numbers(part, where + key)


def _entries(table: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the entries of a table of results, without lists that run along the deck, by size or over time.

    A vector with half widths beside it becomes a table of estimates by component.
    """
    if any(isinstance(table.get(key), list) for key in RUNS_OVER):
        return {key: part for key, part in table.items() if not isinstance(part, list)}
    if not (isinstance(table.get(VECTOR), list) and ITS_WIDTHS in table):
        return table
    widths = table[ITS_WIDTHS] or [None] * len(AXES)
    rows = zip(AXES, table[VECTOR], widths, strict=True)
    estimates = {axis: {"value": size, "half_width": width, "batches": None} for axis, size, width in rows}
    return {**{key: part for key, part in table.items() if key != ITS_WIDTHS}, VECTOR: estimates}


def tidy_results(summary: Mapping[str, Any]) -> dict[str, Result]:
    """Return the results in a summary by name: those with a short name first, then all single numbers."""
    found: dict[str, Result] = {}
    for name, scalar in SHORT_NAMES.items():
        if (value := scalar.of(summary)) is not None:
            found[name] = Result(name, value.value, value.half_width, scalar.figure, True)
    numbers = dict(single_numbers(summary.get("results") or {}))
    for name, number in numbers.items():
        if not name.endswith(HALF_WIDTH) and not isinstance(number, bool):
            record = named(f"results.{name}").figure
            found[name] = Result(name, float(number), numbers.get(name + HALF_WIDTH), record)
    return found


def read_results(folders: Sequence[Path]) -> list[RunResults]:
    """Return the results of the runs in some folders, which may be folders of studies.

    Raises FolderUnusable with every folder that is no run, that has no results, or that another version of
    flipflow wrote.
    """
    runs: list[RunResults] = []
    problems: list[str] = []
    for folder in (run for each in folders for run in find_runs(each)):
        try:
            runs.append(_read(folder))
        except (FolderUnusable, CaseError) as error:
            problems.append(str(error))
        except (OSError, ValueError) as error:
            problems.append(f"{folder}: is not a run that has ended ({error})")
    if problems:
        raise FolderUnusable("\n".join(problems))
    return runs


def find_runs(folder: Path) -> list[Path]:
    """Return the folder itself, or the folders of the ended runs in it if it is the folder of a study.

    A sweep has its runs in its folder, a design study in ``runs/``.  Runs that a study put aside, because
    they did not end and were repeated, are left out.
    """
    if (folder / "case.toml").is_file() or (folder / SUMMARY).is_file():
        return [folder]
    ended = {file.parent for depth in ("*", "runs/*") for file in folder.glob(f"{depth}/{SUMMARY}")}
    return sorted(run for run in ended if not PUT_ASIDE.search(run.name)) or [folder]


def _read(folder: Path) -> RunResults:
    """Read the results of a run.  Raises FolderUnusable, OSError or ValueError."""
    if not folder.is_dir():
        raise FolderUnusable(f"{folder}: no such folder")
    if not (folder / SUMMARY).is_file():
        raise FolderUnusable(f"{folder}: is not a run that has ended: it has no {SUMMARY}")
    summary = RunReader(admit(folder)).summary
    status = str(summary.get("status", "unknown"))
    results, (unsteady, unsettled) = tidy_results(summary), why_transient(summary)
    if results.keys() <= OF_THE_WIDTH:
        why = json.dumps(entry_at(summary, "results.missing") or {"status": status})
        raise FolderUnusable(f"{folder}: the run has no results ({why})")
    return RunResults(
        folder=folder,
        case=str(summary.get("case", folder.name)),
        level=str(summary.get("level") or ""),
        status=status,
        results=results,
        share_of_width=entry_at(summary, "results.share_of_width") or 1.0,
        unsteady=unsteady,
        unsettled=unsettled,
    )


def doubtful(runs: Sequence[RunResults], scaled: str = BY_PATH) -> list[str]:
    """Return a line for each run that is not to be trusted, not steady or not settled, and one if widths
    differ, which ends in what is ``scaled`` to the whole width."""
    lines = [
        f"{run.folder}: the run is {run.status}: its results are not to be trusted"
        for run in runs
        if not trust.is_trusted(run.status)
    ]
    lines += [f"{run.folder}: not steady: {run.unsteady}" for run in runs if run.unsteady]
    lines += [f"{run.folder}: the machine has not settled: {run.unsettled}" for run in runs if run.unsettled]
    if len({run.share_of_width for run in runs}) > 1:
        shares = ", ".join(f"{run.folder.name} {run.share_of_width:.3g}" for run in runs)
        lines.append(f"the runs are slices of different shares of the width ({shares}): {scaled}")
    return lines
