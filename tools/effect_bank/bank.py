"""``cases/effects.toml``: scenes by which the verdicts of ``flipflow explain`` are tried out.

A scene is a case at a level with a few keys changed, so short that a run takes seconds, and the
results that somebody who looks at this scene would ask for.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from annotated_types import Ge, Le, Len
from pydantic import Strict, ValidationError

from orchestrator.case.file.errors import CaseError, CaseProblem, did_you_mean, from_validation
from orchestrator.case.file.layers import read_toml
from orchestrator.case.scalars import scalar
from orchestrator.case.tables.quantities import Name, OneLine, Positive, Table
from orchestrator.preflight.judgement.catalogue import EFFECTS


class Scene(Table):
    """One scene of the bank."""

    why: OneLine
    """What it is there for."""
    case: OneLine
    """The folder of its case, from the folder of this file."""
    level: OneLine
    """The level of the case."""
    sets: tuple[OneLine, ...] = ()
    """As ``--set``."""
    duration_s: Positive | None = None
    """The time that is simulated; without it, the case's."""
    asked: Annotated[tuple[OneLine, ...], Len(1)]
    """The results that the verdicts are about: names as ``flipflow explain --for`` takes them, or
    paths of keys in ``summary.json``."""
    seeds: Annotated[int, Strict(), Ge(1), Le(20)] = 1
    """Runs with and without an effect each, with other random numbers."""
    effects: tuple[OneLine, ...] = ()
    """Only these effects are left out in turn; empty: all that can be."""


class Bank(Table):
    """The whole file."""

    scenes: Annotated[dict[Name, Scene], Len(1)]
    """By their names."""


def read(file: Path) -> dict[str, Scene]:
    """Return the scenes of a bank by name.  Raises CaseError with every mistake in the file."""
    if not file.is_file():
        raise CaseError([CaseProblem((), "there is no bank of scenes", file=str(file))])
    given = read_toml(file, file.parent)
    try:
        bank = Bank.model_validate(given)
    except ValidationError as error:
        raise CaseError([*from_validation(error, Bank)]) from None
    wrong = [
        CaseProblem(("scenes", name, key), what, hint, str(file))
        for name, scene in bank.scenes.items()
        for key, what, hint in _mistakes(scene)
    ]
    if wrong:
        raise CaseError(wrong)
    return bank.scenes


def chosen(bank: dict[str, Scene], names: list[str]) -> dict[str, Scene]:
    """Return the scenes of these names, or all where no names are given.  Raises CaseError."""
    for name in names:
        if name not in bank:
            hint = did_you_mean(name, bank)
            raise CaseError([CaseProblem((), f'no scene "{name}"', hint, file="--scene")])
    return {name: bank[name] for name in names} if names else bank


def _mistakes(scene: Scene) -> list[tuple[str, str, str]]:
    """Results and effects that there are not: key, what is wrong, and a hint."""
    found = []
    for name in scene.asked:
        try:
            scalar(name)
        except KeyError as error:
            found.append(("asked", str(error.args[0]), ""))
    for name in scene.effects:
        if name not in EFFECTS:
            found.append(("effects", f'no effect "{name}"', did_you_mean(name, EFFECTS)))
    return found
