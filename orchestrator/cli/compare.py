"""The output of ``flipflow compare``: what differs between runs, in tables, as JSON, and on a page."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from orchestrator.cli.console import CONSOLE, ERRORS, UNLIMITED, reported_errors
from orchestrator.cli.json_forms import print_json
from orchestrator.output.report.comparison import change, interval, write_comparison
from orchestrator.output.results.comparison import MORE, Comparison, compare
from orchestrator.output.tables import console_table


def print_comparison(folders: Sequence[Path], out: Path | None, as_json: bool) -> None:
    """Compare runs with the first of them, print the comparison, and write its page to the file ``out``."""
    with reported_errors():
        comparison = compare(folders)
        if out is not None:
            write_comparison(comparison, out)
    for line in comparison.doubts:
        ERRORS.print(f"warning: {line}")
    if as_json:
        print_json(comparison.as_json())
        return
    if not CONSOLE.is_terminal:
        CONSOLE.width = UNLIMITED
    _print_tables(comparison)
    if out is not None:
        CONSOLE.print(f"written: {out}")


def _print_tables(comparison: Comparison) -> None:
    """Print the differing keys, and the results that have a short name or differ by more than chance."""
    names = comparison.names
    if comparison.keys:
        keys = ([row.key, *row.values] for row in comparison.keys)
        CONSOLE.print(console_table("cases", ["key", *names], keys, left=names), soft_wrap=False)
    else:
        CONSOLE.print("the cases are the same")
    for number, name in enumerate(names[1:], start=1):
        head = ["result", "unit", names[0], name, "change", "verdict"]
        lines = [*_result_lines(comparison, number)]
        title = f"{name} against {names[0]}"
        CONSOLE.print(console_table(title, head, lines, left=("unit", "verdict")), soft_wrap=False)
    CONSOLE.print(
        f"{comparison.more_than_chance} of {comparison.compared} comparisons with intervals differ by more "
        f"than chance; chance alone would give about {0.05 * comparison.compared:.1f}"
    )


def _result_lines(comparison: Comparison, number: int) -> Iterator[list[str]]:
    """Yield the cells of the results in which run ``number`` is compared with the first run."""
    for row in comparison.results:
        verdict = row.verdicts[number]
        if verdict is not None and (row.is_short or (verdict == MORE and row in comparison.distinct)):
            first, other = (interval(row.results[run]) for run in (0, number))
            yield [row.name, row.unit, first, other, change(row.changes()[number]), verdict]
