"""The output of studies: tables for the manual, pictures of several parts, and pages that embed them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from orchestrator.output.drawing import data_uri, figure, fill_template
from orchestrator.output.records.run_folder import write_text


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
