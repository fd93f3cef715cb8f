"""The command ``flipflow study``.

Every module of ``orchestrator/cli/studies`` is one of its commands, and so is every module that an
installed package names as an entry point of the group ``flipflow.studies``.
"""

from __future__ import annotations

import functools
import pkgutil
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from importlib.metadata import entry_points
from pathlib import Path
from types import FrameType
from typing import Any

import typer
from typer.core import TyperGroup

from orchestrator.cli import studies as commands
from orchestrator.cli.console import CONSOLE, FAILED, UNLIMITED, reported_errors
from orchestrator.cli.options import StudyOutput, with_options
from orchestrator.output.subprocesses import stop_all
from orchestrator.run.interruption import ImmediateStop

GROUP = "flipflow.studies"


class Studies(TyperGroup):
    """The group of all studies; each study is imported when a user calls it."""

    def list_commands(self, ctx: Any) -> list[str]:
        """Return the names of all studies, of modules and of entry points."""
        return sorted({*_own_modules(), *entry_points(group=GROUP).names})

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Return a study as a command.  Raises BadParameter if there is no study of this name."""
        if cmd_name not in (names := self.list_commands(ctx)):
            from orchestrator.case.file.errors import did_you_mean

            raise typer.BadParameter(f'no study "{cmd_name}"; {did_you_mean(cmd_name, names)}')
        own = _own_modules().get(cmd_name)
        module = import_module(own) if own else entry_points(group=GROUP)[cmd_name].load()
        alone = typer.Typer(add_completion=False, rich_markup_mode=None)
        alone.command(cmd_name)(_printing(with_options(module.command, cmd_name)))
        return typer.main.get_command(alone)


def _own_modules() -> dict[str, str]:
    modules = (module.name for module in pkgutil.iter_modules(commands.__path__))
    return {name.replace("_", "-"): f"{commands.__name__}.{name}" for name in modules}


study = typer.Typer(cls=Studies, help="Many runs, and what they say together.", no_args_is_help=True)


def _printing(command: Callable[..., StudyOutput]) -> Callable[..., None]:
    """Return a function that runs the command of a study and prints its output.

    SIGTERM and SIGHUP stop the study and its runs.
    """

    @functools.wraps(command)
    def run_and_print(*args: Any, **options: Any) -> None:
        with reported_errors(), ending_with_runs():
            if not _print_all(command(*args, **options)):
                raise typer.Exit(FAILED)

    return run_and_print


@contextmanager
def ending_with_runs() -> Iterator[None]:
    """Stop all runs of this process, too, where a signal ends it; SIGHUP stays ignored under nohup.

    Ctrl-C reaches the runs without this, because a terminal sends it to all processes.
    """

    def stop(number: int, _: FrameType | None) -> None:
        stop_all()
        raise ImmediateStop(number, f"stopped by {signal.Signals(number).name}")

    caught = [each for each in (signal.SIGTERM, signal.SIGHUP) if signal.getsignal(each) is signal.SIG_DFL]
    for each in caught:
        signal.signal(each, stop)
    try:
        yield
    finally:
        for each in caught:
            signal.signal(each, signal.SIG_DFL)


def _print_all(output: StudyOutput) -> bool:
    """Print all that a study yields, and return whether it succeeded."""
    if not CONSOLE.is_terminal:
        CONSOLE.width = UNLIMITED
    while True:
        try:
            item = next(output)
        except StopIteration as end:
            return bool(end.value)
        if isinstance(item, Path):
            CONSOLE.print(f"written: {item}")
        else:
            CONSOLE.print(item, soft_wrap=isinstance(item, str))
