"""``study.toml``: what may be changed, what counts, and how much time there is."""

from __future__ import annotations

import ast
import itertools
import math
import os
import re
import sys
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from annotated_types import Ge, Len, Lt
from pydantic import Field, Strict, ValidationError

from orchestrator.studies.design import formulas, plans
from orchestrator.studies.design.aim import Aim, Goal, Limit
from orchestrator.studies.design.formulas import BadFormula
from orchestrator.studies.design.models import SURROGATES
from orchestrator.studies.design.optimisers import OPTIMISERS
from orchestrator.studies.design.scales import SCALES
from orchestrator.studies.design.space import SimplerSpace, Space
from orchestrator.workbench import CaseError, CaseProblem, Run
from orchestrator.workbench.vocabulary import (
    Array,
    Few,
    Name,
    Number,
    OneLine,
    Positive,
    Table,
    Whole,
    did_you_mean,
    from_validation,
    read_toml,
    same_unit,
    show_value,
)

Seed = Annotated[int, Strict(), Ge(0), Lt(2**32)]  # what surrogates take
NARROWEST = 1e-9  # of a range, over its larger end
MOST_CORNERS = 64  # of the ranges that are checked as cases
MOST_SETTINGS = 10_000  # of a factorial: far more than anybody runs
POSSIBLE = {  # limits on each scale: above, below, and both in words
    "plain": (-math.inf, math.inf, ""),
    "percent": (0.0, 100.0, "between 0 and 100"),
    "logarithm": (0.0, math.inf, "above 0"),
}
GOAL = re.compile(r"(maximise|maximize|minimise|minimize) +(\S+)")
ROUNDING = 1e-9  # of coded settings
TABLES = {*("factors", "set", "derived", "responses", "simpler", "plan", "cheap", "search", "published")}
NO_RESPONSE = -1  # of a limit that names none
COLUMNS = (  # of points.csv
    *("trial", "stage", "role", "seed", "status", "why_no_data", "not_steady", "particle_steps"),
)
LIMIT = re.compile(r"(\S+) *(>=|<=) *(.+)")


class StudyError(CaseError):
    """An error for a study that cannot be made as its file says; ``problems`` lists every reason."""

    where = "in the study"


class FactorTable(Table):
    """What may be changed."""

    range: tuple[Number, Number]
    """Lower and upper end."""
    unit: OneLine = ""
    """For tables and pictures."""


class ResponseTable(Table):
    """What counts."""

    result: OneLine = ""
    """Short name or keys with dots of a result, or a table's column; by default its own name."""
    unit: OneLine = ""
    """That of the result."""
    scale: Literal["plain", "percent", "logarithm"] = "plain"
    """For surrogates: percents of a whole by logit, numbers over decades by logarithm."""
    noise: Positive | None = None
    """Standard deviation, where a run gives no interval."""
    steady: bool = False
    """Whether only a steady run counts."""
    target: Number | None = None
    """Measured value that the factors are to meet, for ``flipflow study calibrate``."""
    target_deviation: Positive | None = None
    """Its standard deviation."""


class PlanTable(Table):
    """The settings that are run first."""

    kind: Literal["sobol", "box-behnken", "latin-hypercube", "factorial", "none"] = "sobol"
    """How they are chosen; ``box-behnken``: 3 to 7 factors, not ordered."""
    runs: Few | None = None
    """By default four for each factor."""
    levels: Few = 3
    """Of each factor in a ``factorial``."""
    centres: Few = 3
    """Runs at the centre, whose scatter is the noise."""


class CheapTable(Table):
    """Cheaper runs that help to predict."""

    level: OneLine
    """Their level."""
    overrides: tuple[OneLine, ...] = ()
    """``--set`` besides those of all."""
    runs: Few
    """Number over the ranges."""


class SearchTable(Table):
    """The settings after the plan."""

    runs: Whole | None = None
    """By default by the hours, else as the plan."""
    surrogate: OneLine = "gaussian-process"
    """``gaussian-process``, ``quadratic`` or ``network``."""
    optimiser: OneLine = "expected-improvement"
    """``expected-improvement``, ``whale``, ``gradient`` or ``sobol``."""


class PublishedTable(Table):
    """Published runs, shown beside the study's."""

    source: OneLine
    """Their source."""
    response: Name
    """Response."""
    table: OneLine
    """CSV file like ``table``."""


