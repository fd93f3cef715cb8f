"""The console of all commands, with their exit codes and their reports of errors."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import typer
from rich.console import Console
from rich.text import Text

from orchestrator.case.file.printable import escape_unprintable

if TYPE_CHECKING:
    from orchestrator.case.file.errors import CaseProblem
    from orchestrator.preflight.judge import JudgedCase


class TextConsole(Console):
    """A console that no text controls: of unprintable characters, such as ESC, the escapes are printed."""

    def render_str(self, text: str, **options: Any) -> Text:
        """Return a string, on its own or in a table, as a text that can be printed."""
        return super().render_str(escape_unprintable(text), **options)


CONSOLE = TextConsole(highlight=False, markup=False, soft_wrap=True)
ERRORS = TextConsole(stderr=True, highlight=False, markup=False, soft_wrap=True)
WRONG, MISSING, FAILED = 2, 3, 4
UNLIMITED = 10_000  # columns of tables that no terminal shows: nothing of them is cut
TOO_LARGE = "out of memory: the case is too large for this machine; fewer panel.cells need less of it"


@contextmanager
def reported_errors() -> Iterator[None]:
    """Report an error inside the context, and end the program with the error's exit code.

    An internal error is raised as it is.
    """
    try:
        yield
    except KeyboardInterrupt as stop:
        raise typer.Exit(128 + getattr(stop, "signal", signal.SIGINT)) from None
    except Exception as raised:
        is_memory = isinstance(raised.__cause__, MemoryError)  # of a solver that could not be opened
        error = raised.__cause__ if is_memory else raised
        assert isinstance(error, Exception), "a cause that is out of memory, or the error itself"
        code = _code(error)
        if code is None:
            raise
        ERRORS.print(TOO_LARGE if isinstance(error, MemoryError) else _in_words(error))
        raise typer.Exit(code) from None


def _in_words(error: Exception) -> str:
    if isinstance(error, OSError) and error.filename is not None:
        return f"{error.filename}: {error.strerror}"
    return str(error)


def _code(error: Exception) -> int | None:
    """Return the exit code of an error; None for an internal error."""
    from orchestrator.case.file.errors import CaseError
    from orchestrator.case.file.folder import FolderUnusable, UnreadableFile
    from orchestrator.ports.plans import SolverFailed, SolverMissing

    if isinstance(error, SolverMissing):
        return MISSING
    if isinstance(error, SolverFailed):
        return FAILED
    if isinstance(error, BrokenPipeError):  # who reads the output has gone
        return None
    wrong = CaseError | FolderUnusable | UnreadableFile | MemoryError | OSError
    return WRONG if isinstance(error, wrong) else None


def find_all_problems(loaded: JudgedCase) -> list[CaseProblem]:
    """Return every problem that prevents a run of a case."""
    from orchestrator.preflight.check import find_problems

    problems = find_problems(loaded)
    if loaded.case.monitor.items:
        from orchestrator.run.monitor.items import unknown_items

        problems += unknown_items(loaded.case)
    return problems


def find_all_problems_when_open(loaded: JudgedCase) -> list[CaseProblem]:
    """Return every problem that prevents a run, with those that show when a run opens its panels."""
    from orchestrator.coupling.build import find_problems_when_open

    return find_all_problems(loaded) or find_problems_when_open(loaded)


def check_or_report(
    case: Path,
    level: str | None,
    overrides: list[str] | None,
    find: Callable[[JudgedCase], list[CaseProblem]] = find_all_problems,
    as_json: bool = False,
) -> JudgedCase:
    """Return the case at a level if ``find`` finds no problem in it.

    Otherwise report all problems, as JSON on standard output, too, if that is asked for, and end the program.
    """
    from orchestrator.case.file.errors import CaseError
    from orchestrator.preflight.judge import load_judged

    with reported_errors():
        try:
            loaded = load_judged(case, level, overrides or [])
            if problems := find(loaded):
                raise CaseError(problems)
        except CaseError as error:
            if as_json:
                from orchestrator.cli.json_forms import print_json

                print_json({"problems": [problem.as_json() for problem in error.problems]})
            raise
    return loaded


def refuse(why: str) -> NoReturn:
    """Print why the command cannot be carried out, and end the program."""
    ERRORS.print(why)
    raise typer.Exit(WRONG)
