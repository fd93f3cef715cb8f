"""Reading the files of a case: none that is not its own, none that is too large."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from orchestrator.case.file.errors import CaseError, CaseProblem

DEEPEST = 20  # tables in each other; the case format has 7
TOO_DEEP = "is nested too deeply"
LARGEST_BYTES = 1_000_000  # the largest case of this project has 10 000


def read_toml(file: Path, within: Path | None = None) -> dict[str, Any]:
    """The table in a file, which must not be a link to one outside of the folder ``within``.
    Raises CaseError when it cannot be read or is not TOML."""
    try:
        if within is not None and is_outside(file, within):
            what = "is a link to a file outside of the case's folder"
        elif file.exists() and not file.is_file():
            what = "is no file"
        else:
            with file.open("rb") as opened:
                content = opened.read(LARGEST_BYTES + 1)
            what = f"is larger than {LARGEST_BYTES} bytes"
            if len(content) <= LARGEST_BYTES:
                table = tomllib.loads(content.decode("utf-8-sig"))
                if not is_too_deep(table):
                    return table
                what = TOO_DEEP
    except OSError as error:
        what = f"cannot be read: {error.strerror}"
    except UnicodeDecodeError:
        what = "is no text file (UTF-8 is wanted)"
    except ValueError as error:
        what = f"is not TOML: {error}"
    except RecursionError:
        what = TOO_DEEP
    except RuntimeError:
        what = "is a link to itself"
    raise CaseError([CaseProblem((), what, file=str(file))])


def is_too_deep(given: Any) -> bool:
    """Whether there are tables in tables in tables, on which all that comes after would choke."""
    inside: list[Any] = [given]
    for _ in range(DEEPEST):
        tables = [list(v.values()) if isinstance(v, dict) else v for v in inside]
        inside = [value for table in tables if isinstance(table, list) for value in table]
    return bool(inside)


def is_outside(file: Path, folder: Path) -> bool:
    """Whether a file is really somewhere else, by ``..`` or by links."""
    return not file.resolve().is_relative_to(folder.resolve())