class StudyFile(Table):
    """A design study."""

    title: OneLine = ""
    """Of the page."""
    case: OneLine = ""
    """Folder of the case."""
    table: OneLine = ""
    """Instead of a case: CSV file with factors, responses and perhaps ``<response> deviation``, the
    noise's standard deviation."""
    level: OneLine = ""
    """By default the case's choice."""
    overrides: tuple[OneLine, ...] = ()
    """``--set`` of all runs."""
    factors: Annotated[dict[Name, FactorTable], Len(1)]
    """What may be changed, by name."""
    set: dict[OneLine, OneLine | tuple[OneLine, ...]] = Field(default_factory=dict)
    """Keys of the case as formulas."""
    derived: dict[Name, OneLine] = Field(default_factory=dict)
    """Numbers for ``set``, as formulas."""
    ordered: tuple[tuple[Name, ...], ...] = ()
    """Chains of factors that must not rise."""
    responses: Annotated[dict[Name, ResponseTable], Len(1)]
    """What is measured, by name."""
    goals: tuple[OneLine, ...] = ()
    """One or two ``maximise RESPONSE``, ``minimise RESPONSE``; the first decides."""
    limits: tuple[OneLine, ...] = ()
    """``RESPONSE >= VALUE``, ``RESPONSE <= VALUE``; several values of one get a setting each."""
    simpler: dict[Name, OneLine] = Field(default_factory=dict)
    """Factors of a simpler design as formulas; its best is run, too."""
    confidence: Annotated[float, Strict(), Ge(0.5), Lt(1)] = 0.9
    """Probability with which limits must be kept; 0.5: no margin."""
    hours: Positive | None = None
    """Wall time for all runs."""
    seed: Seed = 1
    """Of plans, surrogates, optimisers and runs."""
    plan: PlanTable = PlanTable()
    """The settings that are run first."""
    cheap: CheapTable | None = None
    """Runs at a cheaper level."""
    search: SearchTable = SearchTable()
    """The settings that are run after the plan."""
    published: tuple[PublishedTable, ...] = ()
    """Printed results to be compared with the data."""


@dataclass(frozen=True)
class Study:
    """A study as it was requested, read and checked.

    ``source`` is the file.  ``aims`` has one entry, named "", or one for each value of a limit that has
    several, named by the limit.
    """

    file: StudyFile
    source: Path
    space: Space
    aims: Mapping[str, Aim]
    derived: Mapping[str, ast.expr]
    formulas: Mapping[str, tuple[ast.expr, ...]]
    simpler: Mapping[str, ast.expr]

    @property
    def aim(self) -> Aim:
        """The first of the aims."""
        return next(iter(self.aims.values()))

    @property
    def name(self) -> str:
        """The name of the study, and of its folder in ``runs/``: that of the case and that of the file."""
        case = self.path(self.file.case or self.file.table).stem
        return case if case == self.source.stem else f"{case}-{self.source.stem}"

    @property
    def folder(self) -> Path:
        """The folder of the file."""
        return self.source.parent

    def path(self, name: str) -> Path:
        """Return a path that the file gives from its own folder."""
        return (self.folder / name).resolve()

    def table_for(self, folder: Path) -> dict[str, Any]:
        """Return the file's content with all defaults; its paths start from a folder."""
        table = self.file.model_dump(mode="json", exclude_none=True)
        for place in (table, *table["published"]):
            for key in ("case", "table"):
                if place.get(key):
                    place[key] = os.path.relpath(self.path(place[key]), folder.resolve())
        return table

    def actual(self, coded: Array) -> dict[str, float]:
        """Return a coded setting, (factors,), in the units of the factors, by their names."""
        return dict(zip(self.file.factors, map(float, self.space.actual(coded)), strict=True))

    def overlays(self, setting: Mapping[str, float]) -> list[str]:
        """List the ``--set`` overlays of a setting in the factors' units.

        Raises BadFormula where a formula has no value.
        """
        actual = dict(setting)
        for name, expression in self.derived.items():
            actual[name] = formulas.value(expression, actual)
        overlays = []
        for key, expressions in self.formulas.items():
            values = [formulas.value(each, actual) for each in expressions]
            text = repr(values[0]) if isinstance(self.file.set[key], str) else str(values)
            overlays.append(f"{key}={text}")
        return [*self.file.overrides, *overlays]

    def corners(self) -> Iterator[Array]:
        """Yield the corners of the space: all up to 64, else a spread choice of them, in a fixed order."""
        count = 2**self.space.factors
        numbers = (
            range(count) if count <= MOST_CORNERS else np.linspace(0, count - 1, MOST_CORNERS).astype(int)
        )
        seen = set()
        for number in numbers:
            signs = [1.0 if int(number) >> i & 1 else -1.0 for i in range(self.space.factors)]
            corner = self.space.ordered(np.array([signs]))[0]
            if tuple(corner) not in seen:
                seen.add(tuple(corner))
                yield corner

    def simpler_space(self) -> Space:
        """Return the part of the space that simpler designs are: its factors follow from the others."""
        return SimplerSpace(self.space.low, self.space.high, self.space.chains, self._simplify)

    def check_simpler(self, coded: Array) -> None:
        """Raise BadFormula where the formulas of ``simpler`` make no design of a setting, (factors,)."""
        simple = self._simplify(self.space.ordered(coded[None]))[0]
        moved = np.abs(self.space.ordered(simple[None])[0] - simple)
        if moved.max() > ROUNDING:
            name, value = list(self.actual(simple).items())[int(moved.argmax())]
            raise BadFormula(f"{name} = {value:g} of [simpler] is out of its range or order")

    def _simplify(self, coded: Array) -> Array:
        """Put the formulas of ``simpler`` into settings, (n, factors)."""
        names, actual = list(self.file.factors), self.space.actual(coded)
        for row in actual:
            values = dict(zip(names, map(float, row), strict=True))
            for name, expression in self.simpler.items():
                row[names.index(name)] = formulas.value(expression, values)
        return self.space.coded(actual)


