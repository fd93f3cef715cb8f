"""The plan of a sweep over several keys: all combinations of values, a list, or random settings."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum

import numpy as np

from orchestrator.studies.points import (
    MOST_VALUES,
    CaseStudy,
    Point,
    Vary,
    parse_vary,
    vary_of,
    with_one_unit,
)
from orchestrator.workbench import CaseError, CaseProblem
from orchestrator.workbench.vocabulary import split_quantity

DRAWS = (1, 10, 100)  # times as many as settings are wanted, one after the other until enough are different
DIGITS = 4  # of random values, which are also names of folders; narrow ranges have more


class Arrangement(StrEnum):
    """The way in which the values of several keys are put together."""

    GRID = "grid"
    LIST = "list"
    RANDOM = "random"


@dataclass(frozen=True)
class SweepPlan:
    """The settings of a sweep: one value, as text, for each of the ``keys`` in each of the ``settings``.

    ``given`` has by key the texts of values that were given with a unit.
    """

    keys: tuple[str, ...]
    settings: tuple[tuple[str, ...], ...]
    given: Mapping[str, Mapping[str, str]] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """The last words of the keys."""
        return "-".join(Vary(key, ()).name for key in self.keys)

    def points(self, study: CaseStudy) -> list[Point]:
        """Return the point of each setting; nothing is run here.

        Raises CaseError if the case is wrong with one of the settings.
        """
        return [
            study.point(
                name(setting),
                [f"{key}={value}" for key, value in zip(self.keys, setting, strict=True)],
                "_".join(
                    Vary(key, (), self.given.get(key, {})).folder(v)
                    for key, v in zip(self.keys, setting, strict=True)
                ),
            )
            for setting in self.settings
        ]

    def setting_of(self, point: Point) -> dict[str, str]:
        """Return the value of each key at a point."""
        (setting,) = (each for each in self.settings if name(each) == point.value)
        return dict(zip(self.keys, setting, strict=True))

    def given_of(self, point: Point) -> dict[str, str]:
        """Return the values at a point that were given with a unit, by key, with their units."""
        own = self.setting_of(point).items()
        return {key: self.given[key][value] for key, value in own if value in self.given.get(key, {})}


def name(setting: Sequence[str]) -> str:
    """Return the name of a setting: its values."""
    return ", ".join(setting)


def plan_sweep(vary: Sequence[str], how: Arrangement, number: int, seed: int) -> SweepPlan:
    """Return the plan of a sweep from the options ``--vary``, ``--plan``, ``--number`` and ``--seed``.

    Raises CaseError with every problem of the options.
    """
    varied: list[Vary] = []
    problems: list[CaseProblem] = []
    for text in vary:
        try:
            varied.append(
                _random_values(text, 1, 0)
                if how is Arrangement.RANDOM
                else parse_vary(text, repeats=how is Arrangement.LIST)
            )
        except CaseError as error:
            problems += error.problems
    keys, columns = [each.key for each in varied], [each.values for each in varied]
    problems += [_wrong(key, "is varied twice") for key in sorted({k for k in keys if keys.count(k) > 1})]
    if not problems and how is Arrangement.LIST and len({len(values) for values in columns}) > 1:
        counts = ", ".join(f"{key} has {len(values)}" for key, values in zip(keys, columns, strict=True))
        problems.append(_wrong("--plan list", f"wants as many values of each key: {counts}"))
    if not problems and how is Arrangement.GRID and math.prod(map(len, columns)) > MOST_VALUES:
        problems.append(_wrong("--plan grid", f"makes more than {MOST_VALUES} settings"))
    if problems:
        raise CaseError(problems)
    if how is Arrangement.RANDOM:
        return _random_plan(vary, number, seed)
    settings = itertools.product(*columns) if how is Arrangement.GRID else zip(*columns, strict=True)
    return SweepPlan(tuple(keys), tuple(dict.fromkeys(settings)), {each.key: each.given for each in varied})


def check_names(study: CaseStudy, keys: Iterable[str], given: str) -> None:
    """Raise CaseError where a key, which ``given`` has, would add a part to the case of a study."""
    try:
        checked = study.check()
    except CaseError:  # only the values of the keys make it a case
        return
    if problems := checked.missing_parts(keys, given):
        raise CaseError(problems)


def _random_plan(vary: Sequence[str], number: int, seed: int) -> SweepPlan:
    """Return ``number`` different settings with random values of each key; a larger number continues them.

    A setting that is drawn again would be run once only, so that another one is drawn for it.  Raises
    CaseError where there seem to be fewer settings.
    """
    settings: dict[tuple[str, ...], None] = {}
    for times in DRAWS:
        drawn = [_random_values(text, times * number, [seed, k]) for k, text in enumerate(vary)]
        settings = dict.fromkeys(zip(*(each.values for each in drawn), strict=True))
        if len(settings) >= number:
            given = {each.key: each.given for each in drawn}
            return SweepPlan(tuple(each.key for each in drawn), tuple(settings)[:number], given)
    what = f"finds {len(settings)} different settings, not {number}"
    raise CaseError([CaseProblem((), what, "give a smaller --number, or --plan grid", "--plan random")])


def _random_values(text: str, number: int, seed: int | Sequence[int]) -> Vary:
    """Return the key with ``number`` random values, of a range 'key=first:last' or of a list 'key=a,b,c'.

    The same seed gives the same values, and a larger number continues them.  Raises CaseError.
    """
    generator = np.random.default_rng(seed)
    key, equals, values = (part.strip() for part in text.partition("="))
    if equals and values.count(":") == 1:
        try:
            ends, units = zip(*map(split_quantity, with_one_unit(values.split(":"))), strict=True)
            first, last = map(float, ends)
        except ValueError:
            raise CaseError([_wrong(text, "is not a range of numbers")]) from None
        if not first < last:
            raise CaseError([_wrong(text, "is not a range: the first number must be the smaller one")])
        drawn = generator.uniform(first, last, number)
        return vary_of(
            key, [f"{_rounded(value, first, last)} {units[0]}".strip() for value in drawn.tolist()]
        )
    vary = parse_vary(text)
    chosen = generator.integers(len(vary.values), size=number)
    return replace(vary, values=tuple(vary.values[k] for k in chosen))


def _rounded(value: float, first: float, last: float) -> str:
    """Return a value of a range with so many digits that it stays in the range and differs from others."""
    narrow = max(abs(first), abs(last)) / (last - first)
    more = math.ceil(math.log10(narrow)) if narrow > 10 else 0
    text = f"{value:.{DIGITS + more}g}"
    return text if first <= float(text) <= last else repr(value)


def _wrong(text: str, what: str) -> CaseProblem:
    hint = "for example --vary screen.inclination_deg=10,15,20, or with --plan random =10:20"
    return CaseProblem(
        (), what, hint, f"--vary {text}" if not text.startswith("--") else text, kind="wrong-type"
    )
