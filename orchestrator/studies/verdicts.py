"""Verdicts on criteria, and tables of verdicts."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from rich.table import Table

from orchestrator.studies.criteria import (
    UNITS,
    Criteria,
    Criterion,
    Runs,
    evaluate,
    half_width,
    read_criteria,
    wanted_runs,
)
from orchestrator.studies.points import CaseStudy, Point
from orchestrator.studies.report import markdown_table, percent
from orchestrator.workbench import Run, StudyFolder, Unknown
from orchestrator.workbench.vocabulary import Cell, console_table

WORST_FIRST = (
    "NOT MET",
    "NOT as own theory",
    "MET, but marked as failing",
    "known failure",
    "no number",
    "fitted, OUTSIDE",
    "assumed, OUTSIDE",
    "published, OUTSIDE",
    "chance",
    "sign only",
    "met",
    "as own theory",
    "fitted, inside",
    "assumed, inside",
    "published, inside",
    "not compared",
)
"""All verdicts, in the order in which they are shown."""


@dataclass(frozen=True)
class CriterionResult:
    """A criterion with the measured number, in the criterion's unit.

    ``measured`` is None where there is no number; ``why`` then gives the reason.  ``half_width`` is half the
    width of the number's 95 % confidence interval, None where it is unknown.
    """

    case: str
    row: Criterion
    measured: float | None
    why: str = ""
    half_width: float | None = None
    note: str = ""
    """A remark on a number that was recorded earlier."""

    @property
    def is_inside(self) -> bool:
        """Whether there is a number and it is inside the band, if there is a band."""
        return self.measured is not None and self._reaches(0.0)

    @property
    def is_good(self) -> bool:
        """Whether the criterion is met as expected.

        There must be a number, and a known failure must fail.  A number that is not predicted, and an effect
        that our runs cannot tell from chance, may fail.
        """
        if self.measured is None:
            return False
        if self.row.ours != "predicted" or self.is_chance:
            return True
        return self.is_inside != bool(self.row.known_failure)

    @property
    def is_chance(self) -> bool:
        """Whether our runs cannot tell an effect from none, nor from the band.

        An effect whose interval holds zero and ends short of the band is a miss.
        """
        if not self.row.is_effect or self.measured is None or self.half_width is None:
            return False
        return abs(self.measured) <= self.half_width and self._reaches(self.half_width)

    def _reaches(self, half_width: float) -> bool:
        """Return whether any part of the number's interval is inside the band, if there is a band."""
        low, high = self.row.limits or (None, None)
        assert self.measured is not None
        return (low is None or low <= self.measured + half_width) and (
            high is None or self.measured - half_width <= high
        )

    @property
    def verdict(self) -> str:
        """The verdict on the number, in words; a number that the runs do not have is neither met nor not."""
        row = self.row
        if self.measured is None:
            return "no number"
        if row.known_failure:
            return "MET, but marked as failing" if self.is_inside else "known failure"
        if row.limits is None:
            return "not compared"
        if row.ours != "predicted":
            return f"{row.ours}, {'inside' if self.is_inside else 'OUTSIDE'}"
        if row.band_from == "own-theory":
            return "as own theory" if self.is_inside else "NOT as own theory"
        if self.is_chance:
            return "chance"
        if not self.is_inside:
            return "NOT MET"
        return "sign only" if row.is_sign_only else "met"

    @property
    def error(self) -> float | None:
        """The signed error relative to the reference; None without number or reference."""
        if self.measured is None or not self.row.reference:
            return None
        return self.measured / self.row.reference - 1

    @property
    def distance(self) -> float | None:
        """The signed distance to the reference in the criterion's unit; None without number or reference."""
        if self.measured is None or self.row.reference is None:
            return None
        return self.measured - self.row.reference

    @property
    def distance_in_words(self) -> str:
        """The distance in the criterion's unit and, for what is no share, in per cent; else an empty text."""
        if self.distance is None:
            return ""
        unit = {"1": "", "%": " points"}.get(self.row.unit, f" {self.row.unit}")
        share = "" if self.error is None or self.row.unit == "%" else f" ({100 * self.error:+.0f} %)"
        return f"{self.distance:+.2g}{unit}{share}"

    @property
    def run(self) -> str:
        """The run or runs from which the number comes."""
        return " ".join(filter(None, [self.row.run, self.row.at]))

    @property
    def band_in_words(self) -> str:
        """The band in words, with its unit; empty without a band."""
        row = self.row
        if row.limits is None:
            return ""
        low, high = row.ratio or row.limits
        unit = f" {row.unit}" if row.unit != "1" else ""
        if row.ratio is not None and row.reference is not None:
            unit = f" x {self._in_unit(row.reference)}"
        if low is None:
            return f"at most {high:g}{unit}"
        if high is None:
            return f"at least {low:g}{unit}"
        return f"{low:g}{unit}" if low == high else f"{low:g} to {high:g}{unit}"

    @property
    def reference_in_words(self) -> str:
        """The published number with its error and unit; empty without one."""
        row = self.row
        if row.reference is None:
            return ""
        error = "" if row.error is None else f" ± {row.error:.2g}"
        return f"{row.reference:g}{error} {row.unit}".removesuffix(" 1")

    @property
    def value_in_words(self) -> str:
        """The measured value in words, or the reason why there is no value."""
        if self.measured is None:
            return self.why
        shown = self._in_unit(self.measured)
        if self.half_width is not None:
            shown = f"{self.measured:.4g} ± {self._in_unit(self.half_width, 2)}"
        if self.row.ratio is None or not self.row.reference:
            return shown
        return f"{shown} ({self.measured / self.row.reference:.4g})"

    def _in_unit(self, value: float, digits: int = 4) -> str:
        return f"{value:.{digits}g} {self.row.unit}".removesuffix(" 1")

    @property
    def cells(self) -> dict[str, Cell]:
        """The row of the CSV table."""
        row = self.row
        return {
            "case": self.case,
            "run": self.run,
            "criterion": row.what,
            "reference": row.reference,
            "experiment": row.experiment,
            "value": self.measured,
            "half width": self.half_width,
            "unit": row.unit,
            "distance": self.distance,
            "error": self.error,
            "ours": row.ours,
            "band from": row.band_from,
            "fact": row.fact or row.what,
            "asked for": self.band_in_words,
            "measured": self.value_in_words,
            "verdict": self.verdict,
            "why": row.why,
            "known failure": row.known_failure,
        }