def read_study(path: Path) -> Study:
    """Read the file of a study, or ``study.toml`` in a folder.

    Raises StudyError with every problem of the file.
    """
    path = path / "study.toml" if path.is_dir() else path
    problems: list[CaseProblem] = []
    try:
        file = StudyFile.model_validate(read_toml(path, path.parent))
    except ValidationError as error:
        raise StudyError(_placed(from_validation(error, StudyFile), path)) from None
    except CaseError as error:
        raise StudyError(error.problems) from None
    derived, simpler = _derived(file, problems), _simpler(file, problems)
    parsed = _formulas(file, derived, problems)
    chains, aims = _chains(file, problems), _aims(file, problems)
    _check_source(file, problems)
    _check_overrides(file, problems)
    _check_factors_and_responses(file, problems)
    _check_names(file, problems)
    _check_methods(file, problems)
    if problems:
        raise StudyError(_placed(problems, path))
    low, high = np.array([factor.range for factor in file.factors.values()]).T
    study = Study(file, path.resolve(), Space(low, high, chains), aims, derived, parsed, simpler)
    if file.table:  # settings of a case are checked with the case
        _check_simpler_corners(study, str(path))
    return study


def _placed(problems: Iterable[CaseProblem], path: Path) -> list[CaseProblem]:
    """Return problems with the file, and with a hint where a key of the whole study stands in a table."""
    return list(dict.fromkeys(replace(_with_its_place(each), file=str(path)) for each in problems))


def _with_its_place(problem: CaseProblem) -> CaseProblem:
    alone, key = StudyFile.model_fields.keys() - TABLES, problem.key
    hint = "a key of the whole study belongs before the first [table]"
    if key[:1] == ("set",) and alone.intersection(key[1:2]):
        return CaseProblem(key[:2], "is not a key of a case", hint, kind="unknown-key")
    if len(key) > 1 and key[-1] in alone and problem.what.startswith("unknown key"):
        other = f"; or {problem.hint}" if problem.hint.startswith("did you mean") else ""
        return replace(problem, hint=hint + other)
    return problem


def _check_simpler_corners(study: Study, path: str) -> None:
    """Raise StudyError where the formulas of ``simpler`` make no design of the centre or of a corner."""
    for corner in (np.zeros(study.space.factors), *study.corners()):
        try:
            study.check_simpler(corner)
        except BadFormula as error:
            named = ", ".join(f"{name} = {value:g}" for name, value in study.actual(corner).items())
            raise StudyError([CaseProblem(("simpler",), f"{named}: {error}", file=path)]) from None


def _check_source(file: StudyFile, problems: list[CaseProblem]) -> None:
    """Check that the data come either from runs of a case or from a table."""
    if bool(file.case) == bool(file.table):
        problems.append(CaseProblem(("case",), "give one of case and table"))
    elif file.table and file.set:
        problems.append(CaseProblem(("set",), "the data of a table are not run"))
    elif file.case and not file.set:
        problems.append(CaseProblem(("set",), "no key of the case depends on a factor"))


