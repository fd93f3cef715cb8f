"""The page that sets flipflow beside other tools: each entry has a source, or says that none is known."""

from __future__ import annotations

import re

import pytest

from tests.docs.pages import DOCS

PAGE = (DOCS / "beside-other-tools.md").read_text(encoding="utf-8")
TOOLS = ["flipflow", "EDEM", "Rocky", "LIGGGHTS-PUBLIC", "Yade", "MercuryDPM", "Kratos (DEM)", "preCICE"]
WITHOUT_SOURCE = ("not known", "none", "that of the coupled program")
TABLES = [
    [[cell.strip() for cell in line.strip("|").split("|")] for line in lines.splitlines()]
    for lines in re.findall(r"(?:^\|.*\n)+", PAGE, re.M)
]


@pytest.mark.parametrize("table", TABLES, ids=[table[0][1] for table in TABLES])
def test_each_entry_has_a_source(table: list[list[str]]) -> None:
    head, _, *rows = table
    assert [row[0] for row in rows] == TOOLS
    for tool, *cells in rows:
        assert len(cells) == len(head) - 1
        for cell in cells:
            assert "](" in cell or "][" in cell or cell.startswith(WITHOUT_SOURCE), f"{tool}: {cell}"


def test_each_reference_is_used_and_there() -> None:
    assert set(re.findall(r"\]\[([\w-]+)\]", PAGE)) == set(
        re.findall(r"^\[([\w-]+)\]: https?://\S+$", PAGE, re.M)
    )
