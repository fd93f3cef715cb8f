"""From a case that was read to the case that will be run: what it leaves out, and why.

The case key ``effects`` says which of the effects that can be left out a case has.  Absent: what
the case describes.  A list: exactly these.  "auto": what may be left out is.  What is left out is so
by other keys of the case, which are laid over it; nothing after this knows of ``effects``.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from orchestrator.case.file.deck_layout import lay_out_decks
from orchestrator.case.file.errors import CaseError, CaseProblem, Key, did_you_mean, show_value
from orchestrator.case.file.layers import Layers, Origin, find_changes
from orchestrator.case.load import AskedEffects, InvalidTables, Level, LoadedCase, load, validate
from orchestrator.case.scalars import SCALARS, scalar
from orchestrator.case.tables.case import Case
from orchestrator.preflight.checks import TABLE_RULES
from orchestrator.preflight.judgement.catalogue import (
    EFFECTS,
    can_leave_out,
    find_dispensable,
    find_left_out,
    find_left_out_by_level,
    has_effect,
    why_left_out,
    with_dependents,
)
from orchestrator.preflight.judgement.pair import Pair, key_of, recall
from orchestrator.preflight.judgement.weighing import is_undecided, weigh_effects

KEY: Key = ("effects",)
OF_LAW = {law: name for name, effect in EFFECTS.items() for law in effect.laws}
NUMERICS = (
    "coupling",
    "exchange",
    "frames",
    "panel",
    "particles",
    "output",
    "checkpoint",
    "slice",
    "monitor",
)
NO_PHYSICS = (*NUMERICS, "effects", "effects_for")


@dataclass(frozen=True)
class Choice:
    """What ``effects`` did.

    ``left_out`` has what it left out, name -> why; ``lacking`` what matters and the case does not
    have, in words ("auto" only); ``problems`` are those in the key itself; ``described`` is the case
    with all that it describes, None where nothing was left out; ``pairs`` are runs with and without
    an effect that were remembered, by which "auto" chose for the results ``asked`` for;
    ``undecided`` are effects that only such runs could leave out.
    """

    left_out: Mapping[str, str] = field(default_factory=dict)
    lacking: tuple[str, ...] = ()
    problems: tuple[CaseProblem, ...] = ()
    described: Case | None = None
    pairs: Mapping[str, Pair] = field(default_factory=dict)
    asked: tuple[str, ...] = ()
    undecided: tuple[str, ...] = ()


@dataclass(frozen=True)
class JudgedCase:
    """A case as it will be run.

    ``level`` is "" for the bare case; ``changed`` lists the physics keys (dotted) to which the
    level, --set or ``effects`` gave another value; ``left_out`` names the physics that solvers,
    the exchange and ``effects`` leave out, with the reason; ``layers`` knows which file gave a key;
    ``origin`` is what it was read from.
    """

    name: str
    folder: Path
    level: str
    case: Case
    changed: tuple[str, ...]
    left_out: dict[str, str]
    layers: Layers
    choice: Choice
    origin: Origin

    @property
    def described(self) -> Case:
        """The case with all that it describes, before ``effects`` left out some of it."""
        return self.choice.described or self.case


def load_judged(path: Path, level: str | None = None, overrides: Sequence[str] = ()) -> JudgedCase:
    """Return the case in ``path`` at a level as it will be run.

    Raises CaseError with every problem in its tables and in ``effects``, or in its level.
    """
    try:
        return judge(load(path, level, overrides))
    except InvalidTables as error:
        named = [replace(problem, file=error.asked.file) for problem in _wrong_effects(error.asked)]
        raise CaseError([*error.problems, *named]) from error


def judge(loaded: LoadedCase) -> JudgedCase:
    """Decide what the case leaves out.

    Problems in ``effects`` are in ``choice``; a case that has others is left as it is.  Raises
    CaseError for a level that leaves out what it does not name, and where what is left is no case.
    """
    layers = loaded.layers.copy()
    if problems := [*_wrong_level(loaded.level)]:
        raise CaseError(problems)
    choice, case = Choice(problems=tuple(_wrong_effects(loaded.asked))), loaded.case
    broken = choice.problems or any(True for rule in TABLE_RULES for _ in rule(case.whole))
    if loaded.asked.effects is not None and not broken:
        choice = _choose(layers, loaded)
        case = validate(layers)
    left_out = find_left_out(case)
    for name, why in choice.left_out.items():
        left_out[name] = f"{left_out[name]}; {why}" if name in left_out else why
    physics = (key for key in find_changes(loaded.origin.given, layers.merged) if key[0] not in NO_PHYSICS)
    return JudgedCase(
        name=loaded.name,
        folder=loaded.folder,
        level=loaded.level.name if loaded.level is not None else "",
        case=case,
        changed=tuple(".".join(key) for key in physics),
        left_out=left_out,
        layers=layers,
        choice=choice,
        origin=loaded.origin,
    )


def known_pairs(origin: Origin, names: Sequence[str]) -> dict[str, Pair]:
    """Return the pairs of runs that are remembered of a case, by effect."""
    read = origin.read() if names else {}
    pairs = {name: recall(key_of(read, name)) for name in names}
    return {name: pair for name, pair in pairs.items() if pair is not None}


def _choose(layers: Layers, loaded: LoadedCase) -> Choice:
    """Lay over the layers what ``effects`` wants."""
    bare, case, asked = Case.model_validate(layers.merged), loaded.case, loaded.asked.effects
    source = f"effects in {loaded.asked.file}"
    if asked == "auto":
        results = tuple(loaded.asked.effects_for) or (*SCALARS,)
        choice, spare = _choose_by_verdicts(case, loaded.origin, results)
    else:
        without = loaded.level.without if loaded.level is not None else ()
        laws = [word for word in asked if word in OF_LAW]
        names = {OF_LAW.get(word, word) for word in asked}
        if problems := (*_unmet(case, names, without), *_other_laws(layers, laws)):
            return Choice(problems=problems)
        for law in laws:
            layers.lay(EFFECTS[OF_LAW[law]].laws[law], source)
        others = [name for name in EFFECTS if name not in names and can_leave_out(case, name)]
        choice, spare = Choice(), with_dependents(others, "effects does not name it")
    for name in spare:
        if not set(EFFECTS[name].needs) & set(spare):  # what goes with something has no keys of its own
            layers.lay(EFFECTS[name].overlay(bare), source)
    left_out = {name: why for name, why in spare.items() if has_effect(case, name)}
    return replace(choice, left_out=left_out, described=case)


def _choose_by_verdicts(
    case: Case, origin: Origin, results: tuple[str, ...]
) -> tuple[Choice, dict[str, str]]:
    """Return what "auto" chooses for some results, and the effects to be left out, with the reason."""
    open_questions = [one for one in weigh_effects(case).values() if is_undecided(one)]
    trying = [one.effect for one in open_questions if EFFECTS[one.effect].saves]
    pairs = known_pairs(origin, trying)
    judged = weigh_effects(case, pairs, results).values()
    lacking = (
        f"{one.effect} matters, and the case does not have it: "
        f"{one.verdict.in_numbers}; {one.verdict.why}; {one.key}"
        for one in judged
        if one.lacking
    )
    unknown = tuple(name for name in trying if name not in pairs)
    choice = Choice(lacking=tuple(lacking), pairs=pairs, asked=results, undecided=unknown)
    return choice, with_dependents(find_dispensable(judged), 'effects = "auto"')


def _wrong_level(level: Level | None) -> Iterator[CaseProblem]:
    """Yield what a level leaves out without naming it, and what it names and does not leave out."""
    if level is None:
        return
    source = f"levels/{level.name}.toml"
    try:
        needed = find_left_out_by_level(
            *(lay_out_decks(Case.model_validate(c)) for c in (level.before, level.after))
        )
    except (ValidationError, CaseError):
        return  # without the level or --set it is no case
    for name, why in needed.items():
        if name not in level.without:
            what = f'"{name}" must be named: the level leaves it out'
            yield CaseProblem(("without",), what, why, source)
    for word in level.without:
        if word not in needed:
            what = f'"{word}" is not left out'
            yield CaseProblem(("without",), what, did_you_mean(word, needed), source)


def _wrong_effects(asked: AskedEffects) -> Iterator[CaseProblem]:
    """Yield names in ``effects`` and ``effects_for`` that there are not."""
    if asked.effects is not None and asked.effects != "auto":
        yield from _misnamed(asked.effects)
    # where effects_for is no list, the tables say so
    for name in asked.effects_for if isinstance(asked.effects_for, list | tuple) else ():
        try:
            scalar(str(name))  # a short name, or a path of keys with dots
        except KeyError as error:
            yield CaseProblem(("effects_for",), str(error.args[0]))


def _misnamed(asked: Any) -> Iterator[CaseProblem]:
    """Yield what is neither "auto" nor a list of names of effects, and laws that exclude each other."""
    if not isinstance(asked, list) or not all(isinstance(word, str) for word in asked):
        yield CaseProblem(KEY, f'{show_value(asked)} is wrong, "auto" or a list of names is wanted')
        return
    chosen: dict[str, str] = {}
    for word in dict.fromkeys(asked):
        if word not in EFFECTS and word not in OF_LAW:
            yield CaseProblem(KEY, f"no effect {show_value(word)}", did_you_mean(word, [*EFFECTS, *OF_LAW]))
        elif word in OF_LAW and (other := chosen.setdefault(OF_LAW[word], word)) != word:
            what = f'"{other}" and "{word}" exclude each other: both are laws of {OF_LAW[word]}'
            yield CaseProblem(KEY, what, "name one of them")


def _unmet(case: Case, names: Collection[str], without: Collection[str]) -> Iterator[CaseProblem]:
    """Yield what is named and is not there."""
    for name, effect in EFFECTS.items():
        if name not in names:
            continue
        for need in effect.needs:
            if need not in names and EFFECTS[need].overlay(case):
                what = f'"{name}" needs "{need}", which is not named'
                yield CaseProblem(KEY, what, f'name "{need}", too, or neither')
        if not effect.is_described(case):
            yield CaseProblem(KEY, f'"{name}": the case does not describe it', effect.key)
        elif (why := why_left_out(case, name)) and name not in without:
            hint = f'change that, or let the level say without = ["{name}"]'
            yield CaseProblem(KEY, f'"{name}" is left out by {why}', hint)


def _other_laws(layers: Layers, laws: Sequence[str]) -> Iterator[CaseProblem]:
    """Yield laws that are named where the case chooses another."""
    for law in laws:
        for table, keys in EFFECTS[OF_LAW[law]].laws[law].items():
            for key, wanted in keys.items():
                given = layers.merged.get(table, {}).get(key, wanted)
                if given != wanted:
                    what = f'"{law}" is named, and {table}.{key} is {show_value(given)}'
                    yield CaseProblem(KEY, what, f"({layers.source((table, key))}); take one away")