def _check_overrides(file: StudyFile, problems: list[CaseProblem]) -> None:
    """Check that no override is of a key that a formula sets: one of the two would be without effect.

    Formulas come after the overrides of all runs and before those of the cheap level.
    """
    cheap = file.cheap.overrides if file.cheap else ()
    for place, texts in ((("overrides",), file.overrides), (("cheap", "overrides"), cheap)):
        for number, key in enumerate(text.partition("=")[0].strip() for text in texts):
            for other in file.set:
                above = place[0] == "cheap" and other.startswith(f"{key}.")
                if above or f"{key}.".startswith(f"{other}."):
                    problems.append(
                        CaseProblem((*place, number), f"a formula sets {other}, too", "remove one of them")
                    )


def _check_factors_and_responses(file: StudyFile, problems: list[CaseProblem]) -> None:
    for name, factor in file.factors.items():
        low, high = factor.range
        if not low < high:
            problems.append(
                CaseProblem(("factors", name, "range"), f"{low:g} is not below {high:g}", kind="out-of-range")
            )
        elif high - low < max(NARROWEST * max(abs(low), abs(high)), sys.float_info.min):
            what = f"{low!r} to {high!r} differ only by rounding"
            problems.append(CaseProblem(("factors", name, "range"), what, kind="out-of-range"))
    for name, response in file.responses.items():
        problems.extend(_wrong_target(name, response))
        try:
            problems.extend(_unlike_its_result(name, response) if file.case else ())
        except KeyError as error:
            problems.append(
                CaseProblem(("responses", name, "result"), str(error.args[0]), kind="unknown-name")
            )
    for place, table in enumerate(file.published):
        if table.response not in file.responses:
            hint = did_you_mean(table.response, file.responses)
            key = ("published", place, "response")
            problems.append(CaseProblem(key, f'no response "{table.response}"', hint, kind="unknown-name"))


def _unlike_its_result(name: str, response: ResponseTable) -> Iterator[CaseProblem]:
    """Yield what is wrong with the unit and the scale of a response where the unit of its result is known.

    Raises KeyError where there is no such result.
    """
    result = response.result or name
    known = Run.named(result)
    unit = known.figure.unit
    if unit == "1" or not (known.is_short or result.startswith(("results.", "probes."))):
        return
    if response.unit and not same_unit(response.unit, unit):
        what = f'"{response.unit}" is not the unit of {result}, which is in {unit}'
        hint = f'nothing is converted: write "{unit}", and goals and limits in it'
        yield CaseProblem(("responses", name, "unit"), what, hint)
    if response.scale == "percent" and unit != "%":
        what = f"percent is for results in %, and {result} is in {unit}"
        yield CaseProblem(("responses", name, "scale"), what, "take plain or logarithm")


def _wrong_target(name: str, response: ResponseTable) -> Iterator[CaseProblem]:
    if (response.target is None) != (response.target_deviation is None):
        missing = "target" if response.target is None else "target_deviation"
        yield CaseProblem(("responses", name, missing), "missing", "give both", kind="missing")
    elif response.target is not None and not SCALES[response.scale].has(response.target):
        what = f"{response.target:g} is not on the scale {response.scale}"
        yield CaseProblem(("responses", name, "target"), what, kind="out-of-range")


def _check_names(file: StudyFile, problems: list[CaseProblem]) -> None:
    """Check that every column of the tables, and every word of a formula, has one meaning."""
    for kind in ("factors", "derived"):
        for name in getattr(file, kind).keys() & set(formulas.CONSTANTS):
            problems.append(
                CaseProblem((kind, name), f"{name} is a constant of formulas", "take another name")
            )
    for kind in ("factors", "responses"):
        for name in getattr(file, kind).keys() & set(COLUMNS):
            hint = f"take another name than {', '.join(COLUMNS)}"
            problems.append(CaseProblem((kind, name), "points.csv has another column of this name", hint))
    for name in file.responses.keys() & file.factors.keys():
        problems.append(CaseProblem(("responses", name), "a factor has the same name", "take another name"))


