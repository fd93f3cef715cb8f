"""A file of measured data that a key of a case names: a text in the case's folder."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

from orchestrator.case.file.data_table import Answers, TableError, decode
from orchestrator.case.file.errors import CaseError, CaseProblem, Key, show_value

LARGEST_BYTES = 1_000_000
Read = TypeVar("Read")


def read_data_file(folder: Path, name: str, key: Key, source: str) -> str:
    """Return the text of a file in the case's folder, in one of the codes that ``decode`` knows.

    ``key`` names the file, and ``source`` is the file or option that gave the key.  Raises CaseError for a
    file outside of the folder, and for one that cannot be read or is no text.
    """
    file = (folder / name).resolve()
    if not file.is_relative_to(folder.resolve()):
        what = f"{show_value(name)} is outside of the case's folder"
        raise CaseError([CaseProblem(key, what, file=source, kind="file")])
    try:
        if file.exists() and not file.is_file():  # a pipe would be waited for
            raise CaseError([CaseProblem(key, "is not a file", file=name, kind="file")])
        if file.stat().st_size > LARGEST_BYTES:
            raise CaseError(
                [CaseProblem(key, f"is larger than {LARGEST_BYTES} bytes", file=name, kind="file")]
            )
        return decode(file.read_bytes())
    except (OSError, TableError) as error:
        why = f"cannot be read: {error.strerror}" if isinstance(error, OSError) else str(error)
        raise CaseError([CaseProblem(key, why, file=name, kind="file")]) from error


def read_with(
    read: Callable[[str, Answers], Read],
    table: Mapping[str, Any],
    folder: Path,
    name: str,
    key: Key,
    source: str,
) -> Read:
    """Return what a function reads from a file and from what its table of the case answers of it.

    ``table`` stands around the key; its ``columns`` and ``decimal`` go to the function.  Raises CaseError.
    """
    text = read_data_file(folder, name, key, source)
    try:
        return read(text, answers_in(table))
    except TableError as error:
        raise CaseError(
            [CaseProblem(key, reason, file=name, kind="file") for reason in error.reasons]
        ) from None


def answers_in(table: Mapping[str, Any]) -> Answers:
    """Return the answers in a table of a case.  Raises TableError for what can be none."""
    columns, decimal = table.get("columns", {}), table.get("decimal", "")
    if not isinstance(columns, dict) or not all(isinstance(each, str) for each in columns.values()):
        raise TableError("columns is a table from a column's name in the file to a name that is clear")
    if decimal not in ("", ".", ","):
        raise TableError(f'decimal is "." or ",", not {show_value(decimal)}')
    return Answers(columns, decimal)
