"""Criteria: numbers that runs of a case must have, by ``criteria.toml`` beside the case.

One small language describes the numbers that a paper printed, the promises of a benchmark and the answers
that are known from elsewhere.  A criterion takes a number (``quantities.MEASURES``) from a run, or compares
the numbers of several runs.  It names the band in which the number must be, and the source of band and
reference.  Bands are fixed before a case is run.  A criterion that is known to fail stays as it is and gives
the reason (``known_failure``).  Only a predicted number in a band from the source counts as met: a number to
which the case was fitted proves nothing (``ours``), and neither does a band from our own theory
(``band_from``).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np
from pydantic import ValidationError
from scipy.stats import t as student_t

from orchestrator.studies.points import CaseStudy, Point, Vary, parse_vary
from orchestrator.workbench import CaseError, CaseProblem, Question, Run, Unknown
from orchestrator.workbench.vocabulary import (
    Array,
    Few,
    Name,
    Number,
    OneLine,
    Positive,
    Switch,
    Table,
    did_you_mean,
    from_validation,
    read_toml,
)

FILE = "criteria.toml"
UNITS = {name: 1.0 for name in ("1", "m", "m/s", "rad/s", "N", "J", "kg", "kg/m2", "kg/s", "s", "W")}
UNITS |= {"mm": 1e-3, "%": 0.01}
Band = tuple[Number | None, Number | None]


class WantedRun(Table):
    """One run of the case, or one for each value of a key."""

    vary: OneLine = ""
    """The varied key and its values, as ``flipflow study sweep --vary`` takes them; without it, there is a
    single run."""
    sets: tuple[OneLine, ...] = ()
    """Overlays, as ``--set`` takes them."""
    interval_over_safe: Positive | None = None
    """The sync interval, in multiples of the largest safe one that the stability report gives."""
    resume_at_s: Positive | None = None
    """The time at which the run ends, to be resumed afterwards."""


class Criterion(Question):
    """One number of a case's runs, and the band in which it must be."""

    what: OneLine
    """A description of the number."""
    run: Name
    """The entry of ``runs`` from which the number is taken."""
    at: OneLine = ""
    """The value of a varied key that selects one run."""
    between: tuple[Number, Number] | None = None
    """The range of values of a varied key that counts."""
    compare: OneLine = ""
    """The comparison of numbers with each other (``COMPARISONS``); without it, the number itself counts."""
    against: OneLine = ""
    """The run with which the number is compared."""
    earlier_s: tuple[Number, Number] | None = None
    """The earlier part of the series with which the number is compared, where there is no other run."""
    unit: OneLine = "1"
    """The unit of this criterion's numbers."""
    reference: Number | None = None
    """The number as it is known from elsewhere: from a paper or a closed form."""
    error: Positive | None = None
    """Half the width of the reference's 95 % interval, as the source gives it or as its data show it.  The
    number must be in that interval."""
    fact: OneLine = ""
    """The published fact that the criterion judges.  Criteria of one fact, in this case or in others of the
    same paper, count once.  By default, ``what`` names it."""
    exact: Switch = False
    """Whether the reference is the exact answer, so that ``flipflow study accuracy`` measures errors
    against it."""
    experiment: Number | None = None
    """The number as an experiment gave it."""
    band: Band | None = None
    """The lower and the upper limit of the number; none where the number is not compared."""
    ratio: Band | None = None
    """The lower and the upper limit in multiples of the reference."""
    why: OneLine = ""
    """The source of band and reference."""
    ours: Literal["published", "assumed", "fitted", "predicted"] = "predicted"
    """The origin of this program's number.  published, assumed: the case gives the number as a value, from
    the source or as an assumption.  fitted: values of the case were chosen to meet the criterion.  predicted:
    the number follows from the runs alone."""
    band_from: Literal["source", "own-theory"] = "source"
    """The origin of the band: the source of the reference, or the theory of this program."""
    scatter: OneLine = ""
    """The entry of ``runs``, of one case with several seeds, that shows the scatter of each run's number;
    without it, the interval is that of the run itself."""
    known_failure: OneLine = ""
    """The reason why the criterion is not met; empty where it must be met."""

    @property
    def limits(self) -> Band | None:
        """The lower and the upper limit of the number in its unit; None where the number is not compared."""
        if self.error is not None and self.reference is not None:
            return (self.reference - self.error, self.reference + self.error)
        if self.ratio is not None and self.reference is not None:
            low, high = (None if each is None else each * self.reference for each in self.ratio)
            return (low, high) if self.reference > 0 else (high, low)
        return self.band

    @property
    def is_effect(self) -> bool:
        """Whether the number is a change over the values of a key, which chance alone may make."""
        return self.compare in EFFECTS

    @property
    def is_sign_only(self) -> bool:
        """Whether the band of an effect is one-sided: it begins or ends at zero, or is open."""
        return self.is_effect and self.limits is not None and any(not limit for limit in self.limits)


