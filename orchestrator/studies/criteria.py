"""Criteria: numbers that runs of a case must have, by ``criteria.toml`` beside the case.

One small language says what a paper printed, what a benchmark promises and which answers are known
from elsewhere.  A criterion takes a number (``MEASURES``) from a run, or compares numbers of several
(``COMPARISONS``), and names the band in which it must be, and where band and reference come from.
Bands are fixed before a case is run; a criterion that is known not to be met stays as it is and says
so (``known_failure``).  Criteria that the case was fitted to say that, too: they prove nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from pydantic import ValidationError
from rich.table import Table as Printed

from orchestrator.case.file.errors import CaseError, CaseProblem, did_you_mean, from_validation
from orchestrator.case.file.layers import read_toml
from orchestrator.output.records.run_folder import write_text
from orchestrator.preflight.stability.report import stability_report
from orchestrator.studies.criterion import Criteria, Criterion, WantedRun
from orchestrator.studies.measures import COMPARISONS, MEASURES, TAKES, Runs, Unknown, evaluate, number_of
from orchestrator.studies.points import Point, came_to_its_end, check_case, parse_vary, point
from orchestrator.studies.tables import Cell, console_table, markdown_table, percent, write_csv

FILE = "criteria.toml"
FORMER = ("paper.toml", "expected.toml", "answers.toml")
"""What earlier versions called the file."""
UNITS = {name: 1.0 for name in ("1", "m", "m/s", "rad/s", "N", "J", "kg", "kg/s", "s", "W")}
UNITS |= {"mm": 1e-3, "%": 0.01}


@dataclass(frozen=True)
class CriterionResult:
    """A criterion with what was measured, in its unit; ``why`` says why there is nothing."""

    case: str
    row: Criterion
    measured: float | None
    why: str = ""

    @property
    def is_inside(self) -> bool:
        """Whether there is a number, in the band if there is one."""
        if self.measured is None:
            return False
        low, high = self.row.band or self.row.ratio or (None, None)
        value = self.measured / (self.row.reference or 1.0) if self.row.ratio else self.measured
        return (low is None or low <= value) and (high is None or value <= high)

    @property
    def verdict(self) -> str:
        """What the band makes of it, in words."""
        row = self.row
        if row.known_failure:
            return "MET, but marked as failing" if self.is_inside else "known failure"
        if row.band is None and row.ratio is None:
            return "not compared" if self.measured is not None else "no number"
        return ("met" if self.is_inside else "NOT MET") + (" (fitted)" if row.fitted else "")

    @property
    def is_good(self) -> bool:
        """Whether it is met, fitted, or not met for the known reason."""
        return self.row.fitted or self.is_inside != bool(self.row.known_failure)

    @property
    def error(self) -> float | None:
        """Relative to the reference."""
        if self.measured is None or not self.row.reference:
            return None
        return self.measured / self.row.reference - 1

    @property
    def words(self) -> dict[str, Cell]:
        """A row of the table of verdicts."""
        row = self.row
        return {
            "case": self.case,
            "run": " ".join(filter(None, [row.run, row.at])),
            "criterion": row.what,
            "reference": row.reference,
            "experiment": row.experiment,
            "value": self.measured,
            "unit": row.unit,
            "error": self.error,
            "asked for": self.asked,
            "measured": self.answer,
            "verdict": self.verdict,
            "why": row.why,
            "known failure": row.known_failure,
        }

    @property
    def asked(self) -> str:
        """The band, in words."""
        row = self.row
        if row.band is None and row.ratio is None:
            return ""
        low, high = row.band or row.ratio or (None, None)
        unit = f" {row.unit}" if row.unit != "1" else ""
        if row.ratio is not None and row.reference is not None:
            unit = f" x {_in_unit(row.reference, row.unit)}"
        if low is None:
            return f"at most {high:g}{unit}"
        if high is None:
            return f"at least {low:g}{unit}"
        return f"{low:g}{unit}" if low == high else f"{low:g} to {high:g}{unit}"

    @property
    def answer(self) -> str:
        """What was measured, or why there is nothing, in words."""
        if self.measured is None:
            return self.why
        shown = _in_unit(self.measured, self.row.unit)
        if self.row.ratio is None or not self.row.reference:
            return shown
        return f"{shown} ({self.measured / self.row.reference:.4g})"


def _in_unit(value: float, unit: str) -> str:
    return f"{value:.4g} {unit}" if unit != "1" else f"{value:.4g}"


def read_criteria(case: Path) -> Criteria:
    """Returns the criteria of a case, given its folder or its file.  Raises CaseError."""
    folder = case if case.is_dir() else case.parent
    file = folder / FILE
    if not file.exists():
        refuse_former(folder)
    try:
        criteria = Criteria.model_validate(read_toml(file, folder))
    except ValidationError as error:
        raise CaseError([*from_validation(error, Criteria)]) from None
    wrong = [
        CaseProblem(
            ("criteria", number, key),
            f'no {key} "{word}"',
            did_you_mean(word, filter(None, known)),
            str(file),
        )
        for number, row in enumerate(criteria.criteria)
        for key, word, known in (
            ("run", row.run, [*criteria.runs]),
            ("against", row.against, ["", *criteria.runs]),
            ("measure", row.measure, [*MEASURES]),
            ("compare", row.compare, ["", *COMPARISONS]),
            ("take", row.take, [*TAKES]),
            ("unit", row.unit, [*UNITS]),
        )
        if word not in known
    ]
    wrong += [
        CaseProblem(("criteria", number, "ratio"), "is in multiples of a reference, which is missing")
        for number, row in enumerate(criteria.criteria)
        if row.ratio is not None and not row.reference
    ]
    if wrong:
        raise CaseError(wrong)
    return criteria


def refuse_former(folder: Path) -> None:
    """Raises CaseError where a folder has a file that an earlier version read."""
    for name in FORMER:
        if (folder / name).exists():
            what = f"is {FILE} now, in one language for papers, benchmarks and answers"
            raise CaseError([CaseProblem((), what, "docs/criteria.md", str(folder / name))])


def known_answers(case: Path) -> tuple[Criterion, ...]:
    """Returns the criteria of a case, if it has any, whose reference is the exact answer for the
    case as it is.  Raises CaseError."""
    folder = case if case.is_dir() else case.parent
    if not (folder / FILE).is_file():
        refuse_former(folder)
        return ()
    found = read_criteria(folder)
    as_it_is = [name for name, run in found.runs.items() if run == WantedRun()]
    return tuple(
        row
        for row in found.criteria
        if row.exact and row.reference and not row.compare and row.run in as_it_is
    )


def judge(case: str, row: Criterion, runs: Mapping[str, Runs]) -> CriterionResult:
    """Returns a criterion with its number, as far as the runs are made."""
    try:
        return CriterionResult(case, row, evaluate(row, runs) / UNITS[row.unit])
    except Unknown as error:
        return CriterionResult(case, row, None, str(error))


def answer_error(row: Criterion, run: Path) -> float | None:
    """Returns the relative error of a run against a known answer; None where it does not tell."""
    try:
        measured = number_of(row, run) / UNITS[row.unit]
    except Unknown:
        return None
    return abs(measured / row.reference - 1) if row.reference else None


def verdict_table(title: str, results: Sequence[CriterionResult]) -> Printed:
    """Returns the table of verdicts for the terminal, without columns in which nothing stands."""
    rows = [
        result.words
        | {"reference": _short(result.row.reference), "experiment": _short(result.row.experiment)}
        | {"error": percent(result.error)}
        for result in results
    ]
    head = (
        "criterion",
        "case",
        "run",
        "reference",
        "experiment",
        "measured",
        "error",
        "asked for",
        "verdict",
    )
    shown = [name for name in head if any(row[name] not in ("", None) for row in rows)]
    cells = ([str(row[name]) for name in shown] for row in rows)
    return console_table(title, shown, cells, left=("case", "run", "measured", "asked for", "verdict"))


def write_verdicts(results: Sequence[CriterionResult], folder: Path, name: str) -> list[Path]:
    """Writes the table of verdicts as CSV and, for the manual, in Markdown."""
    write_text(folder / f"{name}.md", verdict_markdown(results))
    return [write_csv([result.words for result in results], folder / f"{name}.csv"), folder / f"{name}.md"]


def verdict_markdown(results: Sequence[CriterionResult]) -> str:
    """Returns the table of verdicts for the manual."""
    rows = [
        (
            f"{result.case}, {result.words['run']}",
            result.row.what,
            result.row.why,
            result.asked,
            result.answer,
            result.verdict,
        )
        for result in results
    ]
    return markdown_table(("case, run", "criterion", "why", "asked for", "measured", ""), rows)


def _short(value: float | None) -> str:
    return "" if value is None else f"{value:.4g}"


def criteria_runs(
    criteria: Criteria,
    case: Path,
    level: str | None,
    sets: Sequence[str],
    out: Path,
    ended: Callable[[Path], bool] = came_to_its_end,
) -> dict[str, Runs]:
    """Returns what must be run for criteria, checked, by name; nothing is run here.  ``ended`` tells
    of a folder whether its run is over.  Raises CaseError."""
    runs = {}
    for name, wanted in criteria.runs.items():
        every = [*sets, *wanted.sets]
        if wanted.interval_over_safe is not None:
            every += interval_sets(case, level, every, wanted.interval_over_safe)
        vary = parse_vary(wanted.vary) if wanted.vary else None
        if vary is None:
            points = [point(case, level, every, name, out / name)]
        else:
            points = vary.points(case, level, every, out / name)
        points = [replace(each, ended=ended) for each in points]
        if wanted.resume_at_s is not None:
            points = [_interrupted(each, wanted.resume_at_s) for each in points]
        runs[name] = Runs(tuple(points), vary)
    return runs


def interval_sets(case: Path, level: str | None, sets: Sequence[str], multiple: float) -> list[str]:
    """Returns ``--set`` overlays of a sync interval of so many times the largest safe one.  Raises
    CaseError where nothing limits it."""
    loaded = check_case(case, level, sets)
    interval_s = multiple * stability_report(loaded.case).safe_s
    if not 0 < interval_s < loaded.case.duration_s:
        what = f"{multiple:g} times the largest safe sync interval is {interval_s:g} s"
        raise CaseError([CaseProblem(("coupling", "sync_interval_s"), what, file=str(case))])
    return [f"coupling.sync_interval_s={interval_s:.3g}"]


def _interrupted(whole: Point, resume_at_s: float) -> Point:
    """Returns the point with an end in between, where it is resumed."""
    first = (*whole.words, "--set", f"duration_s={resume_at_s!r}")
    end = f"duration_s={whole.loaded.case.duration_s!r}"
    then = ("resume", str(whole.folder.resolve()), "--set", end)

    def ended(run: Path) -> bool:
        return whole.ended(run) and "resumed" in (run / "provenance.json").read_text(encoding="utf-8")

    return replace(whole, words=first, then=then, ended=ended)
