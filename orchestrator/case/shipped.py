"""The cases that come with the program, which are found by their names from every folder."""

from __future__ import annotations

from pathlib import Path

from orchestrator.case.file.base import CASE_FILE
from orchestrator.case.file.errors import did_you_mean

SHIPPED = Path(__file__).parents[2] / "cases"
"""The folder of the cases, beside the packages in the clone that an editable installation runs."""


def find(path: Path) -> Path:
    """Return a path itself if it exists, else that of a case, or a file in it, which comes with the program.

    "quickstart" and "cases/quickstart" name the same case.  A name that is neither is returned as it is.
    """
    if path.is_absolute() or ".." in path.parts or path.exists():
        return path
    parts = path.parts[1:] if path.parts[:1] == (SHIPPED.name,) else path.parts
    found = SHIPPED.joinpath(*parts)
    return found if parts and found.exists() else path


def no_such_case_hint(path: Path) -> str:
    """Return a hint for a name under which there is no case: the nearest of the cases that are shipped."""
    names = sorted(file.parent.name for file in SHIPPED.glob(f"*/{CASE_FILE}"))
    return "" if path.is_absolute() or not names else did_you_mean(path.name, names, say="shipped cases")
