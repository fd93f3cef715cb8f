"""The reader of cases: it lays ``levels/<level>.toml`` over ``case.toml``, and ``--set`` over both.

An overlay may give any key; file/layers.py says how tables are merged.  A case may itself be an overlay of
another case (file/base.py).  Nothing is judged here: orchestrator/preflight/judge.py decides afterwards which
effects the key ``effects`` leaves out.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from orchestrator.case.bed.carry import carry_bed, leave_out_outside
from orchestrator.case.bed.work_of_adhesion import resolve_works_of_adhesion, typical_grains
from orchestrator.case.deck.drawing import fill_in_sheets, read_drawings
from orchestrator.case.file.base import (
    CASE_FILE,
    lay_chain,
    level_names,
    read_chain,
    read_data_files,
    read_level,
)
from orchestrator.case.file.bushing_curve import fit_bushing_curves
from orchestrator.case.file.characteristic import check_characteristics
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
from orchestrator.case.file.layers import Layers, parse_override
from orchestrator.case.file.loss_curve import fit_loss_curves
from orchestrator.case.file.origin import Origin
from orchestrator.case.file.slice import cut_to_slice
from orchestrator.case.materials.fill_in import fill_in_materials
from orchestrator.case.shipped import no_such_case_hint
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
    file = path if path.is_file() else path / CASE_FILE
    if not file.is_file():
        what = f"no such case: there is no {CASE_FILE}"
        raise CaseError([CaseProblem((), what, no_such_case_hint(path), file=str(path), kind="file")])
    chain = read_chain(file)
    folder, layers = chain[0].folder, lay_chain(chain)
    given = layers.merged
    level_name = choose_level(folder, given, level)
    at_level = _lay_level(layers, folder, level_name) if level_name else None
    for override in overrides:
        layers.lay(parse_override(override), "--set")
    layers.merged = read_data_files(layers.merged, folder, "--set")
    effects, results = (layers.merged.get(key) for key in EFFECTS)
    asked = AskedEffects(effects, results or (), layers.source(EFFECTS[:1]))
    layers.lay(dict.fromkeys(EFFECTS), asked.file)
    try:
        case = validate(layers, folder)
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
        raise CaseError(
            [CaseProblem(key, f"no level {show_value(wanted)}", hint, file=file, kind="unknown-name")]
        )
    return str(wanted)


def validate(layers: Layers, folder: Path) -> Case:
    """Return the complete case of all layers; ``folder`` is the case's.

    Raises CaseError with every problem of the case.
    """
    try:
        return complete(read_tables(layers.merged, folder))
    except ValidationError as error:
        problems = from_validation(error, Case)
    except CaseError as error:
        problems = [*error.problems]
    raise CaseError(layers.named(problems))


def read_tables(merged: Mapping[str, Any], folder: Path) -> Case:
    """Return the case that merged tables describe, with materials of the library, its drawings, the particles
    that it takes over, and all works of adhesion in J/m2; ``folder`` is the case's.

    Raises pydantic's ValidationError for tables that are no case, and CaseError for drawings that cannot be
    read, for particles that cannot be taken over, and for contacts that give their adhesion twice.
    """
    tables = Case.model_validate(fill_in_materials(fill_in_sheets(merged, folder)))
    described = read_drawings(tables, folder)
    carried = carry_bed(described, folder)
    return resolve_works_of_adhesion(carried, typical_grains(described, carried))


def complete(bare: Case) -> Case:
    """Return the case with fitted curves, laid-out decks and coarse particles, cut to its slice.

    Raises CaseError with the problems of the first of these steps that fails.
    """
    curved = check_characteristics(fit_bushing_curves(fit_loss_curves(bare)))
    return leave_out_outside(cut_to_slice(coarsen(lay_out_decks(curved))))


def _lay_level(layers: Layers, folder: Path, name: str) -> Level:
    """Lay the level of this name over the case.  Raises CaseError for a file that is no level."""
    before = dict(layers.merged)
    overlay, source = read_level(folder, name)
    without = overlay.pop("without", [])
    overlay.pop("about", None)
    layers.lay(overlay, source)
    if not isinstance(without, list) or not all(isinstance(word, str) for word in without):
        what = f"must be a list of names, not {show_value(without)}"
        raise CaseError([CaseProblem(("without",), what, file=source, kind="wrong-type")])
    return Level(name, tuple(without), before, dict(layers.merged))
