"""A file of measured data that a key of a case names: a text in the case's folder."""

from __future__ import annotations

from pathlib import Path

from orchestrator.case.file.errors import CaseError, CaseProblem, Key, show_value

LARGEST_BYTES = 1_000_000


def read_data_file(folder: Path, name: str, key: Key, source: str) -> str:
    """Return the text of a file in the case's folder, in UTF-8 or, as spreadsheets write, in Windows' code.

    ``key`` names the file, and ``source`` is the file or option that gave the key.  Raises CaseError for a
    file outside of the folder, and for one that cannot be read or is no text.
    """
    file = (folder / name).resolve()
    if not file.is_relative_to(folder.resolve()):
        what = f"{show_value(name)} is outside of the case's folder"
        raise CaseError([CaseProblem(key, what, file=source, kind="file")])
    try:
        if file.exists() and not file.is_file():  # a pipe would be waited for
            raise CaseError([CaseProblem(key, "is no file", file=name, kind="file")])
        if file.stat().st_size > LARGEST_BYTES:
            raise CaseError(
                [CaseProblem(key, f"is larger than {LARGEST_BYTES} bytes", file=name, kind="file")]
            )
        return _text(file.read_bytes())
    except (OSError, UnicodeDecodeError) as error:
        why = error.strerror if isinstance(error, OSError) else error
        raise CaseError([CaseProblem(key, f"cannot be read: {why}", file=name, kind="file")]) from error


def _text(data: bytes) -> str:
    """Return the text that the bytes of a file are.  Raises UnicodeDecodeError."""
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("cp1252")
