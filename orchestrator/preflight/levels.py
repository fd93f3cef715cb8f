"""Reads a case: ``case.toml``, overlaid by ``levels/<level>.toml``, overlaid by ``--set``.

An overlay may give any key; overlays.py says how it is laid over what is there.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from orchestrator.case.file.deck_layout import laid_out
from orchestrator.case.file.errors import (
    CaseError,
    CaseProblem,
    did_you_mean,
    from_validation,
    shown,
    visible,
)
from orchestrator.case.file.origin import Origin
from orchestrator.case.file.overlays import Layers, changed, parsed
from orchestrator.case.file.toml_file import read_toml
from orchestrator.case.tables.case import Case
from orchestrator.preflight.effect_choice import Choice, chosen, shaped
from orchestrator.preflight.judgement.catalogue import dropped, left_out

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
class LoadedCase:
    """A case as it will be run.

    ``level`` is "" for the bare case; ``changed`` lists the physics keys (dotted) to which the
    level, --set or ``effects`` gave another value; ``left_out`` names the physics that solvers,
    hand-overs and ``effects`` leave out, with the reason; ``layers`` knows which file gave a key;
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


def load(path: Path, level: str | None = None, overrides: Sequence[str] = ()) -> LoadedCase:
    """The case in ``path`` (its folder or its case.toml) at a level (None: its default).

    Raises CaseError with every mistake that the tables find; what needs more than the tables is
    found by ``checks.mistakes``.
    """
    file = path if path.is_file() else path / "case.toml"
    if not file.is_file():
        raise CaseError([CaseProblem((), "no such case: there is no case.toml", file=str(path))])
    folder = file.resolve().parent
    given = read_toml(file.resolve())
    layers = Layers(given, file.name)
    at_level = chosen_level(folder, given, level)
    without = _lay_level(layers, folder, at_level) if at_level else ()
    for override in overrides:
        layers.lay(parsed(override), "--set")
    origin = Origin(folder, given, at_level, tuple(overrides))
    choice = chosen(layers, without, origin)
    case = validated(layers, choice.mistakes)
    physics = (key for key in changed(given, layers.merged) if key[0] not in NO_PHYSICS)
    return LoadedCase(
        name=visible(folder.name),
        folder=folder,
        level=at_level,
        case=case,
        changed=tuple(".".join(key) for key in physics),
        left_out=_why_left_out(case, choice),
        layers=layers,
        choice=choice,
        origin=origin,
    )


def level_names(folder: Path) -> list[str]:
    """The levels that a case's folder has."""
    return sorted(file.stem for file in (folder / "levels").glob("*.toml"))


def chosen_level(folder: Path, given: Mapping[str, Any], level: str | None) -> str:
    """The level asked for; else the case's default, else the only one, else none ("")."""
    known = level_names(folder)
    wanted = level if level is not None else given.get("default_level", "")
    if not wanted:
        return known[0] if len(known) == 1 else ""
    if wanted not in known:
        hint = did_you_mean(str(wanted), known, say="levels")
        file = "case.toml" if level is None else "--level"
        key = ("default_level",) if level is None else ()
        raise CaseError([CaseProblem(key, f"no level {shown(wanted)}", hint, file=file)])
    return str(wanted)


def validated(layers: Layers, besides: Sequence[CaseProblem] = ()) -> Case:
    """As ``shaped``.  Raises CaseError with every mistake found, and those ``besides``."""
    try:
        return shaped(Case.model_validate(layers.merged))
    except ValidationError as error:
        found = from_validation(error, Case)
    except CaseError as error:
        found = [*error.mistakes]
    raise CaseError(layers.named([*found, *besides]))


def _why_left_out(case: Case, choice: Choice) -> dict[str, str]:
    """By settings, by ``effects``, or by the one because of the other."""
    found = left_out(case)
    for name, why in choice.left_out.items():
        found[name] = f"{found[name]}; {why}" if name in found else why
    return found


def _lay_level(layers: Layers, folder: Path, level: str) -> tuple[str, ...]:
    """Lays the level over the case and checks that it names what it leaves out; the names."""
    bare = dict(layers.merged)
    source = f"levels/{level}.toml"
    overlay = read_toml(folder / source, folder)
    without = overlay.pop("without", [])
    overlay.pop("about", None)
    layers.lay(overlay, source)
    if not isinstance(without, list) or not all(isinstance(word, str) for word in without):
        what = f"{shown(without)} is wrong, a list of names is wanted"
        raise CaseError([CaseProblem(("without",), what, file=source)])
    try:
        needed = dropped(*(laid_out(Case.model_validate(c)) for c in (bare, layers.merged)))
    except (ValidationError, CaseError):
        return ()  # load validates again and says what is wrong
    mistakes = [
        CaseProblem(("without",), f'"{name}" must be named: the level leaves it out', why, source)
        for name, why in needed.items()
        if name not in without
    ]
    mistakes += [
        CaseProblem(("without",), f'"{word}" is not left out', did_you_mean(word, needed), source)
        for word in without
        if word not in needed
    ]
    if mistakes:
        raise CaseError(mistakes)
    return tuple(without)