class Criteria(Table):
    """The content of ``criteria.toml``."""

    base: OneLine = ""
    """The folder of a case whose criteria come before those of this file, for the runs of this file.
    Criteria of the base with bands from its own theory are left out, because they follow from its values."""
    level: OneLine = ""
    """The level at which ``flipflow study paper`` runs the case; by default its default level."""
    source: OneLine = ""
    """The common source of the numbers of all criteria."""
    number: Few | None = None
    """The place of the case in a list of benchmarks."""
    happens: OneLine = ""
    """The events in the machine, in words."""
    expected: OneLine = ""
    """The expected consequences, in words."""
    runs: dict[Name, WantedRun]
    """The runs that the criteria need, by name."""
    criteria: tuple[Criterion, ...] = ()
    """The criteria that the runs must meet."""


def read_criteria(case: Path) -> Criteria:
    """Return the criteria of a case, given its folder or its file.  Raises CaseError."""
    folder = case if case.is_dir() else case.parent
    file = folder / FILE
    try:
        criteria = Criteria.model_validate(read_toml(file, folder))
    except ValidationError as error:
        problems = [*from_validation(error, Criteria)]
        raise CaseError([replace(each, file=str(file)) for each in problems]) from None
    if criteria.base:
        criteria = _over_base(criteria, folder)
    if not criteria.criteria:
        raise CaseError([CaseProblem(("criteria",), "missing", file=str(file), kind="missing")])
    known = {
        "run": [*criteria.runs],
        "scatter": ["", *criteria.runs],
        "against": ["", *criteria.runs],
        "measure": Question.words("measure"),
        "compare": ["", *COMPARISONS],
        "take": Question.words("take"),
        "unit": [*UNITS],
    }
    problems = []
    for number, row in enumerate(criteria.criteria):
        for key, words in known.items():
            if (word := getattr(row, key)) not in words:
                hint = did_you_mean(word, filter(None, words))
                problems.append(
                    CaseProblem(
                        ("criteria", number, key), f'no {key} "{word}"', hint, str(file), kind="unknown-name"
                    )
                )
        if row.measure == "amplitude":
            of_component = {"axis": ["", "x", "y", "z"]} | ({} if row.compare else {"unit": ["m", "mm"]})
            for key, words in of_component.items():
                if (word := getattr(row, key)) not in words:
                    wanted_words = ", ".join(filter(None, words))
                    what = f'must be one of {wanted_words} for an amplitude, not "{word}"'
                    problems.append(
                        CaseProblem(("criteria", number, key), what, file=str(file), kind="wrong-type")
                    )
        if row.ratio is not None and not row.reference:
            what = "is in multiples of a reference, which is missing"
            problems.append(CaseProblem(("criteria", number, "ratio"), what, file=str(file), kind="missing"))
        if row.error is not None and row.reference is None:
            what = "is that of a reference, which is missing"
            problems.append(CaseProblem(("criteria", number, "error"), what, file=str(file), kind="missing"))
        if sum(each is not None for each in (row.band, row.ratio, row.error)) > 1:
            what = "another of band, ratio and error is given, too"
            problems.append(CaseProblem(("criteria", number), what, "give one", str(file), kind="conflict"))
    if criteria.source:
        problems += [*_counted_twice(criteria.criteria, str(file))]
    if problems:
        raise CaseError(problems)
    return criteria


