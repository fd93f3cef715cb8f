"""The output of studies: tables for the terminal, for other programs and for the manual, pictures of several
parts, and pages that embed all their pictures."""

from __future__ import annotations

import csv
from collections.abc import Collection, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from rich import box
from rich.table import Table

from orchestrator.case.file.whole import write_text, written_whole
from orchestrator.views.style import data_uri, figure, fill_template

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


def markdown_table(head: Sequence[str], rows: Iterable[Iterable[str]]) -> str:
    """Return a table in Markdown for the manual."""
    cells = (" | ".join(cell.replace("|", "\\|") for cell in row) for row in (head, *rows))
    first, *others = (f"| {line} |" for line in cells)
    return "\n".join([first, "|" + "---|" * len(head), *others]) + "\n"


def percent(share: float | None) -> str:
    """Return a share in per cent with two digits, or an empty text for no share."""
    if share is None:
        return ""
    return f"{100 * share:.2g} %" if abs(share) < 0.1 else f"{100 * share:.0f} %"


def figure_parts(count: int, columns: int, width: float, height: float) -> tuple[Any, list[Any]]:
    """Return a figure of ``count`` parts and their axes; ``width`` and ``height`` of a part are in inches."""
    rows = -(-count // columns)
    drawn, grid = figure(rows, columns, width * columns, height * rows)
    for axis in grid.flat[count:]:
        axis.axis("off")
    return drawn, list(grid.flat[:count])


def write_page(template: str, file: Path, **values: Any) -> Path:
    """Fill a template with values, write it to a file, and return the file.

    ``template`` is its path in ``studies/``; it extends ``studies/page.html`` and may embed the picture in a
    file by ``picture(file)``.
    """
    values["picture"] = lambda image: data_uri(image.read_bytes(), "image/png")
    write_text(file, fill_template(f"studies/{template}", **values))
    return file
