"""Error of every point of a study against its cost."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
from matplotlib.ticker import LogLocator, NullFormatter

from orchestrator.output.report.drawing import LINES, figure
from orchestrator.studies.accuracy.measured import Error
from orchestrator.studies.accuracy.points import BASE, KNOB, REFERENCE, TOGETHER
from orchestrator.studies.accuracy.rows import RECOMMENDED, Row, pareto
from orchestrator.studies.accuracy.study import Study

LEAST = 1e-4  # errors below are drawn here
MARKS = "os^vDPX<>"
RED, BLACK, GREY, GREEN = "#c1443c", "#111111", "#888888", "#0f8a8a"
BESIDE = {"loc": "upper left", "bbox_to_anchor": (1.01, 1.0), "fontsize": 8.5}


def work_precision(study: Study, table: Sequence[Row], path: Path) -> Path:
    """All points, and a line through those that nothing beats."""
    drawn, axes = figure(width=9.6, height=5.6)
    axis = axes[0, 0]
    front = pareto(table)
    axis.plot(*_line(front), color=GREY, lw=1.2, zorder=1, label="nothing is better in both")
    for rows, mark, colour, label in _groups(study, table):
        _scatter(axis, rows, mark, colour, label)
    for number, row in enumerate(front, 1):
        near = {"textcoords": "offset points", "fontsize": 9, "weight": "bold"}
        axis.annotate(str(number), _place(row), (6, 5), **near)
    if any(_width(row.error) for row in table):
        axis.plot([], [], color=GREY, lw=0.9, label="where chance leaves it (95 %)")
    _guides(axis, study.measured[study.reference].processor_s)
    axis.set_title(f"What accuracy costs: {study.listed.loaded.name}, down and left is better")
    axis.legend(**BESIDE)
    drawn.savefig(path, dpi=120)
    plt.close(drawn)
    return path


def _groups(study: Study, table: Sequence[Row]) -> list[tuple[list[Row], str, str, str]]:
    """Rows with their mark, colour and name."""
    shown = [row for row in table if row.error is not None]
    found = []
    for number, (axis, title) in enumerate(study.listed.offer.titles.items()):
        mine = [r for r in shown if r.point.kind == KNOB and axis in r.point.settings]
        mark, colour = MARKS[number % len(MARKS)], LINES[number % len(LINES)]
        found.append((mine, mark, colour, f"{title} only"))
    together = [r for r in shown if r.point.kind in (TOGETHER, REFERENCE)]
    own = [r for r in shown if r.point.kind == BASE]
    return [*found, (together, "*", BLACK, "several together"), (own, "o", RED, "the case as it is")]


def _scatter(axis: Any, rows: Sequence[Row], mark: str, colour: str, label: str) -> None:
    if not rows:
        return
    x, y = _line(rows)
    size = 90 if mark == "*" else 34
    axis.scatter(x, y, marker=mark, s=size, color=colour, label=label, zorder=3)
    ends = [(y - _width(row.error), y + _width(row.error)) for y, row in zip(y, rows, strict=True)]
    low, high = ([max(end, LEAST) for end in each] for each in zip(*ends, strict=True))
    axis.vlines(x, low, high, color=colour, lw=0.9, alpha=0.6, zorder=2)


def _guides(axis: Any, reference_s: float) -> None:
    """Axes, tolerances, and where the reference is."""
    axis.set(xscale="log", yscale="log", xlabel="processor time of one run / s")
    axis.set_ylabel("largest error of what decides, against the reference")
    axis.axvline(reference_s, color=GREY, ls=":", lw=1)
    note = {"rotation": 90, "ha": "right", "va": "top", "fontsize": 8.5, "color": GREY}
    axis.text(reference_s, 0.98, "the reference ", transform=axis.get_xaxis_transform(), **note)
    for tolerance in RECOMMENDED:
        axis.axhline(tolerance, color=GREEN, lw=0.8, ls="--", zorder=0)
    axis.set_ylim(bottom=LEAST / 2 if axis.get_ylim()[0] < LEAST else None)
    axis.yaxis.set_major_formatter(lambda value, _: f"{100 * value:g} %")
    axis.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 3.0, 5.0)))
    axis.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
    axis.xaxis.set_minor_formatter(NullFormatter())
    axis.margins(x=0.12, y=0.12)


def _line(rows: Sequence[Row]) -> tuple[list[float], list[float]]:
    pairs = [_place(row) for row in rows]
    return [x for x, _ in pairs], [y for _, y in pairs]


def _place(row: Row) -> tuple[float, float]:
    assert row.measured is not None
    assert row.error is not None
    return row.measured.processor_s, max(row.error.value, LEAST)


def _width(error: Error | None) -> float:
    return (error.half_width or 0.0) if error else 0.0
