"""The step from a case that was read to the case that will be run: what it leaves out, and why.

The case key ``effects`` chooses among the effects that can be left out.  Without it, a case has the
effects that it describes.  With a list, it has exactly these.  With "auto", it leaves out every
effect that may be left out.  Overlays of other keys leave an effect out; later code does not know
``effects``.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from orchestrator.case.file.deck_layout import lay_out_decks
from orchestrator.case.file.errors import CaseError, CaseProblem, Key, did_you_mean, show_value
from orchestrator.case.file.layers import Layers, find_changes
from orchestrator.case.file.origin import Origin
from orchestrator.case.load import AskedEffects, InvalidTables, Level, LoadedCase, load, read_tables, validate
from orchestrator.case.materials.fill_in import list_library_rows
from orchestrator.case.tables.case import Case
from orchestrator.figures.short_names import SHORT_NAMES, named
from orchestrator.preflight.checks import TABLE_RULES
from orchestrator.preflight.judgement.catalogue import (
    EFFECTS,
    FLAT,
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
NUMERICS = (*FLAT, "coupling", "output", "checkpoint", "slice", "monitor")
NO_PHYSICS = (*NUMERICS, "effects", "effects_for")


@dataclass(frozen=True)
class Choice:
    """The choice that the key ``effects`` made.

    ``left_out`` maps the names of the effects that it left out to the reasons.  ``lacking`` describes
    effects that matter and that the case does not have ("auto" only).  ``problems`` are problems in
    the key itself.  ``described`` is the case with all that it describes, None without ``effects``.
    ``pairs`` are remembered runs with and without an effect, by which "auto" chose for the results
    ``asked`` for.  ``undecided`` names the effects that only such runs could leave out.
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

    ``level`` is "" for the bare case.  ``changed`` lists the dotted physics keys to which the level,
    --set or ``effects`` gave another value.  ``left_out`` maps each effect that solvers, the exchange
    or ``effects`` leave out to the reason.  ``layers`` knows which file gave a key, and ``origin``
    has the sources from which the case was read.
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
        """The case with all that it describes, before ``effects`` left out a part of it."""
        return self.choice.described or self.case


def load_judged(path: Path, level: str | None = None, overrides: Sequence[str] = ()) -> JudgedCase:
    """Return the case in ``path`` at a level as it will be run.

    Raises CaseError with every problem in its tables and in ``effects``, or in its level.
    """
    try:
        return judge(load(path, level, overrides))
    except InvalidTables as error:
        others = [replace(problem, file=error.asked.file) for problem in _effects_problems(error.asked)]
        raise CaseError([*error.problems, *others]) from error


def judge(loaded: LoadedCase) -> JudgedCase:
    """Decide what the case leaves out, and return it as it will be run.

    ``choice`` has the problems in ``effects``.  A case with other problems is left as it is.  Raises
    CaseError for a level that leaves out an effect without naming it, and if the case is not valid
    without the effects that it leaves out.
    """
    layers = loaded.layers.copy()
    if problems := [*_level_problems(loaded.level, loaded.folder)]:
        raise CaseError(problems)
    choice, case = Choice(problems=tuple(_effects_problems(loaded.asked))), loaded.case
    broken = choice.problems or any(True for rule in TABLE_RULES for _ in rule(case.whole_machine))
    if loaded.asked.effects is not None and not broken:
        choice = _choose(layers, loaded)
        case = validate(layers, loaded.folder)
    left_out = find_left_out(case)
    for name, why in choice.left_out.items():
        left_out[name] = f"{left_out[name]}; {why}" if name in left_out else why
    before, after = (list_library_rows(tables) for tables in (loaded.origin.given, layers.merged))
    physics = (key for key in find_changes(before, after) if key[0] not in NO_PHYSICS)
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
    """Return the remembered pairs of runs of a case by effect."""
    read = origin.read() if names else {}
    pairs = {name: recall(key_of(read, name)) for name in names}
    return {name: pair for name, pair in pairs.items() if pair is not None}


def _choose(layers: Layers, loaded: LoadedCase) -> Choice:
    """Lay the overlays that ``effects`` calls for over the layers, and return the choice."""
    bare, case, asked = read_tables(layers.merged, loaded.folder), loaded.case, loaded.asked.effects
    source = f"effects in {loaded.asked.file}"
    if asked == "auto":
        results = tuple(loaded.asked.effects_for) or (*SHORT_NAMES,)
        choice, spare = _choose_by_verdicts(case, loaded.origin, results)
    else:
        without = loaded.level.without if loaded.level is not None else ()
        laws = [word for word in asked if word in OF_LAW]
        names = {OF_LAW.get(word, word) for word in asked}
        if problems := (*_unavailable_effects(case, names, without), *_law_conflicts(layers, laws)):
            return Choice(problems=problems)
        for law in laws:
            layers.lay(EFFECTS[OF_LAW[law]].laws[law], source)
        others = [name for name in EFFECTS if name not in names and can_leave_out(case, name)]
        choice, spare = Choice(), with_dependents(others, "effects does not name it")
    for name in spare:
        if not set(EFFECTS[name].needs) & set(spare):  # a dependent effect goes with the one that it needs
            _lay(layers, EFFECTS[name].overlay(bare), source)
    left_out = {name: why for name, why in spare.items() if has_effect(case, name)}
    return replace(choice, left_out=left_out, described=case)


