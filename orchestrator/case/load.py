"""Reads a case: ``case.toml``, overlaid by ``levels/<level>.toml``, overlaid by ``--set``.

An overlay may give any key; file/layers.py says how it is laid over what is there.  Nothing is judged
here: what the key ``effects`` leaves out is decided afterwards, in orchestrator/preflight/judge.py.
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
    """A level of a case: its name, what it says that it leaves out (``without``), and the case's
    tables ``before`` and ``after`` it was laid over them."""

    name: str
    without: tuple[str, ...]
    before: Mapping[str, Any]
    after: Mapping[str, Any]


@dataclass(frozen=True)
class AskedEffects:
    """The keys ``effects`` and ``effects_for`` as they were given, and the file or option that gave
    the first."""

    effects: Any
    effects_for: Any
    file: str


@dataclass(frozen=True)
class LoadedCase:
    """A case as its files and ``--set`` give it.

    ``layers`` knows which file gave a key, and has none of those in ``asked``; ``level`` is None for
    the bare case; ``origin`` is what the case was read from.
    """

    name: str
    folder: Path
    case: Case
    layers: Layers
    level: Level | None
    asked: AskedEffects
    origin: Origin


class InvalidTables(CaseError):
    """Tables that make no case; what they ask of the judgement can be looked at nevertheless."""

    def __init__(self, problems: Sequence[CaseProblem], asked: AskedEffects) -> None:
        super().__init__(problems)
        self.asked = asked


def load(path: Path, level: str | None = None, overrides: Sequence[str] = ()) -> LoadedCase:
    """Read the case in ``path`` (its folder or its case.toml) at a level (None: its default).

    Raises CaseError with every problem that the tables find; what needs more than the tables is
    found by orchestrator/preflight/check.py.
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
    """Return the complete case of all layers.  Raises CaseError with every problem found."""
    try:
        return complete(Case.model_validate(layers.merged))
    except ValidationError as error:
        problems = from_validation(error, Case)
    except CaseError as error:
        problems = [*error.problems]
    raise CaseError(layers.named(problems))


def complete(bare: Case) -> Case:
    """The case with branches fitted, decks laid out, particles as coarse as wanted, and cut to its
    slice.  Raises CaseError."""
    return cut_to_slice(coarsen(lay_out_decks(fit_loss_curves(bare))))


def _lay_level(layers: Layers, folder: Path, name: str) -> Level:
    """Lay the level over the case."""
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
