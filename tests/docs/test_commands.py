"""The documents name commands and options that the program has."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tools.command_reference.__main__ import command_reference, commands

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md")), *sorted((ROOT / "cases").rglob("*.md"))]
CODE = re.compile(r"^```.*?^```|`[^`\n]+`", re.M | re.S)
CALL = re.compile(r"\bflipflow (study [a-z]+|[a-z]+)((?:(?!\bflipflow )[^\n;|&#`])*)")
GONE = "ladder"  # Pages of measurements name the command as it was then.
OPTIONS = {
    name: {option for parameter in command.params for option in parameter.opts} | {"--help"}
    for name, command in commands()
}


def test_the_page_of_the_commands_is_that_of_the_program() -> None:
    page = (ROOT / "docs/commands.md").read_text(encoding="utf-8")
    assert page == command_reference(), "python -m tools.command_reference > docs/commands.md"


def wrong_options(text: str) -> list[str]:
    """The options after ``flipflow <command>`` in a page's code that the command does not have."""
    code = "\n".join(CODE.findall(text)).replace("\\\n", " ")
    return [
        f"flipflow {name} {option}"
        for name, words in CALL.findall(code)
        for option in re.findall(r"(?<!\S)\[?(--[a-z][a-z-]*)", words)
        if name != GONE and option not in OPTIONS.get(name, set())
    ]


def test_a_wrong_option_is_found() -> None:
    block = "```\nflipflow study sweep x \\\n  --vary a --numbr 3 | cat --all\n```\n"
    page = f"`flipflow run x --levle draft`\n{block}"
    assert wrong_options(page) == ["flipflow run --levle", "flipflow study sweep --numbr"]


@pytest.mark.parametrize("page", PAGES, ids=[str(page.relative_to(ROOT)) for page in PAGES])
def test_options_in_the_documents_exist(page: Path) -> None:
    assert wrong_options(page.read_text(encoding="utf-8")) == []
