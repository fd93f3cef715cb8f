"""The tables of results in docs/run-folder.md, made from the records of ``orchestrator/figures``.

``python -m tools.results_reference docs/run-folder.md`` writes them anew, in the place of those between the
headings ``### each of `probes` `` and ``## Folders of studies``.
"""

from __future__ import annotations

import inspect
import sys
from collections.abc import Iterator
from dataclasses import Field, fields, is_dataclass
from pathlib import Path
from textwrap import fill
from typing import Any

from orchestrator.figures.figure import ROUNDING, inner_kind, is_table, kinds_of, record_of
from orchestrator.figures.machine import PointRange
from orchestrator.figures.results import Results, figure_at
from orchestrator.figures.short_names import SHORT_NAMES

BEGIN, END = "### each of `probes`\n", "## Folders of studies\n"
HEAD = "|key |meaning|\n|---|---|"
WIDTH = 170
SMALL = 4
"""A table with so many figures and no tables in it has no section of its own."""


def results_reference(page: str) -> str:
    """Return docs/run-folder.md with its tables of results made anew."""
    before, rest = page.split(BEGIN, 1)
    after = rest.split(END, 1)[1]
    probes, results = _sections(PointRange, "probes", many=True), _sections(Results, "results")
    return f"{before}{''.join(probes)}{''.join(results)}{END}{after}"


def _sections(table: type, path: str, many: bool = False) -> Iterator[str]:
    """Yield the section of a table, and those of the tables in it that are not small."""
    heading = f"each of `{path}`" if many else f"`{path}`"
    yield f"### {heading}\n\n{_about(table)}\n\n"
    own = [each for each in fields(table) if each.name not in _shared(table)]
    if shared := _shared(table):
        yield f"As in `results.motion.frames`: {', '.join(f'`{name}`' for name in shared)}.\n\n"
    rows = (_row(each, table, f"{path}{'.*' * many}.{each.name}") for each in own)
    yield "\n".join([HEAD, *rows]) + "\n\n"
    for each in own:
        kind = kinds_of(table)[each.name]
        if is_table(inner_kind(kind)) and not _is_small(inner_kind(kind)):
            yield from _sections(inner_kind(kind), f"{path}.{each.name}", inner_kind(kind) is not kind)


def _about(table: type) -> str:
    """Return what stands above the figures of a table."""
    if table is not Results:
        return fill(" ".join((inspect.getdoc(table) or "").split()), WIDTH)
    sizes = ", ".join(f"{size:g} {unit}" for unit, size in ROUNDING.items())
    intro = Path(__file__).with_name("results.md").read_text(encoding="utf-8").rstrip()
    return intro.replace("RESOLUTIONS", sizes)


def _shared(table: type) -> list[str]:
    """Return the names of the figures that a table has from another one."""
    base: Any = table.__mro__[1]
    return [each.name for each in fields(base)] if is_dataclass(base) else []


def _row(each: Field[Any], table: type, path: str) -> str:
    """Return the row of a figure, or of a table with the figures in it if it is small."""
    kind = kinds_of(table)[each.name]
    inner = inner_kind(kind)
    name, meaning = _named(each, kind, path)
    if is_table(inner) and _is_small(inner):
        within = f"{path}.*" if inner is not kind else path
        figures = (_named(one, kinds_of(inner)[one.name], f"{within}.{one.name}") for one in fields(inner))
        meaning += f". {'; '.join(' '.join(filter(None, figure)) for figure in figures)}"
    return f"|{name} |{meaning}|"


def _named(each: Field[Any], kind: Any, path: str) -> tuple[str, str]:
    """Return the name of a figure or a table, and its meaning."""
    record = record_of(each)
    meaning = "" if record.words.replace(" ", "_") == each.name else record.words
    meaning += f"{': ' * bool(meaning)}{record.about}" if record.about else ""
    figure = figure_at(path)
    if is_table(inner_kind(kind)) or figure is None or inner_kind(kind) in (str, bool):
        return f"`{each.name}`", meaning
    known = [f"`{name}`" for name, short in SHORT_NAMES.items() if short.figure.path == figure.path]
    known += [f"{record.resolution:g}"] if record.resolution is not None else []
    known = [f"({', '.join(known)})"] if known else []
    return f"`{each.name}`{'†' * figure.is_extensive}", " ".join(filter(None, [meaning, *known]))


def _is_small(table: type) -> bool:
    """Return whether the figures of a table stand in the row of the table around it."""
    kinds = kinds_of(table).values()
    return len(kinds) <= SMALL and not any(is_table(inner_kind(kind)) for kind in kinds)


if __name__ == "__main__":
    file = Path(sys.argv[1])
    file.write_text(results_reference(file.read_text(encoding="utf-8")), encoding="utf-8")