def _check_methods(file: StudyFile, problems: list[CaseProblem]) -> None:
    """Check the names of plans, surrogates and optimisers, and what they can do."""
    for key, known in (("surrogate", SURROGATES), ("optimiser", OPTIMISERS)):
        if (word := getattr(file.search, key)) not in known:
            problems.append(
                CaseProblem(
                    ("search", key), f'no {key} "{word}"', did_you_mean(word, known), kind="unknown-name"
                )
            )
    levels, factors = file.plan.levels, len(file.factors)
    if file.plan.kind == "factorial" and levels**factors > MOST_SETTINGS:
        what = f"{levels} values of each of {factors} factors make {show_value(levels**factors)} runs"
        hint = f"a factorial has {MOST_SETTINGS} at most; sobol has as many as are asked for"
        problems.append(CaseProblem(("plan", "levels"), what, hint, kind="out-of-range"))
    if file.plan.kind == "box-behnken":
        try:
            plans.box_behnken(factors)
        except ValueError as error:
            problems.append(CaseProblem(("plan", "kind"), str(error)))
        if file.ordered:
            problems.append(CaseProblem(("plan", "kind"), "a Box-Behnken design has no ordered factors"))


def _derived(file: StudyFile, problems: list[CaseProblem]) -> dict[str, ast.expr]:
    """Parse the derived numbers; each may use factors and the numbers above it."""
    parsed: dict[str, ast.expr] = {}
    for name, text in file.derived.items():
        key = ("derived", name)
        if name in file.factors:
            problems.append(CaseProblem(key, "is the name of a factor, too"))
        try:
            expression = formulas.parse(text)
        except BadFormula as error:
            problems.append(CaseProblem(key, str(error), kind="wrong-type"))
            continue
        known = [*file.factors, *parsed]
        for used in sorted(formulas.names_in(expression) - set(known)):
            hint = did_you_mean(used, known)
            problems.append(
                CaseProblem(key, f'no factor or number above is called "{used}"', hint, kind="unknown-name")
            )
        parsed[name] = expression
    return parsed


def _formulas(
    file: StudyFile, derived: Mapping[str, ast.expr], problems: list[CaseProblem]
) -> dict[str, tuple[ast.expr, ...]]:
    parsed: dict[str, tuple[ast.expr, ...]] = {}
    used = set(itertools.chain(*map(formulas.names_in, derived.values())))
    known = file.factors.keys() | file.derived.keys()
    for key, written in file.set.items():
        for other in file.set:
            if key.startswith(f"{other}."):
                problems.append(
                    CaseProblem(("set", key), f"another formula sets {other}", "remove one of them")
                )
        texts = (written,) if isinstance(written, str) else written
        try:
            parsed[key] = tuple(map(formulas.parse, texts))
        except BadFormula as error:
            problems.append(CaseProblem(("set", key), str(error), kind="wrong-type"))
            continue
        names = set(itertools.chain(*map(formulas.names_in, parsed[key])))
        used |= names
        for name in sorted(names - known):
            hint = did_you_mean(name, known)
            problems.append(CaseProblem(("set", key), f'no factor "{name}"', hint, kind="unknown-name"))
    if file.set and len(parsed) == len(file.set) and used <= known:
        for name in file.factors:
            if name not in used and name not in formulas.CONSTANTS:
                problems.append(CaseProblem(("factors", name), "no formula of [set] uses it"))
    return parsed


def _simpler(file: StudyFile, problems: list[CaseProblem]) -> dict[str, ast.expr]:
    """Parse the formulas of a simpler design; they may use only the factors that are left free."""
    parsed: dict[str, ast.expr] = {}
    for name, text in file.simpler.items():
        key = ("simpler", name)
        if name not in file.factors:
            hint = did_you_mean(name, file.factors)
            problems.append(CaseProblem(key, f'no factor "{name}"', hint, kind="unknown-name"))
        try:
            parsed[name] = formulas.parse(text)
        except BadFormula as error:
            problems.append(CaseProblem(key, str(error), kind="wrong-type"))
            continue
        free = file.factors.keys() - file.simpler.keys()
        for used in sorted(formulas.names_in(parsed[name]) - free):
            hint = did_you_mean(used, free, "factors that are left")
            problems.append(
                CaseProblem(key, f'"{used}" is not a factor of the simpler design', hint, kind="unknown-name")
            )
    return parsed


