"""A case against the paper it comes from: ``paper.toml`` beside the case has the paper's values.

A row names a quantity (``quantities.py``), the runs it is taken from and the band in which it
counts as met.  Rows that the case was fitted to say so: they prove nothing.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from pydantic import ValidationError
from rich.table import Table as Printed

from orchestrator.case.file.errors import CaseError, CaseProblem, from_validation
from orchestrator.case.file.toml_file import read_toml
from orchestrator.case.tables.quantities import Name, Number, OneLine, Switch, Table
from orchestrator.studies import sweep
from orchestrator.studies.points import parsed
from orchestrator.studies.quantities import QUANTITIES, UNITS, Sweep, Unknown

FILE = "paper.toml"


class Runs(Table):
    """Runs of the case over values of one key."""

    vary: OneLine
    """As ``flipflow study sweep --vary``."""


class Row(Table):
    """One value of the paper, and how ours is found."""

    what: OneLine
    """What it is, in the paper's words."""
    of: OneLine
    """The runs it is taken from."""
    at: OneLine = ""
    """The value that picks one of them; without it, all together."""
    quantity: OneLine
    """How it is computed (``quantities.QUANTITIES``)."""
    point: OneLine = ""
    """The frame, probe, panel or pair of frames that it is about."""
    axis: OneLine = "x"
    """x along the deck, z normal to it."""
    between: tuple[Number, Number] | None = None
    """Part of a sweep."""
    unit: OneLine = "mm"
    """Unit of this row's numbers."""
    paper: Number | None = None
    """The paper's simulation; none where the paper has a figure only."""
    experiment: Number | None = None
    """The paper's experiment."""
    band: tuple[Number, Number] | None = None
    """Ours is met from the first to the second; none where there is nothing to compare it with."""
    fitted: Switch
    """Whether the case's values were chosen to meet it."""


class Paper(Table):
    """``paper.toml``."""

    source: OneLine
    """The paper."""
    runs: dict[Name, Runs]
    """What must be run."""
    rows: tuple[Row, ...]
    """The comparison."""


@dataclass(frozen=True)
class Line:
    """A row with our value in its unit; ``why`` says why there is none."""

    row: Row
    ours: float | None
    why: str = ""

    @property
    def good(self) -> bool:
        """There is a value, in the band if there is one."""
        low, high = self.row.band or (-math.inf, math.inf)
        return self.ours is not None and low <= self.ours <= high

    @property
    def verdict(self) -> str:
        if self.ours is None:
            return self.why
        if self.row.band is None:
            return "not compared"
        return ("met" if self.good else "NOT MET") + (" (fitted)" if self.row.fitted else "")

    @property
    def error(self) -> float | None:
        """Relative to the paper's value."""
        if self.ours is None or not self.row.paper:
            return None
        return self.ours / self.row.paper - 1


def read(case: Path) -> Paper:
    """Raises CaseError."""
    file = (case if case.is_dir() else case.parent) / FILE
    given = read_toml(file, file.parent)
    try:
        found = Paper.model_validate(given)
    except ValidationError as error:
        raise CaseError([*from_validation(error, Paper)]) from None
    wrong = []
    for number, row in enumerate(found.rows):
        for key, word, known in (
            ("quantity", row.quantity, [*QUANTITIES]),
            ("of", row.of, [*found.runs]),
            ("unit", row.unit, [*UNITS]),
        ):
            if word not in known:
                what = f'no {key} "{word}"'
                wrong.append(CaseProblem(("rows", number, key), what, f"known: {known}", str(file)))
    if wrong:
        raise CaseError(wrong)
    return found


def runs(
    paper: Paper, case: Path, level: str | None, overrides: Sequence[str], out: Path
) -> dict[str, Sweep]:
    """Every sweep that the paper needs; none is run here.  Raises CaseError."""
    found = {}
    for name, wanted in paper.runs.items():
        vary = parsed(wanted.vary)
        points = sweep.points(case, level, overrides, vary, out / name)
        found[name] = Sweep(vary, points)
    return found


def compared(paper: Paper, found: Mapping[str, Sweep]) -> list[Line]:
    """Every row with our value, as far as the runs are done."""
    lines = []
    for row in paper.rows:
        of = found[row.of]
        try:
            part = of.at(row.at) if row.at else of.between(row.between)
            ours = QUANTITIES[row.quantity](part, row.point, row.axis)
            lines.append(Line(row, ours / UNITS[row.unit]))
        except Unknown as error:
            lines.append(Line(row, None, str(error)))
    return lines


def table(paper: Paper, lines: Sequence[Line]) -> Printed:
    """For the terminal."""
    printed = Printed(title=paper.source, title_justify="left")
    for column in ("", "paper", "experiment", "ours", "unit", "error", "band", "verdict"):
        right = column in ("paper", "experiment", "ours", "error")
        printed.add_column(column, justify="right" if right else "left", no_wrap=bool(column))
    for line in lines:
        printed.add_row(*_words(line))
    return printed


def write(lines: Sequence[Line], folder: Path) -> Path:
    """``paper.csv``"""
    file = folder / "paper.csv"
    with file.open("w", newline="", encoding="utf-8") as text:
        writer = csv.writer(text)
        names = ("what", "paper", "experiment", "ours", "unit", "error", "band", "verdict")
        writer.writerow(names)
        writer.writerows(_words(line) for line in lines)
    return file


def _words(line: Line) -> tuple[str, ...]:
    row = line.row
    numbers = ("" if x is None else f"{x:.3g}" for x in (row.paper, row.experiment, line.ours))
    error = "" if line.error is None else f"{100 * line.error:+.1f} %"
    band = "" if row.band is None else f"{row.band[0]:g} to {row.band[1]:g}"
    return (row.what, *numbers, row.unit, error, band, line.verdict)
