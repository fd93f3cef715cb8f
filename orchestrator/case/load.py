"""The reader of cases: it lays ``levels/<level>.toml`` over ``case.toml``, and ``--set`` over both.

An overlay may give any key; file/layers.py says how tables are merged.  Nothing is judged here:
orchestrator/preflight/judge.py decides afterwards which effects the key ``effects`` leaves out.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from orchestrator.case.file.coarse import coarsen
from orchestrator.case.file.deck_layout import lay_out_decks
from orchestrator.case.file.errors import (
    CaseError,
    CaseProblem,
    did_you_mean,
    from_validation,
    show_value,
    visible,
)
from orchestrator.case.file.layers import Layers, Origin, level_file, parse_override, read_toml
from orchestrator.case.file.loss_curve import fit_loss_curves
from orchestrator.case.file.slice import cut_to_slice
from orchestrator.case.tables.case import Case

EFFECTS = ("effects", "effects_for")


@dataclass(frozen=True)
class Level:
    """A level of a case: its name and the effects that it declares left out (``without``).

    ``before`` holds the case's tables without the level, and ``after`` the tables with it.
    """

    name: str
    without: tuple[str, ...]
    before: Mapping[str, Any]
    after: Mapping[str, Any]


@dataclass(frozen=True)
class AskedEffects:
    """The values of ``effects`` and ``effects_for`` as the user gave them.

    ``file`` is the file or option that gave ``effects``.
    """

    effects: Any
    effects_for: Any
    file: str


@dataclass(frozen=True)
class LoadedCase:
    """A case as its files and ``--set`` give it.

    ``layers`` knows which file gave each key, but does not contain the keys in ``asked``.  ``level``
    is None for a case without a level.  ``origin`` describes what the case was read from.
    """

    name: str
    folder: Path
    case: Case
    layers: Layers
    level: Level | None
    asked: AskedEffects
    origin: Origin


class InvalidTables(CaseError):
    """An error for tables that do not make a valid case; ``asked`` still says which effects they ask for."""

    def __init__(self, problems: Sequence[CaseProblem], asked: AskedEffects) -> None:
        super().__init__(problems)
        self.asked = asked


def load(path: Path, level: str | None = None, overrides: Sequence[str] = ()) -> LoadedCase:
    """Read the case in ``path`` (its folder or its case.toml) at a level; None takes its default level.

    Raises CaseError with every problem that the tables reveal; orchestrator/preflight/check.py
    checks everything that the tables cannot reveal.
    """
    file = path if path.is_file() else path / "case.toml"
    if not file.is_file():
        raise CaseError([CaseProblem((), "no such case: there is no case.toml", file=str(path))])
    folder = file.resolve().parent
    given = read_toml(file.resolve())
    layers = Layers(given, file.name)
    level_name = choose_level(folder, given, level)
    at_level = _lay_level(layers, folder, level_name) if level_name else None
    for override in overrides:
        layers.lay(parse_override(override), "--set")
    effects, results = (layers.merged.get(key) for key in EFFECTS)
    asked = AskedEffects(effects, results or (), layers.source(EFFECTS[:1]))
    layers.lay(dict.fromkeys(EFFECTS), asked.file)
    try:
        case = validate(layers)
    except CaseError as error:
        raise InvalidTables(error.problems, asked) from error
    return LoadedCase(
        name=visible(folder.name),
        folder=folder,
        case=case,
        layers=layers,
        level=at_level,
        asked=asked,
        origin=Origin(folder, given, level_name, tuple(overrides)),
    )


def level_names(folder: Path) -> list[str]:
    """Return the names of the levels in a case's folder."""
    return sorted(file.stem for file in (folder / "levels").glob("*.toml"))


def choose_level(folder: Path, given: Mapping[str, Any], level: str | None) -> str:
    """Return the requested level; else the case's default, else the only one, else none ("").

    A level is a name, or the path of a TOML file with the same content.
    """
    if level is not None and level.endswith(".toml") and Path(level).is_file():
        return str(Path(level).resolve())
    known = level_names(folder)
    wanted = level if level is not None else given.get("default_level", "")
    if not wanted:
        return known[0] if len(known) == 1 else ""
    if wanted not in known:
        hint = did_you_mean(str(wanted), known, say="levels")
        file = "case.toml" if level is None else "--level"
        key = ("default_level",) if level is None else ()
        raise CaseError([CaseProblem(key, f"no level {show_value(wanted)}", hint, file=file)])
    return str(wanted)


def validate(layers: Layers) -> Case:
    """Return the complete case of all layers.  Raises CaseError with every problem of the case."""
    try:
        return complete(Case.model_validate(layers.merged))
    except ValidationError as error:
        problems = from_validation(error, Case)
    except CaseError as error:
        problems = [*error.problems]
    raise CaseError(layers.named(problems))


def complete(bare: Case) -> Case:
    """Return the case with fitted branches, laid-out decks and coarse particles, cut to its slice.

    Raises CaseError with the problems of the first of these steps that fails.
    """
    return cut_to_slice(coarsen(lay_out_decks(fit_loss_curves(bare))))


def _lay_level(layers: Layers, folder: Path, name: str) -> Level:
    """Lay the level of this name over the case.  Raises CaseError for a file that is no level."""
    before = dict(layers.merged)
    file = level_file(folder, name)
    source = f"levels/{name}.toml" if file.parent == folder / "levels" else name
    overlay = read_toml(file, None if source == name else folder)
    without = overlay.pop("without", [])
    overlay.pop("about", None)
    layers.lay(overlay, source)
    if not isinstance(without, list) or not all(isinstance(word, str) for word in without):
        what = f"{show_value(without)} is wrong, a list of names is wanted"
        raise CaseError([CaseProblem(("without",), what, file=source)])
    return Level(name, tuple(without), before, dict(layers.merged))
