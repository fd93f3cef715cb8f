"""The measured pages and the CSV files beside them: named, dated, and with the same rows."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator
from datetime import date
from pathlib import Path

import pytest

MEASURED = Path(__file__).parents[2] / "docs" / "measured"
PAGES = sorted(MEASURED.glob("*.md"))
LINK = re.compile(r"\]\((\w+\.csv)\)")
CELL = re.compile(r"(?<!\\)\|")


def records(name: str) -> list[dict[str, str]]:
    with (MEASURED / name).open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def plain(cell: str) -> str:
    return re.sub(r"[`*$]", "", cell).replace("\\|", "|").strip()


def tables(text: str) -> Iterator[tuple[list[str], list[list[str]]]]:
    """Yield the head and the rows of each table of a page."""
    for block in re.findall(r"(?:^\|.*\n)+", text, flags=re.MULTILINE):
        head, _, *rows = [[plain(cell) for cell in CELL.split(line)[1:-1]] for line in block.splitlines()]
        yield head, rows


@pytest.mark.parametrize("page", PAGES, ids=[page.stem for page in PAGES])
def test_rows_of_a_page_are_rows_of_the_file_beside_it(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    for name in sorted(set(LINK.findall(text))):
        recorded = [{key: plain(cell) for key, cell in row.items()} for row in records(name)]
        for head, rows in tables(text):
            if set(head) <= recorded[0].keys():
                kept = {tuple(row[key] for key in head) for row in recorded}
                assert {tuple(row) for row in rows} <= kept, name


def test_every_file_is_named_by_a_page_and_its_days_are_days() -> None:
    text = "".join(page.read_text(encoding="utf-8") for page in PAGES)
    for file in MEASURED.glob("*.csv"):
        assert file.name in text, f"no page names {file.name}"
        for row in records(file.name):
            if "recorded" in row:
                assert date.fromisoformat(row["recorded"]), file.name
