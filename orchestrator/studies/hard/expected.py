"""``expected.toml`` beside a hard case: its runs, and what must be true of them.

Every band was fixed before the case was run, from what its ``why`` says.  A criterion that is not
met stays as it is and says so (``known_failure``).
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from annotated_types import Len
from pydantic import ValidationError

from orchestrator.case.file.errors import CaseError, CaseProblem, Key, from_validation
from orchestrator.case.file.toml_file import read_toml
from orchestrator.case.tables.quantities import Few, Name, OneLine, Positive, Table
from orchestrator.studies.hard.criterion import Criterion
from orchestrator.studies.hard.measures import AXES, MEASURES, TAKES

FILE = "expected.toml"


class Runs(Table):
    """One run of the case."""

    sets: tuple[OneLine, ...] = ()
    """As ``--set``."""
    of_limit: Positive | None = None
    """The sync interval, in multiples of the largest safe one that the card gives."""
    resume_at_s: Positive | None = None
    """The run ends here and is resumed."""


class Expected(Table):
    """``expected.toml``."""

    number: Few
    """Its place in the list of hard cases."""
    happens: OneLine
    """What is done to the machine."""
    expected: OneLine
    """What must come of it."""
    runs: dict[Name, Runs]
    """Its runs, by name."""
    criteria: Annotated[tuple[Criterion, ...], Len(1)]
    """What must be true."""


def read(case: Path) -> Expected:
    """Raises CaseError."""
    file = case / FILE
    given = read_toml(file, case)
    try:
        found = Expected.model_validate(given)
    except ValidationError as error:
        raise CaseError([*from_validation(error, Expected)]) from None
    wrong = [
        CaseProblem(key, f'no {key[-1]} "{word}"', f"known: {', '.join(known)}", str(file))
        for number, row in enumerate(found.criteria)
        for key, word, known in _names(number, row, found)
        if word not in known
    ]
    if wrong:
        raise CaseError(wrong)
    return found


def _names(number: int, row: Criterion, of: Expected) -> list[tuple[Key, str, list[str]]]:
    """Every name in a criterion with those that there are."""
    return [
        (("criteria", number, "run"), row.run, [*of.runs]),
        (("criteria", number, "against"), row.against, ["", *of.runs]),
        (("criteria", number, "measure"), row.measure, [*MEASURES]),
        (("criteria", number, "take"), row.take, [*TAKES]),
        (("criteria", number, "axis"), row.axis, [*AXES]),
    ]
