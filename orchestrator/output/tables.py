"""Tables of rows for the terminal and for other programs."""

from __future__ import annotations

import csv
from collections.abc import Collection, Iterable, Mapping, Sequence
from pathlib import Path

from rich import box
from rich.table import Table

from orchestrator.case.file.whole import written_whole

Cell = str | float | int | None


def align_rows(rows: Sequence[Mapping[str, Cell]]) -> list[dict[str, Cell]]:
    """Return the rows with all columns of all rows; a cell is None where its value is unknown."""
    columns = dict.fromkeys(name for row in rows for name in row)
    return [{name: row.get(name) for name in columns} for row in rows]


def write_csv(rows: Sequence[Mapping[str, Cell]], file: Path) -> Path:
    """Write rows as CSV, and return the file.

    The columns of the rows may differ; a cell without a known value is empty.
    """
    lines = align_rows(rows)
    with written_whole(file) as aside, aside.open("w", newline="", encoding="utf-8") as text:
        writer = csv.DictWriter(text, [*lines[0]] if lines else [])
        writer.writeheader()
        writer.writerows(lines)
    return file


def write_parquet(rows: Sequence[Mapping[str, Cell]], file: Path) -> Path:
    """Write rows as Parquet, whose columns have types, and return the file."""
    import pyarrow
    from pyarrow import parquet

    with written_whole(file) as aside:
        parquet.write_table(pyarrow.Table.from_pylist(align_rows(rows)), aside)
    return file


def console_table(
    title: str, head: Iterable[str], rows: Iterable[Iterable[str]], left: Collection[str] = ()
) -> Table:
    """Return a table for the terminal; the first column and the columns ``left`` are text, others numbers.

    What is too long for its column goes on in the next line.
    """
    table = Table(title=title or None, title_justify="left", box=box.SIMPLE_HEAD)
    for number, name in enumerate(head):
        text = number == 0 or name in left
        table.add_column(name, justify="left" if text else "right", overflow="fold")
    for row in rows:
        table.add_row(*row)
    return table