def _counted_twice(rows: Sequence[Criterion], file: str) -> Iterator[CaseProblem]:
    """Yield a problem for each predicted number with the reference of an earlier one and no word on the fact.

    Two numbers of ours that are held against one printed number are one fact, unless ``fact`` says otherwise.
    """
    first: dict[tuple[float, str], int] = {}
    for number, row in enumerate(rows):
        if row.ours != "predicted" or row.reference is None or row.limits is None:
            continue
        if row.band_from == "own-theory":
            continue
        earlier = first.setdefault((row.reference, row.unit), number)
        if earlier != number and not (row.fact and rows[earlier].fact):
            what = f"criteria.{earlier} has the same reference, {row.reference:g} {row.unit}, too"
            hint = "name the fact of both: one, if they are the same number of the paper"
            yield CaseProblem(("criteria", number, "fact"), what, hint, file, kind="missing")


def _over_base(criteria: Criteria, folder: Path) -> Criteria:
    """Return criteria with those of their base before them.  Raises CaseError."""
    base = folder / criteria.base
    if not (base / FILE).is_file() or (base / FILE).samefile(folder / FILE):
        what = f'"{criteria.base}" is not another case with {FILE}'
        raise CaseError(
            [CaseProblem(("base",), what, 'for example "../ffs0827-empty"', str(folder / FILE), kind="file")]
        )
    below = read_criteria(base)
    if below.base:
        what = f'"{criteria.base}" has a base of its own'
        raise CaseError([CaseProblem(("base",), what, "name that one", str(folder / FILE))])
    rows = [row for row in below.criteria if row.band_from != "own-theory"]
    merged = {"criteria": (*rows, *criteria.criteria), "runs": {**below.runs, **criteria.runs}}
    return criteria.model_copy(update={**merged, "source": criteria.source or below.source})


def known_answers(case: Path) -> tuple[Criterion, ...]:
    """Return the criteria of a case whose reference is the exact answer for the unchanged case.

    A case without criteria has none.  Raises CaseError.
    """
    folder = case if case.is_dir() else case.parent
    if not (folder / FILE).is_file():
        return ()
    criteria = read_criteria(folder)
    as_it_is = [name for name, run in criteria.runs.items() if run == WantedRun()]
    return tuple(
        row
        for row in criteria.criteria
        if row.exact and row.reference and not row.compare and row.run in as_it_is
    )


def answer_error(row: Criterion, run: Path) -> float | None:
    """Return the relative error of a run against a known answer; None where the run has no such number."""
    try:
        measured = Run(run).number(row) / UNITS[row.unit]
    except Unknown:
        return None
    return abs(measured / row.reference - 1) if row.reference else None


@dataclass(frozen=True)
class Runs:
    """The points of one entry of ``runs``, and the key that is varied among them, if any."""

    points: tuple[Point, ...]
    vary: Vary | None = None

    def at(self, value: str) -> Runs:
        """Return the run of this value alone.  Raises Unknown."""
        points = tuple(each for each in self.points if each.value == value)
        if not points:
            raise Unknown(f"no run with {self.vary.name if self.vary else 'value'} = {value}")
        return Runs(points, self.vary)

    def between(self, limits: tuple[float, float] | None) -> Runs:
        """Return the runs of values in a range, in order of their values.

        Values that are no numbers stay in the order in which they are given; with limits they raise Unknown,
        and so do limits between which there is no value.
        """
        low, high = limits or (-np.inf, np.inf)
        try:
            inside = [each for each in self.points if low <= _number_in(each) <= high]
        except Unknown:
            if limits is None:
                return self
            raise
        if not inside:
            raise Unknown(f"no run has a value from {low:g} to {high:g}")
        return Runs(tuple(sorted(inside, key=_number_in)), self.vary)

    @property
    def values(self) -> Array:
        """The values of the varied key as an array.  Raises Unknown if they are no numbers."""
        return np.array([_number_in(each) for each in self.points])


