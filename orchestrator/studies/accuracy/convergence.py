"""Error against what a knob turns: the order that was observed beside the expected one."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
from matplotlib.ticker import FixedLocator, NullFormatter

from orchestrator.output.report.drawing import figure
from orchestrator.studies.accuracy.families import Converged
from orchestrator.studies.accuracy.knobs import KNOBS
from orchestrator.studies.accuracy.order import Order
from orchestrator.studies.figures import QUANTITIES

DEEP = 1e4  # what is so much smaller than the largest error is not shown
ABREAST = 2
MARKS = "os^vDPX<>"
WORDS = QUANTITIES | {"energy_defect": "energy created by the coupling"}


def convergence(families: Sequence[Converged], judged_by: Sequence[str], path: Path) -> Path | None:
    """Of the families of one axis; None where nothing converges."""
    shown = [one for one in families if len(one.found) > 1 and one.found[0][0].h is not None]
    every = [_lines(one, judged_by) for one in shown]
    heights = [y for lines in every for _, _, line_y, _ in lines for y in line_y]
    if not heights:
        return None
    rows, columns = -(-len(shown) // ABREAST), min(len(shown), ABREAST)
    drawn, grid = figure(rows, columns, 5.2 * columns, 4.2 * rows)
    for axis in list(grid.flat)[len(shown) :]:
        axis.axis("off")
    lowest = max(min(heights), max(heights) / DEEP) / 2
    for axis, one, lines in zip(grid.flat, shown, every, strict=False):
        _draw(axis, one, lines)
        axis.set_ylim(lowest, 3 * max(heights))
    drawn.savefig(path, dpi=110)
    plt.close(drawn)
    return path


Line = tuple[str, list[float], list[float], str]


def _lines(one: Converged, judged_by: Sequence[str]) -> list[Line]:
    """Label, h, error and style of each quantity: against the finest setting, or dashed, against
    what is known exactly."""
    lengths = [setting.h or 0.0 for setting, _ in one.found]
    found: list[Line] = []
    for name in (*judged_by, "shape"):
        sizes = [each[name].value if name in each else 0.0 for each in one.errors[:-1]]
        found.append((_label(name, one.orders.get(name)), lengths[:-1], sizes, "-"))
    for name in one.exact[0]:
        sizes = [each.get(name, 0.0) for each in one.exact]
        found.append((_label(name, one.orders.get(name)), lengths, sizes, "--"))
    return [
        (label, [x for x, y in zip(h, sizes, strict=True) if y], [y for y in sizes if y], style)
        for label, h, sizes, style in found
        if any(sizes)
    ]


def _label(name: str, order: Order | None) -> str:
    seen = f", order {order.order:.1f}{'' if order.clean else '?'}" if order else ""
    return WORDS.get(name, name).split(" / ")[0] + seen


def _draw(axis: Any, one: Converged, lines: Sequence[Line]) -> None:
    for (label, x, y, style), mark in zip(lines, MARKS, strict=False):
        axis.plot(x, y, style, marker=mark, ms=5, label=label)
    lengths = [setting.h or 0.0 for setting, _ in one.found]
    if lines and one.family.expected:
        top = 1.5 * max(y for _, _, line_y, _ in lines for y in line_y)
        expected = [top * (h / max(lengths)) ** one.family.expected for h in lengths]
        label = f"expected order {one.family.expected:g}"
        axis.plot(lengths, expected, color="#999999", lw=3, alpha=0.5, label=label)
    axis.set(xscale="log", yscale="log", xlabel=one.family.length, ylabel="error")
    axis.set_title(one.family.variant or KNOBS[one.family.knob].title)
    axis.xaxis.set_major_locator(FixedLocator(lengths))
    axis.xaxis.set_major_formatter(lambda value, _: f"{value:.3g}")
    axis.xaxis.set_minor_formatter(NullFormatter())
    axis.yaxis.set_major_formatter(lambda value, _: f"{100 * value:g} %")
    axis.tick_params(axis="x", rotation=30)
    if lines:
        axis.legend(fontsize=7.5)
