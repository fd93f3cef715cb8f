"""``flipflow study``: every module of ``orchestrator/studies/commands`` is one of its commands, and every
module that an installed package names as an entry point of the group ``flipflow.studies``."""

from __future__ import annotations

import functools
import pkgutil
from collections.abc import Callable
from importlib import import_module
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

import typer
from typer.core import TyperGroup

from orchestrator.cli.console import CONSOLE, FAILED, reported_errors
from orchestrator.studies import commands
from orchestrator.studies.options import StudyOutput, with_options

GROUP = "flipflow.studies"
WIDE = 150  # columns, of what goes into a file


class Studies(TyperGroup):
    """The studies that there are; each is imported when it is asked for."""

    def list_commands(self, ctx: Any) -> list[str]:
        """Return their names: those of the modules and of entry points."""
        return sorted({*_own_modules(), *entry_points(group=GROUP).names})

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Return a study as a command.  Raises BadParameter where there is none of this name."""
        if cmd_name not in (names := self.list_commands(ctx)):
            from orchestrator.case.file.errors import did_you_mean

            raise typer.BadParameter(f'no study "{cmd_name}"; {did_you_mean(cmd_name, names)}')
        own = _own_modules().get(cmd_name)
        module = import_module(own) if own else entry_points(group=GROUP)[cmd_name].load()
        alone = typer.Typer(add_completion=False, rich_markup_mode=None)
        alone.command(cmd_name)(_spoken(with_options(module.command, cmd_name)))
        return typer.main.get_command(alone)


def _own_modules() -> dict[str, str]:
    modules = (module.name for module in pkgutil.iter_modules(commands.__path__))
    return {name.replace("_", "-"): f"{commands.__name__}.{name}" for name in modules}


study = typer.Typer(cls=Studies, help="Many runs, and what they say together.", no_args_is_help=True)


def _spoken(command: Callable[..., StudyOutput]) -> Callable[..., None]:
    """Return the function that carries a study's command out and say what it yields."""

    @functools.wraps(command)
    def speak(*args: Any, **options: Any) -> None:
        with reported_errors():
            if not _say_all(command(*args, **options)):
                raise typer.Exit(FAILED)

    return speak


def _say_all(told: StudyOutput) -> bool:
    if not CONSOLE.is_terminal:
        CONSOLE.width = WIDE
    while True:
        try:
            each = next(told)
        except StopIteration as end:
            return bool(end.value)
        if isinstance(each, Path):
            CONSOLE.print(f"written: {each}")
        else:
            CONSOLE.print(each, soft_wrap=isinstance(each, str))
