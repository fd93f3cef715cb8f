"""Tables of the confusion, for the terminal, for other programs and for the manual."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator
from pathlib import Path

from rich.table import Table

from orchestrator.case.file.whole import write_text
from orchestrator.preflight.judgement.pair import Change
from tools.effect_bank.confusion import MAY_GO, MOST_FALSE_ALARMS, OUTCOMES, PREDICTIONS, Confusion, Row

HEAD = ("scene", "effect", "number", "value", "threshold", "verdict", "outcome", "changes")
CSV_HEAD = (
    "scene",
    "effect",
    "number",
    "value",
    "threshold",
    "verdict",
    "outcome",
    "remark",
    "result",
    "with",
    "without",
    "change",
    "half_width",
)
DIGITS = 3


def confusion_table(confusion: Confusion) -> Table:
    """Return the confusion table for the terminal, with verdicts down and outcomes across."""
    printed = Table(title="verdict before the run, against runs with and without the effect")
    printed.add_column("explain says")
    for outcome in OUTCOMES:
        printed.add_column(outcome, justify="right")
    for predicted in PREDICTIONS:
        counts = (str(confusion.count(predicted, outcome)) for outcome in OUTCOMES)
        printed.add_row(predicted, *counts)
    return printed


def lines(confusion: Confusion) -> Iterator[str]:
    """Yield the conclusions from the table as lines for the terminal."""
    false_percent, goal_percent = 100 * confusion.false_alarms, 100 * MOST_FALSE_ALARMS
    yield (
        f'wrong "{MAY_GO}": {len(confusion.wrong_rows)}; false alarms: {false_percent:.0f} % of '
        f'"matters" (the goal is below {goal_percent:.0f} %)'
    )
    for row in confusion.wrong_rows:
        yield f"wrong: {row.scene}: {row.effect} {_number(row)}: {changes_in_words(row)}"
    for row in confusion.rows:
        if row.is_false_alarm:
            yield f"false alarm: {row.scene}: {row.effect} {_number(row)}: {changes_in_words(row)}"
    if confusion.missing_runs:
        yield f"{confusion.missing_runs} comparisons lack a run"


def write(confusion: Confusion, folder: Path) -> list[Path]:
    """Write ``effects.csv``, with a row for each effect and result, and ``effects.md``; return both."""
    file = folder / "effects.csv"
    with file.open("w", newline="", encoding="utf-8") as text:
        writer = csv.writer(text)
        writer.writerow(CSV_HEAD)
        for row in confusion.rows:
            writer.writerows(_csv_rows(row))
    write_text(folder / "effects.md", markdown(confusion))
    return [file, folder / "effects.md"]


def markdown(confusion: Confusion) -> str:
    """Return the confusion table and the table of all rows, as Markdown."""
    head = ["explain says", *OUTCOMES]
    table = [
        [predicted, *(str(confusion.count(predicted, outcome)) for outcome in OUTCOMES)]
        for predicted in PREDICTIONS
    ]
    rows = [_row_in_words(row) for row in confusion.rows]
    return "\n".join([*_table(head, table), "", *_table(list(HEAD), rows)]) + "\n"


def changes_in_words(row: Row) -> str:
    """Return every requested result with and without the effect, and its change, in words."""
    changes = [
        f"{name} {_short(one.with_it)} → {_short(one.without)}{_percent(one)}"
        for name, one in row.changes.items()
    ]
    return "; ".join(filter(None, [", ".join(changes), row.remark]))


def _table(head: list[str], rows: list[list[str]]) -> Iterator[str]:
    yield f"| {' | '.join(head)} |"
    yield f"|{'---|' * len(head)}"
    for row in rows:
        yield f"| {' | '.join(row)} |"


def _row_in_words(row: Row) -> list[str]:
    verdict, mark = row.verdict, ""
    if row.is_wrong:
        mark = " **WRONG**"
    elif row.is_false_alarm:
        mark = " (false alarm)"
    numbers = ["", "-", ""]
    if verdict is not None:
        numbers = [verdict.number, verdict.value_in_words, verdict.threshold]
    cells = [row.scene, row.effect, *numbers, row.predicted + mark, row.outcome]
    return [cell.replace("|", "\\|") for cell in [*cells, changes_in_words(row)]]


def _csv_rows(row: Row) -> Iterator[tuple[object, ...]]:
    verdict = row.verdict
    numbers: tuple[object, ...] = ("", "", "")
    if verdict is not None:
        numbers = (verdict.number, "" if verdict.value is None else verdict.value)
        numbers = (*numbers, verdict.threshold)
    shared = (row.scene, row.effect, *numbers, row.predicted, row.outcome, row.remark)
    if not row.changes:
        yield (*shared, "", "", "", "", "")
    for name, one in row.changes.items():
        values = (one.with_it, one.without, one.relative, one.uncertain)
        yield (*shared, name, *("" if value is None else value for value in values))


def _number(row: Row) -> str:
    return "" if row.verdict is None else f"({row.verdict.in_numbers})"


def _short(value: float | None) -> str:
    return "none" if value is None else f"{value:.{DIGITS}g}"


def _percent(one: Change) -> str:
    if one.relative is None:
        return " (too small)" if one.with_it is not None else ""
    if math.isinf(one.relative):
        return ""
    percent = 100 * one.relative
    width = "" if one.uncertain is None else f" ± {100 * one.uncertain:.0f}"
    return f" ({percent:.0f}{width} %)" if percent >= 10 else f" ({percent:.2g}{width} %)"