@dataclass(frozen=True)
class CaseCriteria:
    """A case at a level ("" for none) with its criteria, and the runs that they need by name."""

    name: str
    criteria: Criteria
    runs: dict[str, Runs]
    level: str = ""

    @property
    def points(self) -> list[Point]:
        """All runs that the criteria need."""
        return [point for runs in self.runs.values() for point in runs.points]

    def results(self) -> list[CriterionResult]:
        """Return the result of every criterion; a missing run gives no number."""
        return [judge(self.name, row, self.runs) for row in self.criteria.criteria]


def worst_first(results: Iterable[CriterionResult]) -> list[CriterionResult]:
    """Return results with the misses before what is met, and that before what proves nothing."""
    return sorted(results, key=lambda each: WORST_FIRST.index(each.verdict))


def judge(case: str, row: Criterion, runs: Mapping[str, Runs]) -> CriterionResult:
    """Return the result of a criterion; a missing run gives no number."""
    unit = UNITS[row.unit]
    try:
        measured, width = evaluate(row, runs) / unit, half_width(row, runs)
    except Unknown as error:
        return CriterionResult(case, row, None, str(error))
    except ZeroDivisionError:
        return CriterionResult(case, row, None, "is relative to a number that is zero")
    return CriterionResult(case, row, measured, half_width=None if width is None else width / unit)


def case_criteria(study: CaseStudy, ended: Callable[[Run], bool] = Run.came_to_its_end) -> CaseCriteria:
    """Return the criteria of a case with the runs that they need; nothing is run here.

    ``ended`` says whether a run is over.  Raises CaseError.
    """
    criteria = read_criteria(study.case)
    runs = wanted_runs(criteria, study, ended)
    level = next(point.loaded.level for each in runs.values() for point in each.points)
    return CaseCriteria(study.case.resolve().name, criteria, runs, level)


COLUMNS = ("criterion", "case", "run", "reference", "experiment", "measured", "error", "asked for", "verdict")
TEXTS = ("case", "run", "measured", "asked for", "verdict")


def verdict_table(title: str, results: Sequence[CriterionResult]) -> Table:
    """Return the table of verdicts for the terminal, without empty columns."""
    rows = []
    for each in results:
        known = {"reference": each.row.reference, "experiment": each.row.experiment}
        shown = {name: f"{value:.4g}" for name, value in known.items() if value is not None}
        rows.append(each.cells | dict.fromkeys(known, "") | shown | {"error": percent(each.error)})
    head = [name for name in COLUMNS if any(row[name] not in ("", None) for row in rows)]
    return console_table(title, head, ([str(row[name]) for name in head] for row in rows), left=TEXTS)


def write_verdicts(results: Sequence[CriterionResult], folder: Path, name: str) -> list[Path]:
    """Write the table of verdicts as CSV and in Markdown, and return both files."""
    into = StudyFolder(folder)
    markdown = into.write_text(f"{name}.md", verdict_markdown(results))
    return [into.write_csv(f"{name}.csv", [each.cells for each in results]), markdown]


def verdict_markdown(results: Sequence[CriterionResult]) -> str:
    """Return the table of verdicts in Markdown for the manual."""
    columns = ("criterion", "why", "asked for", "measured")
    rows = (
        (f"{each.case}, {each.run}", *(str(each.cells[name]) for name in columns), each.verdict)
        for each in results
    )
    return markdown_table(("case, run", *columns, ""), rows)
