"""``study.toml``: what may be changed, what counts, and how much time there is."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from annotated_types import Len
from pydantic import ValidationError

from orchestrator.case.file.errors import CaseError, CaseProblem, did_you_mean, from_validation
from orchestrator.case.file.layers import read_toml
from orchestrator.case.scalars import scalar
from orchestrator.case.tables.quantities import Few, Name, Number, OneLine, Positive, Share, Table, Whole
from orchestrator.studies.design import formulas, plans
from orchestrator.studies.design.aim import Aim, Goal, Limit
from orchestrator.studies.design.formulas import BadFormula
from orchestrator.studies.design.models import SURROGATES
from orchestrator.studies.design.optimisers import OPTIMISERS
from orchestrator.studies.design.scales import SCALES
from orchestrator.studies.design.space import Array, Space

PLANS = ("sobol", "box-behnken", "latin-hypercube", "factorial", "none")
MOST_CORNERS = 64  # of the ranges that are checked as cases
GOAL = re.compile(r"(maximise|maximize|minimise|minimize) +(\S+)")
LIMIT = re.compile(r"(\S+) *(>=|<=) *(\S+)")


class FactorTable(Table):
    """Something that may be changed."""

    range: tuple[Number, Number]
    """From, to."""
    unit: OneLine = ""
    """For tables and pictures."""
    simpler: Number | None = None
    """The value that it has in a simpler design, which is run beside the winner."""


class ResponseTable(Table):
    """A number of a run that counts."""

    result: OneLine
    """Its short name, as ``flipflow run`` says it, or its keys in summary.json with dots."""
    unit: OneLine = ""
    """For tables and pictures."""
    scale: Literal["plain", "percent", "logarithm"] = "plain"
    """How surrogates see it: percents of a whole by their logit, so that none beyond 0 and 100 is predicted;
    positive numbers that span decades by their logarithm."""
    noise: Positive | None = None
    """Standard deviation of one run's value, where the run itself gives no interval."""


class PlanTable(Table):
    """The settings that are run first."""

    kind: Literal["sobol", "box-behnken", "latin-hypercube", "factorial", "none"] = "sobol"
    runs: Few | None = None
    """How many settings, of plans that leave the choice; by default eight for each two factors."""
    levels: Few = 3
    """Of each factor, in a factorial."""
    centres: Few = 3
    """Runs at the centre, each with other seeds: they tell the noise."""


class SearchTable(Table):
    """The settings that are run then, one after the other, each where the most is to be gained."""

    runs: Whole | None = None
    """At most so many; by default as long as the budget lasts."""
    surrogate: OneLine = "gaussian-process"
    optimiser: OneLine = "expected-improvement"


class StudyFile(Table):
    """A design study."""

    title: OneLine = ""
    case: OneLine
    """The folder of the case, from that of this file."""
    level: OneLine = ""
    """The case's level; by default the case's own choice."""
    overrides: tuple[OneLine, ...] = ()
    """``--set`` of all runs."""
    factors: Annotated[dict[Name, FactorTable], Len(1)]
    """What may be changed, by name."""
    set: Annotated[dict[OneLine, OneLine | tuple[OneLine, ...]], Len(1)]
    """Values of the case's keys, as arithmetic of factors; several for a list."""
    ordered: tuple[tuple[Name, ...], ...] = ()
    """Chains of factors whose values must not rise."""
    responses: Annotated[dict[Name, ResponseTable], Len(1)]
    """What is measured, by name."""
    goals: tuple[OneLine, ...] = ()
    """One or two of ``maximise RESPONSE``, ``minimise RESPONSE``."""
    limits: tuple[OneLine, ...] = ()
    """``RESPONSE >= VALUE``, ``RESPONSE <= VALUE``."""
    confidence: Share = 0.9
    """The probability with which what is recommended must keep the limits."""
    hours: Positive | None = None
    """Wall time for all runs."""
    seed: Whole = 1
    plan: PlanTable = PlanTable()
    search: SearchTable = SearchTable()


@dataclass(frozen=True)
class Study:
    """A study as it was asked for, read and found to make sense."""

    file: StudyFile
    folder: Path
    space: Space
    aim: Aim
    formulas: Mapping[str, tuple[formulas.ast.expr, ...]]

    @property
    def case(self) -> Path:
        """The case's folder."""
        return (self.folder / self.file.case).resolve()

    def overlays(self, coded: Array) -> list[str]:
        """List the ``--set`` overlays of a coded setting.

        Raises
        ------
        BadFormula : a formula has no value there.
        """
        actual = dict(zip(self.file.factors, map(float, self.space.actual(coded)), strict=True))
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


def read_study(path: Path) -> Study:
    """Read a study's file, or that of a folder.

    Raises
    ------
    CaseError : with all that is wrong in it.
    """
    path = path / "study.toml" if path.is_dir() else path
    try:
        file = StudyFile.model_validate(read_toml(path, path.parent))
    except ValidationError as error:
        raise CaseError(from_validation(error, StudyFile)) from None
    problems: list[CaseProblem] = []
    parsed = _formulas(file, problems)
    chains = _chains(file, problems)
    aim = _aim(file, problems)
    _check_plain(file, problems)
    if problems:
        raise CaseError(CaseProblem(p.key, p.what, p.hint, str(path)) for p in problems)
    low, high = np.array([factor.range for factor in file.factors.values()]).T
    return Study(file, path.parent, Space(low, high, chains), aim, parsed)


