"""``answers.toml`` beside a case: answers that are known from elsewhere."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pydantic import ValidationError

from orchestrator.case.file.errors import CaseError, from_validation
from orchestrator.case.file.toml_file import read_toml
from orchestrator.case.tables.quantities import Number, OneLine, Table
from orchestrator.output.results.run_reader import RunReader

FILE = "answers.toml"


class Answer(Table):
    """One of them."""

    of: tuple[OneLine, ...]
    """Where ours is: keys into ``summary.json``, one within the other; a whole number is the place
    in a list."""
    value: Number
    """The answer, in SI units; not 0."""
    source: OneLine
    """Where it is from."""


class Answers(Table):
    """``answers.toml``."""

    answers: dict[OneLine, Answer]
    """By what they are, in words."""


def answers(case: Path) -> dict[str, Answer]:
    """Of a case's folder; none without the file.  Raises CaseError."""
    file = (case if case.is_dir() else case.parent) / FILE
    if not file.is_file():
        return {}
    try:
        return Answers.model_validate(read_toml(file, file.parent)).answers
    except ValidationError as error:
        raise CaseError([*from_validation(error, Answers)]) from None


def off(answer: Answer, run: Path) -> float | None:
    """Relative error of a run; None where it does not tell."""
    found: Any = RunReader(run).summary
    for key in answer.of:
        try:
            found = found[int(key)] if isinstance(found, list) else found[key]
        except (KeyError, IndexError, TypeError, ValueError):
            return None
    if isinstance(found, dict):
        found = found.get("value")
    if not isinstance(found, int | float):
        return None
    return abs(found - answer.value) / abs(answer.value)
