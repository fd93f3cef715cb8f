"""The page docs/commands.md, made from the commands of the program.

``python -m tools.command_reference > docs/commands.md`` writes it.
"""

from __future__ import annotations

import inspect
import sys
from collections import Counter
from collections.abc import Iterator
from itertools import chain
from textwrap import indent
from typing import Any, NamedTuple

import typer

from orchestrator.cli.main import app

HEAD = """\
# Commands

Every command of `flipflow`, as `--help` has them (`python -m tools.command_reference`).
`flipflow --version` prints versions. [case-format](case-format.md) explains cases,
levels and `--set`, [run-folder](run-folder.md) results and exit codes.
What is in **bold** must be given. "Also" are the [options of several commands](#options-of-several-commands).

## Options of several commands
"""


def command_reference() -> str:
    """Return docs/commands.md."""
    rows = {name: _rows(command) for name, command in commands()}
    count = Counter(chain.from_iterable(rows.values()))
    common = [row for row, times in count.items() if times > 1]
    lines = [HEAD, *map(_line, common), ""]
    for name, command in commands():
        lines += [f"## flipflow {name}\n", indent(inspect.cleandoc(command.help or ""), "    "), ""]
        if also := [row.names.split(",")[0] for row in rows[name] if row in common]:
            lines += [f"- also {', '.join(also)}"]
        lines += [*(_line(row) for row in rows[name] if row not in common), ""]
    return "\n".join(lines).rstrip() + "\n"


class Row(NamedTuple):
    """An argument or an option in the list of its command."""

    names: str
    meaning: str
    default: str


def _line(row: Row) -> str:
    default = f" (default: {row.default})" if row.default else ""
    return f"- {row.names}: {row.meaning}{default}"


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


def _rows(command: Any) -> list[Row]:
    """Return the rows of a command's arguments and options."""
    return [_row(parameter) for parameter in command.params if not parameter.hidden]


def _row(parameter: Any) -> Row:
    is_option = parameter.param_type_name == "option"
    names = ", ".join(f"`{name}`" for name in parameter.opts) if is_option else f"`{parameter.metavar}`"
    meaning, _, told = str(parameter.help or "").partition(" [default: ")
    given = parameter.default
    default = told.removesuffix("]") if told else "" if given in (None, False, "", ()) else str(given)
    names = f"**{names}**" if parameter.required else names
    return Row(names, _plain(meaning), "" if parameter.required else _plain(default))


def _plain(text: str) -> str:
    """Return a text in which Markdown finds no marks."""
    return text.replace("<", r"\<").replace("*", r"\*")


if __name__ == "__main__":
    sys.stdout.write(command_reference())