def _check_plain(file: StudyFile, problems: list[CaseProblem]) -> None:
    for name, factor in file.factors.items():
        low, high = factor.range
        if not low < high:
            problems.append(CaseProblem(("factors", name, "range"), f"{low:g} is not below {high:g}"))
    for name, response in file.responses.items():
        try:
            scalar(response.result)
        except KeyError as error:
            problems.append(CaseProblem(("responses", name, "result"), str(error.args[0])))
    for key, known in (("surrogate", SURROGATES), ("optimiser", OPTIMISERS)):
        if (word := getattr(file.search, key)) not in known:
            problems.append(CaseProblem(("search", key), f'no {key} "{word}"', did_you_mean(word, known)))
    if file.plan.kind == "box-behnken":
        try:
            plans.box_behnken(len(file.factors))
        except ValueError as error:
            problems.append(CaseProblem(("plan", "kind"), str(error)))
        if file.ordered:
            problems.append(CaseProblem(("plan", "kind"), "a Box-Behnken design has no ordered factors"))


def _formulas(file: StudyFile, problems: list[CaseProblem]) -> dict[str, tuple[formulas.ast.expr, ...]]:
    parsed: dict[str, tuple[formulas.ast.expr, ...]] = {}
    used: set[str] = set()
    for key, written in file.set.items():
        texts = (written,) if isinstance(written, str) else written
        try:
            parsed[key] = tuple(map(formulas.parse, texts))
        except BadFormula as error:
            problems.append(CaseProblem(("set", key), str(error)))
            continue
        names = set(itertools.chain(*map(formulas.names_in, parsed[key])))
        used |= names
        for name in sorted(names - file.factors.keys()):
            problems.append(
                CaseProblem(("set", key), f'no factor "{name}"', did_you_mean(name, file.factors))
            )
    for name in file.factors.keys() - used if len(parsed) == len(file.set) else ():
        problems.append(CaseProblem(("factors", name), "no formula of [set] uses it"))
    return parsed


def _chains(file: StudyFile, problems: list[CaseProblem]) -> tuple[tuple[int, ...], ...]:
    numbers = {name: number for number, name in enumerate(file.factors)}
    chains = []
    for place, chain in enumerate(file.ordered):
        key = ("ordered", place)
        if unknown := [name for name in chain if name not in numbers]:
            problems.append(CaseProblem(key, f'no factor "{unknown[0]}"', did_you_mean(unknown[0], numbers)))
        elif len({file.factors[name].range for name in chain}) > 1:
            problems.append(CaseProblem(key, "ordered factors must have one range"))
        elif len(set(chain)) < len(chain) or set(chain) & {
            name for other in file.ordered[:place] for name in other
        }:
            problems.append(CaseProblem(key, "a factor stands in it twice, or in another chain"))
        else:
            chains.append(tuple(numbers[name] for name in chain))
    return tuple(chains)


def _aim(file: StudyFile, problems: list[CaseProblem]) -> Aim:
    numbers = {name: number for number, name in enumerate(file.responses)}
    goals, limits = [], []

    def known(name: str, key: tuple[str, int]) -> bool:
        if name not in numbers:
            problems.append(CaseProblem(key, f'no response "{name}"', did_you_mean(name, numbers)))
        return name in numbers

    for place, text in enumerate(file.goals):
        if not (match := GOAL.fullmatch(text.strip())):
            hint = '"maximise RESPONSE" or "minimise RESPONSE" is wanted'
            problems.append(CaseProblem(("goals", place), f'"{text}" is no goal', hint))
        elif known(match[2], ("goals", place)):
            goals.append(Goal(numbers[match[2]], 1.0 if match[1].startswith("max") else -1.0))
    for place, text in enumerate(file.limits):
        match = LIMIT.fullmatch(text.strip())
        try:
            number = float(match[3]) if match else np.nan
        except ValueError:
            number = np.nan
        if match is None or not np.isfinite(number):
            hint = '"RESPONSE >= NUMBER" or "RESPONSE <= NUMBER" is wanted'
            problems.append(CaseProblem(("limits", place), f'"{text}" is no limit', hint))
        elif known(match[1], ("limits", place)):
            scale = SCALES[file.responses[match[1]].scale]
            limits.append(
                Limit(numbers[match[1]], 1.0 if match[2] == ">=" else -1.0, float(scale.to_fit(number)))
            )
    if len(goals) > 2:
        problems.append(CaseProblem(("goals",), "more than two goals", "make some of them limits"))
    if {goal.response for goal in goals} & {limit.response for limit in limits}:
        problems.append(CaseProblem(("goals",), "a response is a goal and has a limit"))
    if not goals and file.search.runs != 0:
        problems.append(CaseProblem(("goals",), "nothing to search for", 'give a goal, or "search.runs = 0"'))
    return Aim(tuple(goals), tuple(limits), file.confidence)