def _number_in(point: Point) -> float:
    try:
        return float(point.value)
    except ValueError:
        raise Unknown(f'"{point.value}" is not a number') from None


def wanted_runs(
    criteria: Criteria, study: CaseStudy, ended: Callable[[Run], bool] = Run.came_to_its_end
) -> dict[str, Runs]:
    """Check the runs that criteria need, and return them by name; nothing is run here.

    ``ended`` says whether a run is over.  Raises CaseError.
    """
    runs = {}
    for name, wanted in criteria.runs.items():
        sets = [*wanted.sets]
        if wanted.interval_over_safe is not None:
            sets += interval_sets(study, sets, wanted.interval_over_safe)
        vary = parse_vary(wanted.vary) if wanted.vary else None
        own = replace(study, out=study.folder / name)
        points = vary.points(own, sets) if vary else [study.point(name, sets)]
        points = [replace(each, ended=ended) for each in points]
        if wanted.resume_at_s is not None:
            points = [_interrupted(each, wanted.resume_at_s) for each in points]
        runs[name] = Runs(tuple(points), vary)
    return runs


def interval_sets(study: CaseStudy, sets: Sequence[str], multiple: float) -> list[str]:
    """Return the ``--set`` overlays of a sync interval that is ``multiple`` times the largest safe interval.

    Raises CaseError where nothing limits the interval.
    """
    loaded = study.check(sets)
    interval_s = multiple * loaded.safe_interval_s
    if not 0 < interval_s < loaded.tables.duration_s:
        what = f"{multiple:g} times the largest safe sync interval is {interval_s:g} s"
        raise CaseError(
            [CaseProblem(("coupling", "sync_interval_s"), what, file=str(study.case), kind="out-of-range")]
        )
    return [f"coupling.sync_interval_s={interval_s:.3g}"]


def _interrupted(whole: Point, resume_at_s: float) -> Point:
    """Return a point that ends the run of ``whole`` at ``resume_at_s`` and resumes it."""
    first = (*whole.words, "--set", f"duration_s={resume_at_s!r}")
    end = f"duration_s={whole.loaded.tables.duration_s!r}"
    resume = ("resume", str(whole.folder.resolve()), "--set", end)

    def ended(run: Run) -> bool:
        return whole.ended(run) and "resumed" in (run.folder / "provenance.json").read_text(encoding="utf-8")

    return replace(whole, words=first, then=resume, ended=ended)


def evaluate(row: Criterion, runs: Mapping[str, Runs]) -> float:
    """Return the number of a criterion, in SI units.  Raises Unknown."""
    if row.compare == ROW_BY_ROW:
        ours, theirs = (Run(run).dataset(row.of) for _, run in _asked(row, runs))
        if ours.shape != theirs.shape:
            raise Unknown(f"{row.of} has {len(ours)} rows and {len(theirs)}")
        return float(np.abs(ours - theirs).max())
    return _combine(row, runs, np.array([Run(run).number(question) for question, run in _asked(row, runs)]))


