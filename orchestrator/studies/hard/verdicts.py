"""The criteria of hard cases against what was measured: a table for the terminal, CSV, Markdown."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from rich.table import Table

from orchestrator.output.records.run_folder import write_text
from orchestrator.studies.hard.cases import HardCase
from orchestrator.studies.hard.criterion import Criterion
from orchestrator.studies.hard.measures import MEASURES, Unknown

HEAD = ("case", "run", "criterion", "asked for", "measured", "verdict")
MET, KNOWN, NOT_MET, OUTGROWN = "met", "known failure", "NOT MET", "MET, but marked as failing"


@dataclass(frozen=True)
class Line:
    """A criterion with what was measured, in its unit; ``why`` says why there is nothing."""

    case: HardCase
    row: Criterion
    measured: float | None
    why: str = ""

    @property
    def inside(self) -> bool:
        """In the band."""
        if self.measured is None:
            return False
        low, high = self.row.band
        value = self.measured / (self.row.reference or 1.0)
        return (low is None or low <= value) and (high is None or value <= high)

    @property
    def verdict(self) -> str:
        if self.row.known_failure:
            return OUTGROWN if self.inside else KNOWN
        return MET if self.inside else NOT_MET

    @property
    def good(self) -> bool:
        """As it is said to be: met, or not met for the known reason."""
        return self.verdict in (MET, KNOWN)

    @property
    def asked(self) -> str:
        """The band, in words."""
        low, high = self.row.band
        if self.row.reference is not None:
            of = f" x {_number(self.row.reference, self.row.unit)}"
        else:
            of = f" {self.row.unit}" if self.row.unit != "1" else ""
        if low is None:
            return f"at most {high:g}{of}"
        if high is None:
            return f"at least {low:g}{of}"
        return f"{low:g}{of}" if low == high else f"{low:g} to {high:g}{of}"

    @property
    def said(self) -> str:
        """What was measured, in words."""
        if self.measured is None:
            return self.why
        shown = _number(self.measured, self.row.unit)
        if self.row.reference is None:
            return shown
        return f"{shown} ({self.measured / self.row.reference:.4g})"

    def words(self) -> tuple[str, ...]:
        row = self.row
        return (self.case.name, row.run, row.what, self.asked, self.said, self.verdict)


def judged(cases: Sequence[HardCase]) -> list[Line]:
    """Every criterion, as far as the runs are done."""
    return [line(case, row) for case in cases for row in case.expected.criteria]


def line(case: HardCase, row: Criterion) -> Line:
    """One criterion; of runs that were not made it says so."""
    folders = {name: point.folder for name, point in case.points.items()}
    try:
        return Line(case, row, MEASURES[row.measure](folders, row))
    except Unknown as error:
        return Line(case, row, None, str(error))


def table(lines: Sequence[Line]) -> Table:
    """For the terminal."""
    printed = Table(title="hard cases", title_justify="left")
    for column in HEAD:
        printed.add_column(column)
    for one in lines:
        printed.add_row(*one.words())
    return printed


def write(lines: Sequence[Line], folder: Path) -> list[Path]:
    """``hard.csv`` and, for docs/measured/benchmarks.md, ``hard.md``."""
    file = folder / "hard.csv"
    with file.open("w", newline="", encoding="utf-8") as text:
        writer = csv.writer(text)
        writer.writerow((*HEAD, "why", "known failure"))
        writer.writerows((*one.words(), one.row.why, one.row.known_failure) for one in lines)
    write_text(folder / "hard.md", markdown(lines))
    return [file, folder / "hard.md"]


def markdown(lines: Sequence[Line]) -> str:
    """The table of docs/measured/benchmarks.md."""
    rows = ["| case, run | criterion | why | asked for | measured | |", "|---|---|---|---|---|---|"]
    for one in lines:
        case, run, what, asked, said, verdict = one.words()
        rows.append(f"| {case}, {run} | {what} | {one.row.why} | {asked} | {said} | {verdict} |")
    return "\n".join(rows) + "\n"


def _number(value: float, unit: str) -> str:
    return f"{value:.4g} {unit}" if unit != "1" else f"{value:.4g}"
