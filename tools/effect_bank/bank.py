"""``cases/effects.toml``: scenes by which the verdicts of ``flipflow explain`` are tried out.

A scene is a case at a level with a few changed keys, so short that a run takes seconds.  It names the results
that a user of the scene would ask for.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from annotated_types import Ge, Le, Len
from pydantic import Strict, ValidationError

from orchestrator.case.file.errors import CaseError, CaseProblem, did_you_mean, from_validation
from orchestrator.case.file.layers import read_toml
from orchestrator.case.tables.quantities import Name, OneLine, Positive, Table
from orchestrator.figures.short_names import named
from orchestrator.preflight.judgement.catalogue import EFFECTS


class Scene(Table):
    """One scene of the bank."""

    why: OneLine
    """The purpose of the scene."""
    case: OneLine
    """The folder of the scene's case, relative to the folder of the bank's file."""
    level: OneLine
    """The level of the case."""
    sets: tuple[OneLine, ...] = ()
    """Overlays, as ``--set`` takes them."""
    duration_s: Positive | None = None
    """The simulated time; without it, the case's duration."""
    asked: Annotated[tuple[OneLine, ...], Len(1)]
    """The results that the verdicts are about: names as ``flipflow explain --for`` takes them, or
    paths of keys in ``summary.json``."""
    seeds: Annotated[int, Strict(), Ge(1), Le(20)] = 1
    """The number of runs with and without each effect, with different random numbers."""
    effects: tuple[OneLine, ...] = ()
    """The effects that are left out in turn; without them, all effects that can be left out."""


class Bank(Table):
    """The content of the bank's file."""

    scenes: Annotated[dict[Name, Scene], Len(1)]
    """The scenes by name."""


def read(file: Path) -> dict[str, Scene]:
    """Return the scenes of a bank by name.  Raises CaseError with every mistake in the file."""
    if not file.is_file():
        raise CaseError([CaseProblem((), "there is no bank of scenes", file=str(file))])
    given = read_toml(file, file.parent)
    try:
        bank = Bank.model_validate(given)
    except ValidationError as error:
        raise CaseError([*from_validation(error, Bank)]) from None
    problems = [
        CaseProblem(("scenes", name, key), what, hint, str(file))
        for name, scene in bank.scenes.items()
        for key, what, hint in _mistakes(scene)
    ]
    if problems:
        raise CaseError(problems)
    return bank.scenes


def select(bank: dict[str, Scene], names: list[str]) -> dict[str, Scene]:
    """Return the scenes of these names, or all where no names are given.  Raises CaseError."""
    for name in names:
        if name not in bank:
            hint = did_you_mean(name, bank)
            raise CaseError([CaseProblem((), f'no scene "{name}"', hint, file="--scene")])
    return {name: bank[name] for name in names} if names else bank


def _mistakes(scene: Scene) -> list[tuple[str, str, str]]:
    """Return the key, the problem and a hint for each unknown result or effect of a scene."""
    mistakes = []
    for name in scene.asked:
        try:
            named(name)
        except KeyError as error:
            mistakes.append(("asked", str(error.args[0]), ""))
    for name in scene.effects:
        if name not in EFFECTS:
            mistakes.append(("effects", f'no effect "{name}"', did_you_mean(name, EFFECTS)))
    return mistakes
