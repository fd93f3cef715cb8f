"""What ``flipflow explain`` prints: a table of effects, and what follows from it."""

from __future__ import annotations

import math
from collections.abc import Iterator

from rich import box
from rich.console import Console
from rich.table import Table

from orchestrator.casefile.levels import LoadedCase
from orchestrator.scene.catalogue import Judged, judged
from orchestrator.scene.effect import Part

NARROW = 130  # too narrow for all columns
WIDTH = 196  # of the table where no terminal sets one
NOTHING_BUT_ROUNDING = 1e-9
COLUMNS = ("effect", "here", "number", "value", "threshold", "verdict", "change / cost")
SHORT = ("effect", "here", "value")
NOTHING = {
    "particles": "no particles: nothing to decide",
    "panels": "no panels: nothing to decide",
    "frames": "no frames but the ground: nothing to decide",
}


def show(loaded: LoadedCase) -> None:
    """Prints everything about a case without mistakes in its tables."""
    console = Console(highlight=False, markup=False)
    if not console.is_terminal:
        console.width = WIDTH
    parts = judged(loaded.case)
    level = f"level {loaded.level}" if loaded.level else "no level"
    console.print(f"{loaded.name}, {level}: {loaded.case.title}", soft_wrap=True)
    narrow = console.width < NARROW
    console.print(table(parts, COLUMNS[:-1] if narrow else COLUMNS))
    if narrow:
        console.print(f"(in {NARROW} columns, or in a file, also keys and costs)", soft_wrap=True)
    for line in summary(loaded, [verdict for rows in parts.values() for verdict in rows]):
        console.print(line, soft_wrap=True)


def table(parts: dict[Part, list[Judged]], columns: tuple[str, ...]) -> Table:
    """One row for each effect, part by part."""
    found = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for column in columns:
        found.add_column(column, no_wrap=column in SHORT, overflow="fold")
    for part, verdicts in parts.items():
        found.add_row(f"[{part}]", *[""] * 4, "" if verdicts else NOTHING.get(part, ""))
        for one in verdicts:
            found.add_row(*_row(one)[: len(columns)])
        found.add_section()
    return found


def _row(one: Judged) -> tuple[str, ...]:
    verdict = one.verdict
    return (
        one.effect,
        "yes" if one.present else "no",
        verdict.number,
        _shown(verdict.value),
        verdict.threshold,
        f"{in_words(verdict.matters)}: {verdict.why}",
        "\n".join(text for text in (one.key, verdict.cost) if text),
    )


def in_words(matters: bool | None) -> str:
    """ "matters", "may be left out" or "cannot say"."""
    if matters is None:
        return "cannot say"
    return "matters" if matters else "may be left out"


def _shown(value: float | None) -> str:
    if value is None:
        return "-"
    if math.isinf(value):
        return "infinite"
    return "0" if abs(value) < NOTHING_BUT_ROUNDING else f"{value:.3g}"


def summary(loaded: LoadedCase, verdicts: list[Judged]) -> Iterator[str]:
    """What the case lacks, and what it could do without."""
    lacking = [one for one in verdicts if one.lacking]
    spare = [one for one in verdicts if one.spare]
    yield (
        "matters, and the case does not have it:" if lacking else "nothing that matters is lacking"
    )
    yield from (f"  {one.effect}: {one.verdict.why}; {one.key}" for one in lacking)
    yield "may be left out, and the case has it:" if spare else "nothing could be left out"
    yield from (
        f"  {one.effect}: {one.verdict.why}; {one.key}; it costs {one.verdict.cost}"
        for one in spare
    )
    yield "formulas, sources, and how crude each estimate is: docs/theory/effects.md"