def _lay(layers: Layers, overlay: Mapping[str, Any], source: str) -> None:
    """Lay an overlay of the completed case over the layers, which may leave its rows to the library."""
    if overlay.keys() & {"materials", "contacts"}:
        layers.merged = list_library_rows(layers.merged)
    layers.lay(overlay, source)


def _choose_by_verdicts(
    case: Case, origin: Origin, results: tuple[str, ...]
) -> tuple[Choice, dict[str, str]]:
    """Return what "auto" chooses for some results, and the effects to leave out with the reasons."""
    undecided = [judged.effect for judged in weigh_effects(case).values() if is_undecided(judged)]
    worth_a_trial = [name for name in undecided if EFFECTS[name].saves]
    pairs = known_pairs(origin, worth_a_trial)
    effects = weigh_effects(case, pairs, results).values()
    lacking = (
        f"{judged.effect} matters, and the case does not have it: "
        f"{judged.verdict.in_numbers}; {judged.verdict.why}; {judged.key}"
        for judged in effects
        if judged.is_lacking
    )
    unknown = tuple(name for name in worth_a_trial if name not in pairs)
    choice = Choice(lacking=tuple(lacking), pairs=pairs, asked=results, undecided=unknown)
    return choice, with_dependents(find_dispensable(effects), 'effects = "auto"')


def _level_problems(level: Level | None, folder: Path) -> Iterator[CaseProblem]:
    """Yield problems of a level that leaves out an effect without naming it, or names one that it has."""
    if level is None:
        return
    source = f"levels/{level.name}.toml"
    try:
        needed = find_left_out_by_level(
            *(lay_out_decks(read_tables(c, folder)) for c in (level.before, level.after))
        )
    except (ValidationError, CaseError):
        return  # without the level or --set, the tables are no valid case, and nothing can be compared
    for name, why in needed.items():
        if name not in level.without:
            what = f'"{name}" must be named: the level leaves it out'
            yield CaseProblem(("without",), what, why, source)
    for word in level.without:
        if word not in needed:
            what = f'"{word}" is not left out'
            yield CaseProblem(("without",), what, did_you_mean(word, needed), source)


def _effects_problems(asked: AskedEffects) -> Iterator[CaseProblem]:
    """Yield problems of unknown names in ``effects`` and ``effects_for``."""
    if asked.effects is not None and asked.effects != "auto":
        yield from _unknown_effects(asked.effects)
    # the check of the tables reports an effects_for that is no list
    for name in asked.effects_for if isinstance(asked.effects_for, list | tuple) else ():
        try:
            named(str(name))  # a short name, or a path of keys with dots
        except KeyError as error:
            yield CaseProblem(("effects_for",), str(error.args[0]), kind="unknown-name")


def _unknown_effects(asked: Any) -> Iterator[CaseProblem]:
    """Yield problems of a value that is no list of effects' names, and of laws that exclude each other."""
    if not isinstance(asked, list) or not all(isinstance(word, str) for word in asked):
        yield CaseProblem(
            KEY, f'must be "auto" or a list of names, not {show_value(asked)}', kind="wrong-type"
        )
        return
    chosen: dict[str, str] = {}
    for word in dict.fromkeys(asked):
        if word not in EFFECTS and word not in OF_LAW:
            yield CaseProblem(
                KEY,
                f"no effect {show_value(word)}",
                did_you_mean(word, [*EFFECTS, *OF_LAW]),
                kind="unknown-name",
            )
        elif word in OF_LAW and (other := chosen.setdefault(OF_LAW[word], word)) != word:
            what = f'"{other}" and "{word}" exclude each other: both are laws of {OF_LAW[word]}'
            yield CaseProblem(KEY, what, "name one of them")


def _unavailable_effects(
    case: Case, names: Collection[str], without: Collection[str]
) -> Iterator[CaseProblem]:
    """Yield problems of effects that ``effects`` names and the case does not describe or leaves out."""
    for name, effect in EFFECTS.items():
        if name not in names:
            continue
        for need in effect.needs:
            if need not in names and EFFECTS[need].overlay(case):
                what = f'"{name}" needs "{need}", which is not named'
                yield CaseProblem(KEY, what, f'name "{need}", too, or neither')
        if not effect.is_described(case):
            yield CaseProblem(
                KEY, f'"{name}": the case does not describe it', effect.key and f"set {effect.key}"
            )
        elif (why := why_left_out(case, name)) and name not in without:
            hint = f'change that, or let the level say without = ["{name}"]'
            yield CaseProblem(KEY, f'"{name}" is left out by {why}', hint)


def _law_conflicts(layers: Layers, laws: Sequence[str]) -> Iterator[CaseProblem]:
    """Yield problems of laws that ``effects`` names while the case chooses others."""
    for law in laws:
        for table, keys in EFFECTS[OF_LAW[law]].laws[law].items():
            for key, wanted in keys.items():
                given = layers.merged.get(table, {}).get(key, wanted)
                if given != wanted:
                    what = f'"{law}" is named, and {table}.{key} is {show_value(given)}'
                    yield CaseProblem(KEY, what, f"({layers.source((table, key))}); take one away")
