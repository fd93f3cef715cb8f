"""Error against cost, one picture for each quantity, and a page that holds them all."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
from matplotlib.ticker import LogLocator, NullFormatter

from orchestrator.output.records.run_folder import write_text
from orchestrator.output.report.drawing import LINES, data_uri, figure
from orchestrator.output.report.filled import fill_template
from orchestrator.studies.figures import QUANTITIES
from orchestrator.studies.ladder.rungs import LADDERS
from orchestrator.studies.ladder.tables import SHORT, Row, percent

LEAST = 1e-4  # errors below are drawn here
NONE = 1e-9  # what all rungs do alike is not drawn
MARKS = dict(zip(LADDERS, "os^", strict=True))
COLOURS = dict(zip(LADDERS, LINES, strict=False))


def draw(table: Sequence[Row], folder: Path) -> dict[str, Path]:
    """``ladder-<quantity>.png`` for every quantity with an error, by quantity."""
    found = {}
    for name in QUANTITIES:
        drawn = _drawn(name, [row for row in table if name in row.error])
        if drawn is not None:
            found[name] = folder / f"ladder-{name}.png"
            drawn.savefig(found[name], dpi=110)
            plt.close(drawn)
    return found


def _drawn(name: str, shown: Sequence[Row]) -> Any:
    if not any(row.error[name] > NONE for row in shown):
        return None
    drawn, axes = figure(width=7.0, height=4.6)
    axis = axes[0, 0]
    for ladder in LADDERS:
        mine = [row for row in shown if row.step.rung.ladder == ladder]
        if mine:
            label = f"{ladder}, against {mine[0].reference}"
            points = list(_points(name, mine))
            axis.scatter(*zip(*points, strict=True), marker=MARKS[ladder], s=42, label=label)
            axis.collections[-1].set_color(COLOURS[ladder])
            for row, (x, y) in zip(mine, points, strict=True):
                axis.annotate(
                    row.step.rung.name,
                    (x, y),
                    xytext=(7, 4),
                    textcoords="offset points",
                    fontsize=9,
                    color=COLOURS[ladder],
                )
    axis.set(xscale="log", yscale="log", xlabel="processor time of the run / s")
    axis.set_ylabel("error against the highest rung that was run")
    axis.set_title(QUANTITIES[name].split(" / ")[0])
    axis.yaxis.set_major_formatter(lambda value, _: f"{100 * value:g} %")
    axis.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 3.0, 5.0)))
    axis.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
    axis.xaxis.set_minor_formatter(NullFormatter())
    axis.margins(x=0.25, y=0.15)
    axis.grid(which="minor", alpha=0.12)
    axis.legend(loc="best", fontsize=8.5)
    return drawn


def _known(name: str, table: Sequence[Row]) -> bool:
    return any(name in row.error or (row.figures and name in row.figures.values) for row in table)


def _points(name: str, rows: Sequence[Row]) -> Iterator[tuple[float, float]]:
    for row in rows:
        if row.figures is not None:
            yield row.figures.processor_s, max(row.error[name], LEAST)


def page(title: str, table: Sequence[Row], pictures: dict[str, Path], folder: Path) -> Path:
    """``ladder.html``: everything in itself."""
    ladders = {name: [row for row in table if row.step.rung.ladder == name] for name in LADDERS}
    text = fill_template(
        "studies/ladder/page.html",
        title=title,
        ladders={name: rows for name, rows in ladders.items() if rows},
        quantities={name: text for name, text in QUANTITIES.items() if _known(name, table)},
        short=SHORT,
        percent=percent,
        pictures={name: data_uri(file.read_bytes(), "image/png") for name, file in pictures.items()},
    )
    write_text(folder / "ladder.html", text)
    return folder / "ladder.html"
