"""Tables of numbers that earlier runs gave, from which a study is written again without a run."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path

from orchestrator.workbench import CaseError, CaseProblem


def read_rows(file: Path, columns: Sequence[str], numbers: Sequence[str], page: str) -> list[dict[str, str]]:
    """Return the rows of a table by column.

    The table has at least these ``columns``; of them, ``numbers`` have numbers or nothing.  ``page`` is the
    page of the documentation that explains the table.  Raises CaseError.
    """
    try:
        with file.open(encoding="utf-8", newline="") as text:
            table = csv.DictReader(text)
            rows = [*table]
            missing = [name for name in columns if name not in (table.fieldnames or ())]
    except (OSError, UnicodeDecodeError) as error:
        raise CaseError([CaseProblem((), f"cannot be read: {error}", file=str(file), kind="file")]) from None
    problems = [
        CaseProblem((name,), "is a missing column", page, str(file), kind="missing") for name in missing
    ]
    for number, row in enumerate(rows if not missing else ()):
        for name in numbers:
            try:
                float(row[name] or 0.0)
            except (TypeError, ValueError):
                what = f'"{row[name]}" is not a number'
                problems.append(CaseProblem((number, name), what, file=str(file), kind="wrong-type"))
    if problems:
        raise CaseError(problems)
    return rows