def _chains(file: StudyFile, problems: list[CaseProblem]) -> tuple[tuple[int, ...], ...]:
    numbers = {name: number for number, name in enumerate(file.factors)}
    chains = []
    for place, chain in enumerate(file.ordered):
        key = ("ordered", place)
        others = {name for other in file.ordered[:place] for name in other}
        if unknown := [name for name in chain if name not in numbers]:
            problems.append(
                CaseProblem(
                    key, f'no factor "{unknown[0]}"', did_you_mean(unknown[0], numbers), kind="unknown-name"
                )
            )
        elif len({file.factors[name].range for name in chain}) > 1:
            problems.append(CaseProblem(key, "ordered factors must have the same range"))
        elif len(set(chain)) < len(chain) or set(chain) & others:
            problems.append(CaseProblem(key, "a factor is in it twice, or in another chain"))
        else:
            chains.append(tuple(numbers[name] for name in chain))
    return tuple(chains)


def _aims(file: StudyFile, problems: list[CaseProblem]) -> dict[str, Aim]:
    """Parse goals and limits into one aim, or one for each value of the limit that has several."""
    goals = _goals(file, problems)
    limits = [_limits(file, place, text, problems) for place, text in enumerate(file.limits)]
    wanted = {goal.response for goal in goals}
    if len(goals) > 2:
        problems.append(CaseProblem(("goals",), "more than two goals", "make some of them limits"))
    elif len(wanted) < len(goals):
        problems.append(CaseProblem(("goals",), "two goals for one response", "leave one of them out"))
    limited = {limit.response for each in limits for limit in each.values()}
    if wanted & limited:
        problems.append(CaseProblem(("goals",), "a response is a goal and has a limit", "remove one of them"))
    has_target = any(response.target is not None for response in file.responses.values())
    if not file.goals and not has_target and file.case and file.search.runs != 0:
        hint = 'give a goal, a target of a response, or "search.runs = 0"'
        problems.append(CaseProblem(("goals",), "nothing to search for", hint))
    if sum(len(each) > 1 for each in limits) > 1:
        problems.append(
            CaseProblem(
                ("limits",), "more than one limit has several values", "give one value to all but one"
            )
        )
    aims = {}
    for chosen in itertools.product(*(each.items() for each in limits)):
        of_several = [text for (text, _), each in zip(chosen, limits, strict=True) if len(each) > 1]
        aims["".join(of_several)] = Aim(tuple(goals), tuple(limit for _, limit in chosen), file.confidence)
    return aims


def _goals(file: StudyFile, problems: list[CaseProblem]) -> list[Goal]:
    goals = []
    for place, text in enumerate(file.goals):
        if not (match := GOAL.fullmatch(text.strip())):
            hint = 'write "maximise RESPONSE" or "minimise RESPONSE"'
            problems.append(CaseProblem(("goals", place), f'"{text}" is not a goal', hint, kind="wrong-type"))
        elif (number := _response(file, match[2], ("goals", place), problems)) is not None:
            goals.append(Goal(number, 1.0 if match[1].startswith("max") else -1.0))
    return goals


def _limits(file: StudyFile, place: int, text: str, problems: list[CaseProblem]) -> dict[str, Limit]:
    """Parse one line of ``limits`` into a limit for each of its values, named by its text."""
    match, limits = LIMIT.fullmatch(text.strip()), {}
    try:
        values = [float(value) for value in match[3].split(",")] if match else [math.nan]
    except ValueError:
        values = [math.nan]
    if match is None or not np.isfinite(values).all():
        hint = 'write "RESPONSE >= NUMBER" or "RESPONSE <= NUMBER"'
        problems.append(CaseProblem(("limits", place), f'"{text}" is not a limit', hint, kind="wrong-type"))
    elif (number := _response(file, match[1], ("limits", place), problems)) is not None:
        scale, sign = file.responses[match[1]].scale, 1.0 if match[2] == ">=" else -1.0
        low, high, range_in_words = POSSIBLE[scale]
        to_fit = SCALES[scale].to_fit
        for value in values:
            if not low < value < high:
                what = f"{value:g} is impossible: the scale of {match[1]} is {scale}, {range_in_words}"
                problems.append(CaseProblem(("limits", place), what, kind="out-of-range"))
            limits[f"{match[1]} {match[2]} {value:g}"] = Limit(number, sign, float(to_fit(value)))
    return limits or {text: Limit(NO_RESPONSE, 1.0, math.nan)}


def _response(file: StudyFile, name: str, key: tuple[str, int], problems: list[CaseProblem]) -> int | None:
    names = list(file.responses)
    if name in names:
        return names.index(name)
    problems.append(CaseProblem(key, f'no response "{name}"', did_you_mean(name, names), kind="unknown-name"))
    return None