def half_width(row: Criterion, runs: Mapping[str, Runs]) -> float | None:
    """Return half the width of the 95 % confidence interval of a criterion's number, in SI units.

    The interval of each run's number comes from the run, or from the ``scatter`` of runs with other seeds, by
    Student's distribution; a comparison adds the intervals of its numbers in quadrature.  None stands for a
    number without an interval.  Raises Unknown.
    """
    if row.compare == ROW_BY_ROW:
        return None
    asked = _asked(row, runs)
    numbers = np.array([Run(run).number(question) for question, run in asked])
    if row.scatter:
        widths = [_scatter(question, runs[row.scatter]) for question, _ in asked]
    else:
        widths = [Run(run).half_width(question) for question, run in asked]
    known = [width for width in widths if width is not None]
    if len(known) < len(widths):
        return None
    if row.compare == DIFFERENCE:  # near zero, its size would move by less
        return float(np.linalg.norm(known))
    whole, changes = _combine(row, runs, numbers), []
    for number, width_of_one in enumerate(known):
        moved = numbers.copy()
        moved[number] += width_of_one
        changes.append(_combine(row, runs, moved) - whole)
    return float(np.linalg.norm(changes))


def _scatter(question: Criterion, runs: Runs) -> float | None:
    """Return half the width of the 95 % interval of one run's number, by the scatter of repeated runs.

    A single run shows none.  Raises Unknown.
    """
    repeated = [point.run.number(question) for point in runs.points]
    if len(repeated) < 2:
        return None
    return float(student_t.ppf(0.975, len(repeated) - 1) * np.std(repeated, ddof=1))


def _asked(row: Criterion, runs: Mapping[str, Runs]) -> list[tuple[Criterion, Path]]:
    """Return the questions that a criterion asks, each with the run that answers it.  Raises Unknown."""
    chosen = _chosen(row, runs)
    if row.compare in OVER_VALUES:
        return [(row, each.folder) for each in chosen.points]
    run = chosen.points[0].folder
    if not row.compare:
        return [(row, run)]
    other = row if row.against else row.model_copy(update={"between_s": row.earlier_s})
    return [(row, run), (other, runs[row.against].points[0].folder if row.against else run)]


def _chosen(row: Criterion, runs: Mapping[str, Runs]) -> Runs:
    """Return the runs from which a criterion takes its numbers.  Raises Unknown."""
    return runs[row.run].at(row.at) if row.at else runs[row.run].between(row.between)


def _combine(row: Criterion, runs: Mapping[str, Runs], numbers: Array) -> float:
    """Return a criterion's number from the numbers (n,) of the runs that it asks."""
    if row.compare in OVER_VALUES:
        return float(OVER_VALUES[row.compare](numbers, _chosen(row, runs)))
    return WITH_ANOTHER[row.compare](*numbers.tolist()) if row.compare else float(numbers[0])


def _lowest_at(numbers: Array, chosen: Runs) -> float:
    """Return the place of the minimum of a parabola through the least number and its neighbours.

    Raises Unknown where the least number is the first or the last one: the minimum may lie beyond.
    """
    least = int(numbers.argmin())
    if least in (0, len(numbers) - 1):
        raise Unknown(f"the least number is at the end of the values, {chosen.values[least]:g}")
    near = slice(least - 1, least + 2)
    a, b, _ = np.polyfit(chosen.values[near], numbers[near], 2)
    return float(-b / (2 * a))


OVER_VALUES: dict[str, Callable[[Array, Runs], float]] = {
    "growth": lambda numbers, chosen: float(numbers[-1]) / float(numbers[0]) - 1,
    "change": lambda numbers, chosen: numbers[-1] - numbers[0],
    "lowest-at": _lowest_at,
}
"""Comparisons of the numbers of all values of a varied key, from the first value to the last."""
EFFECTS = ("growth", "change")
"""Comparisons whose number is zero where nothing changes."""
DIFFERENCE = "difference"
WITH_ANOTHER: dict[str, Callable[[float, float], float]] = {
    "ratio": lambda ours, theirs: ours / theirs,
    DIFFERENCE: lambda ours, theirs: abs(ours - theirs),
}
"""Comparisons with the run ``against``, or with the part ``earlier_s`` of the series."""
ROW_BY_ROW = "row-by-row"  # the largest difference of two datasets
COMPARISONS = (*OVER_VALUES, *WITH_ANOTHER, ROW_BY_ROW)
