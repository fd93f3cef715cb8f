"""The pictures of a study: error against cost, and error against what each knob turns."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
from matplotlib.ticker import FixedLocator, LogLocator, NullFormatter

from orchestrator.accuracy.families import Converged
from orchestrator.accuracy.knobs import KNOBS
from orchestrator.accuracy.measured import Error
from orchestrator.accuracy.points import BASE, KNOB, REFERENCE, TOGETHER
from orchestrator.accuracy.rows import RECOMMENDED, Row, pareto
from orchestrator.accuracy.study import Study
from orchestrator.report.drawing import LINES, figure
from orchestrator.studies.figures import QUANTITIES

LEAST = 1e-4  # errors below are drawn here
DEEP = 1e4  # what is so much smaller than the largest error is not shown
ABREAST = 2
MARKS = "os^vDPX<>"
WORDS = QUANTITIES | {"energy_defect": "energy created by the coupling"}


def work_precision(study: Study, table: Sequence[Row], path: Path) -> Path:
    """Error of every point against its processor time, with those that nothing beats."""
    drawn, axes = figure(width=9.6, height=5.6)
    axis = axes[0, 0]
    shown = [row for row in table if row.error is not None]
    front, titles = pareto(table), study.listed.offer.titles
    axis.plot(*_line(front), color="#888888", lw=1.2, zorder=1, label="nothing is better in both")
    for number, name in enumerate(study.listed.offer.axes):
        mine = [r for r in shown if r.point.kind == KNOB and name in r.point.settings]
        _scatter(
            axis,
            mine,
            MARKS[number % len(MARKS)],
            LINES[number % len(LINES)],
            f"{titles[name]} only",
        )
    together = [r for r in shown if r.point.kind in (TOGETHER, REFERENCE)]
    _scatter(axis, together, "*", "#111111", "several together")
    _scatter(axis, [r for r in shown if r.point.kind == BASE], "o", "#c1443c", "the case as it is")
    best = study.measured[study.reference]
    axis.axvline(best.processor_s, color="#444444", ls=":", lw=1)
    above = axis.get_xaxis_transform()
    note = {"rotation": 90, "ha": "right", "va": "top", "fontsize": 8.5, "color": "#444444"}
    axis.text(best.processor_s, 0.98, "the reference ", transform=above, **note)
    for tolerance in RECOMMENDED:
        axis.axhline(tolerance, color="#0f8a8a", lw=0.8, ls="--", zorder=0)
    _name(axis, front)
    axis.set(xscale="log", yscale="log", xlabel="processor time of one run / s")
    axis.set_ylabel("largest error of what decides, against the reference")
    _percents(axis)
    axis.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 3.0, 5.0)))
    axis.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
    axis.xaxis.set_minor_formatter(NullFormatter())
    axis.margins(x=0.12, y=0.12)
    axis.set_title(f"What accuracy costs: {study.listed.loaded.name}, down and left is better")
    axis.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), fontsize=8.5)
    drawn.savefig(path, dpi=120)
    plt.close(drawn)
    return path


def _line(rows: Sequence[Row]) -> tuple[list[float], list[float]]:
    pairs = [_place(row) for row in rows]
    return [x for x, _ in pairs], [y for _, y in pairs]


def _place(row: Row) -> tuple[float, float]:
    assert row.measured is not None
    assert row.error is not None
    return row.measured.processor_s, max(row.error.value, LEAST)


def _scatter(axis: Any, rows: Sequence[Row], mark: str, colour: str, label: str) -> None:
    """With confidence intervals, where there are any."""
    if not rows:
        return
    x, y = _line(rows)
    size = 90 if mark == "*" else 34
    axis.scatter(x, y, marker=mark, s=size, color=colour, label=label, zorder=3)
    wide = [_width(row.error) for row in rows]
    below = [min(w, max(height - LEAST, 0.0)) for w, height in zip(wide, y, strict=True)]
    axis.errorbar(x, y, yerr=[below, wide], fmt="none", ecolor=colour, alpha=0.35, lw=1, zorder=2)


def _width(error: Error | None) -> float:
    return (error.half_width or 0.0) if error else 0.0


def _name(axis: Any, rows: Sequence[Row]) -> None:
    """Numbers, which the page's table explains."""
    for number, row in enumerate(rows, 1):
        axis.annotate(
            str(number), _place(row), (6, 5), textcoords="offset points", fontsize=9, weight="bold"
        )


def _percents(axis: Any) -> None:
    axis.yaxis.set_major_formatter(lambda value, _: f"{100 * value:g} %")


def convergence(families: Sequence[Converged], judged_by: Sequence[str], path: Path) -> Path | None:
    """Error of each quantity against what the families of one axis turn, side by side; None where
    nothing converges."""
    shown = [one for one in families if len(one.found) > 1 and one.found[0][0].h is not None]
    if not shown:
        return None
    rows, columns = -(-len(shown) // ABREAST), min(len(shown), ABREAST)
    drawn, grid = figure(rows, columns, 5.2 * columns, 4.2 * rows)
    axes = list(grid.flat)
    every = [_drawn(axis, one, judged_by) for axis, one in zip(axes, shown, strict=False)]
    heights = [height for one in every for height in one]
    for axis in axes[len(shown) :]:
        axis.axis("off")
    if not heights:
        plt.close(drawn)
        return None
    for axis in axes:
        axis.set_ylim(max(min(heights), max(heights) / DEEP) / 2, 3 * max(heights))
        axis.set_ylabel("error")
    drawn.savefig(path, dpi=110)
    plt.close(drawn)
    return path


def _drawn(axis: Any, one: Converged, judged_by: Sequence[str]) -> list[float]:
    """One family; the heights of its points."""
    heights: list[float] = []
    lengths = [setting.h or 0.0 for setting, _ in one.found]
    names = [*judged_by, "shape", *one.exact[0]]
    for number, name in enumerate(names):
        exact = name in one.exact[0]
        every = [each.get(name) for each in (one.exact if exact else one.errors)]
        sizes = [e.value if isinstance(e, Error) else e for e in every]
        at = [i for i, e in enumerate(sizes) if e and (exact or i < len(sizes) - 1)]
        if not at:
            continue
        heights += [float(sizes[i] or 0.0) for i in at]
        order = one.orders.get(name)
        seen = f", order {order.order:.1f}" + ("" if order.clean else "?") if order else ""
        label = WORDS.get(name, name).split(" / ")[0] + seen
        x, y = [lengths[i] for i in at], [sizes[i] for i in at]
        style = "--" if exact else "-"
        axis.plot(x, y, style, marker=MARKS[number % len(MARKS)], ms=5, label=label)
    if heights and one.family.expected:
        top = max(heights)
        y = [1.5 * top * (h / max(lengths)) ** one.family.expected for h in lengths]
        label = f"expected order {one.family.expected:g}"
        axis.plot(lengths, y, color="#999999", lw=3, alpha=0.5, label=label)
    axis.set(xscale="log", yscale="log", xlabel=one.family.length)
    axis.set_title(one.family.variant or KNOBS[one.family.knob].title)
    axis.xaxis.set_major_locator(FixedLocator(lengths))
    axis.xaxis.set_major_formatter(lambda value, _: f"{value:.3g}")
    axis.xaxis.set_minor_formatter(NullFormatter())
    axis.tick_params(axis="x", rotation=30)
    _percents(axis)
    axis.legend(fontsize=7.5)
    return heights
