"""``expected.toml`` beside a hard case: its runs, and what must be true of them.

Every band was fixed before the case was run, from what its ``why`` says.  A criterion that is not
met stays as it is and says so (``known_failure``).
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from annotated_types import Len
from pydantic import ValidationError

from orchestrator.casefile.errors import CaseError, Key, Mistake, from_validation
from orchestrator.casefile.toml_file import read_toml
from orchestrator.hard.measures import AXES, MEASURES, TAKES
from orchestrator.tables.quantities import Few, Name, Number, OneLine, Positive, Table

FILE = "expected.toml"


class Runs(Table):
    """One run of the case."""

    sets: tuple[OneLine, ...] = ()
    """As ``--set``."""
    of_limit: Positive | None = None
    """The sync interval, in multiples of the largest safe one that the card gives."""
    resume_at_s: Positive | None = None
    """The run ends here and is resumed."""


class Criterion(Table):
    """One number of a run, and the band in which it must be."""

    what: OneLine
    """What the number is."""
    run: Name
    """The run that it is taken from."""
    measure: OneLine
    """How it is found (``measures.MEASURES``)."""
    of: OneLine = ""
    """What the measure looks at: a dataset of history.h5, or keys of summary.json."""
    axis: Literal["", "x", "y", "z", "size"] = ""
    """The component of a dataset of vectors, or their size."""
    take: OneLine = "last"
    """What of a series: ``measures.TAKES``."""
    between_s: tuple[Number, Number] | None = None
    """Part of a series."""
    earlier_s: tuple[Number, Number] | None = None
    """The part before that it is compared with."""
    against: OneLine = ""
    """The run that it is compared with."""
    reference: Number | None = None
    """What the measured number is divided by: the answer known from elsewhere."""
    unit: OneLine = "1"
    """Unit of the number and of its reference."""
    band: tuple[Number | None, Number | None]
    """From, to; with a reference, in multiples of it."""
    why: OneLine
    """Where band and reference come from."""
    known_failure: OneLine = ""
    """Why it is not met; empty of what must be."""


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
        Mistake(key, f'no {key[-1]} "{word}"', f"known: {', '.join(known)}", str(file))
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
