"""The tables of results in docs/run-folder.md, made from the records of ``orchestrator/figures``.

``python -m tools.results_reference docs/run-folder.md`` writes them anew, in the place of those between the
headings ``### each of `probes` `` and ``## Folders of studies``.
"""

from __future__ import annotations

import inspect
import sys
from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path

from orchestrator.figures.figure import inner_kind, is_table, kinds_of, record_of
from orchestrator.figures.machine import PointRange
from orchestrator.figures.results import Results, figure_at
from orchestrator.figures.short_names import SHORT_NAMES

BEGIN, END = "### each of `probes`\n", "## Folders of studies\n"
HEAD = "| key | meaning | unit | resolution | slice | short names |\n| --- | --- | --- | --- | --- | --- |"


def results_reference(page: str) -> str:
    """Return docs/run-folder.md with its tables of results made anew."""
    before, rest = page.split(BEGIN, 1)
    after = rest.split(END, 1)[1]
    intro = Path(__file__).with_name("results.md").read_text(encoding="utf-8")
    probes, results = _sections(PointRange, "probes", many=True), _sections(Results, "results")
    return f"{before}{''.join(probes)}{''.join(results).replace('INTRO', intro.rstrip(), 1)}{END}{after}"


def _sections(table: type, path: str, many: bool = False) -> Iterator[str]:
    """Yield the section of a table, and those of the tables in it."""
    about = "INTRO" if table is Results else inspect.getdoc(table) or ""
    rows = [*_rows(table, path + (".*" if many else ""))]
    heading = f"each of `{path}`" if many else f"`{path}`"
    yield f"### {heading}\n\n{about}\n\n{HEAD}\n" + "".join(f"{row}\n" for row in rows) + "\n"
    for name, kind in kinds_of(table).items():
        if is_table(inner_kind(kind)):
            inside = f"{path}.{name}"
            yield from _sections(inner_kind(kind), inside, inner_kind(kind) is not kind)


def _rows(table: type, path: str) -> Iterator[str]:
    """Yield the row of each figure and table in a table."""
    for each in fields(table):
        record, kind = record_of(each), kinds_of(table)[each.name]
        joined = ". " if record.about[:1].isupper() else ": "
        meaning = record.words + (joined + record.about if record.about else "")
        cells = [f"`{each.name}`", meaning, "", "", "", ""]
        if is_table(inner_kind(kind)):
            cells[1] += ", see below"
        elif (figure := figure_at(f"{path}.{each.name}")) and _is_number(kind):
            cells[2] = figure.unit if figure.unit != "1" else ""
            cells[3] = f"{figure.floor:g}" if figure.floor else ""
            cells[4] = "its share" if figure.is_extensive else ""
            cells[5] = ", ".join(
                f"`{name}`" for name, short in SHORT_NAMES.items() if short.figure.path == figure.path
            )
        yield f"| {' | '.join(cells)} |"


def _is_number(kind: object) -> bool:
    """Return whether the figures of a type are numbers."""
    return inner_kind(kind) not in (str, bool)


if __name__ == "__main__":
    file = Path(sys.argv[1])
    file.write_text(results_reference(file.read_text(encoding="utf-8")), encoding="utf-8")
