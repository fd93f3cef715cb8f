"""The page docs/commands.md, made from the commands of the program.

``python -m tools.command_reference > docs/commands.md`` writes it.
"""

from __future__ import annotations

import inspect
import sys
from collections.abc import Iterator
from typing import Any

import typer

from orchestrator.cli.main import app

HEAD = """\
# Commands

Every command of `flipflow` with its arguments and options, as `--help` has them.
`flipflow --version` prints the versions of all programs. Case, level and `--set` are explained in
[case-format](case-format.md), and what a run leaves behind in [run-folder](run-folder.md).

This page is made from the program (`python -m tools.command_reference`); a test keeps it true.
"""
TABLE = "| argument or option | meaning | default |\n| --- | --- | --- |"


def command_reference() -> str:
    """Return docs/commands.md."""
    lines = [HEAD]
    for name, command in commands():
        lines += [f"## flipflow {name}\n", "```text", inspect.cleandoc(command.help or ""), "```\n"]
        rows = [_row(parameter) for parameter in command.params if not parameter.hidden]
        lines += [TABLE, *rows, ""]
    return "\n".join(lines).rstrip() + "\n"


def commands() -> Iterator[tuple[str, Any]]:
    """Yield the name, such as "study sweep", and the command of every command that ``--help`` shows."""
    yield from _commands_of(typer.main.get_command(app))


def _commands_of(group: Any, above: str = "") -> Iterator[tuple[str, Any]]:
    context = typer.Context(group)
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        if hasattr(command, "list_commands"):
            yield from _commands_of(command, f"{above}{name} ")
        elif not command.hidden:
            yield f"{above}{name}", command


def _row(parameter: Any) -> str:
    """Return the row of an argument or an option in the table of its command."""
    is_option = parameter.param_type_name == "option"
    names = ", ".join(f"`{name}`" for name in parameter.opts) if is_option else f"`{parameter.metavar}`"
    meaning, _, told = str(parameter.help or "").partition(" [default: ")
    given = parameter.default
    default = told.removesuffix("]") if told else "" if given in (None, False, "", ()) else str(given)
    if parameter.required:
        default = "must be given"
    return f"| {names} | {_plain(meaning)} | {_plain(default)} |"


def _plain(text: str) -> str:
    """Return a text in which Markdown finds no marks."""
    return text.replace("<", r"\<").replace("|", r"\|").replace("*", r"\*")


if __name__ == "__main__":
    sys.stdout.write(command_reference())
