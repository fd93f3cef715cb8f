"""The views of a machine that ``flipflow show`` and ``flipflow check --html`` write."""

from __future__ import annotations

from pathlib import Path

from orchestrator.case.deck.stl import UnreadableSurface
from orchestrator.case.file.errors import CaseError
from orchestrator.cli.console import find_all_problems, refuse
from orchestrator.output.records.run_folder import write_page
from orchestrator.preflight.check import warnings
from orchestrator.preflight.judge import JudgedCase
from orchestrator.views.page import CheckFindings, Views

RUNS = Path("runs")


def show(loaded: JudgedCase, out: Path | None) -> tuple[list[Path], CheckFindings]:
    """Write the views of a case whose tables fit together, and return the files and what was found.

    The case may have other problems, which the page names.  Raises CaseError if a surface cannot be read.
    """
    folder = out or RUNS / f"{loaded.name}-machine"
    if folder.exists() and not folder.is_dir():
        refuse(f"{folder}: is a file; name a folder: --out FOLDER")
    problems = find_all_problems(loaded)
    try:
        views = Views(loaded)
    except UnreadableSurface as error:
        raise CaseError(problems) from error
    found = CheckFindings([str(problem) for problem in problems], [] if problems else warnings(loaded))
    try:
        return views.write(folder, found), found
    except OSError as error:
        refuse(f"{folder}: {error.strerror or error}")


def write_check_page(loaded: JudgedCase, lines: list[str], file: Path) -> None:
    """Write one page with the ``lines`` of ``check`` about a case without problems, and with its views."""
    warned = "warning: "
    said = [line.removeprefix(warned) for line in lines if line.startswith(warned)]
    page = Views(loaded).page(
        CheckFindings((), said, [line for line in lines if not line.startswith(warned)])
    )
    try:
        write_page(file, page)
    except OSError as error:
        refuse(f"{file}: {error.strerror or error}")
