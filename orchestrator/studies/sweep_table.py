"""What a sweep found: ``sweep.csv`` with a row for each point, and ``sweep.png``."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import matplotlib

from orchestrator.output.records import trust
from orchestrator.output.results.harmonics import find_orbits, why_no_orbits
from orchestrator.output.results.machine import LARGEST_DRIFT
from orchestrator.output.results.run_reader import RunReader
from orchestrator.studies.points import Vary
from orchestrator.studies.sweep import Point

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.axes import Axes

AXES = {0: "x", 2: "z"}
SETTLED, NOT_SETTLED = "yes", "no"
DRAWN = {
    "screening.efficiency_percent": ("screening efficiency / %", 1.0),
    "bed.velocity_m_per_s": ("material velocity / (m/s)", 1.0),
    "bed.largest_depth_m": ("largest bed depth / mm", 1e3),
    "bed.on_deck_kg": ("mass on the deck / kg", 1.0),
}
"""Results that are drawn beside the amplitudes, where a sweep has them: label and scale."""
LOOKS: dict[str, dict[str, Any]] = {
    "good": {"marker": "o", "ms": 4},
    "open": {"marker": "o", "ms": 5, "mfc": "white"},
    "cross": {"marker": "x", "ms": 6},
}

Row = dict[str, str | float]


def rows(vary: Vary, points: Sequence[Point]) -> list[Row]:
    """Returns a row for each point.

    Its columns are the swept key as it is written after ``--vary``; ``status``, how the run ended;
    ``settled``, whether its motion had; ``drift`` and the amplitudes of the first harmonic along (x)
    and normal to the deck (z), with their half widths, of every frame, every probe on a frame, and of
    the frames against each other, all as in the run's results; and every single number of the
    results, with the half width of its interval.
    """
    return [_row(vary, point) for point in points]


def _row(vary: Vary, point: Point) -> Row:
    row: Row = {vary.key: point.value, "status": point.status()}
    return row | _measured(point)


def _measured(point: Point) -> Row:
    if not trust.came_to_its_end(point.status()):
        return {}
    run = RunReader(point.folder)
    return _motion(run) | dict(scalars(run.results))


def _motion(run: RunReader) -> Row:
    """Whether it had settled, and the amplitudes with their half widths."""
    orbits = find_orbits(run.results)
    if not orbits:
        return {"settled": f"unknown: {why_no_orbits(run.results)}"}
    motion = run.results["motion"]
    row: Row = {"settled": SETTLED if motion["is_settled"] else NOT_SETTLED}
    row["speed_rad_per_s"] = 2 * math.pi / run.summary["cycle_s"]
    if motion["drift"] is not None:
        row["drift"] = motion["drift"]
    for name, orbit in orbits.items():
        for axis, letter in AXES.items():
            row[f"{name}.{letter}_m"] = orbit["amplitude_m"][axis]
            if orbit["half_width_m"] is not None:
                row[f"{name}.{letter}_m.half_width"] = orbit["half_width_m"][axis]
    return row


def scalars(table: dict[str, Any], path: str = "") -> Iterator[tuple[str, float]]:
    """Yields every single number of a run's results by its keys with dots between.

    An estimate has its ``value`` under its own keys and its ``half_width``, where there is one,
    under one more; a vector has x, y and z, and a list of tables their ``exit`` or their numbers.
    Words, and what is known along the deck, by size or over time, are left out.
    """
    for key, value in table.items():
        where = f"{path}{key}"
        if isinstance(value, dict) and set(value) == {"value", "half_width", "batches"}:
            yield from _number(where, value["value"])
            yield from _number(f"{where}.half_width", value["half_width"])
        elif isinstance(value, dict):
            yield from scalars(value, f"{where}.")
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            for number, row in enumerate(value):
                yield from scalars(row, f"{where}.{row.get('exit', number)}.")
        elif isinstance(value, list) and len(value) == 3:
            for axis, component in zip("xyz", value, strict=True):
                yield from _number(f"{where}.{axis}", component)
        else:
            yield from _number(where, value)


def _number(where: str, value: Any) -> Iterator[tuple[str, float]]:
    if isinstance(value, int | float):
        yield where, value


def write(table: Sequence[Row], vary: Vary, folder: Path) -> list[Path]:
    """Writes both files and returns them; the picture only where values are numbers and two or
    more came to their end."""
    columns = list(dict.fromkeys(name for row in table for name in row))
    file = folder / "sweep.csv"
    with file.open("w", newline="", encoding="utf-8") as text:
        writer = csv.DictWriter(text, columns)
        writer.writeheader()
        writer.writerows(table)
    ended = [row for row in table if trust.came_to_its_end(str(row["status"]))]
    try:
        values = [float(row[vary.key]) for row in ended]
    except ValueError:
        return [file]
    drawn = _pictured(ended)
    if len(values) < 2 or not drawn:
        return [file]
    return [file, _plot(ended, values, drawn, vary, folder / "sweep.png")]


def _pictured(table: Sequence[Row]) -> list[tuple[str, list[tuple[str, str]], float]]:
    """What is drawn in each part of the picture: its label, the columns with their names, and the
    scale."""
    columns = list(dict.fromkeys(name for row in table for name in row if name.count(".") == 1))
    found: list[tuple[str, list[tuple[str, str]], float]] = []
    for letter, where in (("x", "along"), ("z", "normal to")):
        ending = f".{letter}_m"
        names = [(name, name.removesuffix(ending)) for name in columns if name.endswith(ending)]
        if names:
            found.append((f"amplitude {where} the deck / mm", names, 1e3))
    found += [(label, [(name, "")], scale) for name, (label, scale) in DRAWN.items() if name in columns]
    return found


def _plot(
    ended: Sequence[Row],
    values: Sequence[float],
    drawn: Sequence[tuple[str, list[tuple[str, str]], float]],
    vary: Vary,
    path: Path,
) -> Path:
    lines = -(-len(drawn) // 2)
    size = (11, 4.2 * lines + 0.5)
    figure, grid = plt.subplots(lines, 2, figsize=size, layout="constrained", squeeze=False)
    for axes, (label, names, scale) in zip(grid.flat, drawn, strict=False):
        for number, (column, name) in enumerate(names):
            _draw(axes, ended, values, column, name, scale, f"C{number}")
        axes.set(xlabel=vary.key, ylabel=label, ylim=(0, 1.05 * axes.get_ylim()[1]))
        axes.grid(alpha=0.3)
        if any(name for _, name in names):
            axes.legend(fontsize=8)
    for axes in grid.flat[len(drawn) :]:
        axes.axis("off")
    figure.suptitle(
        f"filled: settled; open: not settled (drift above {100 * LARGEST_DRIFT:g} %; no steady "
        "state of the bed) or unknown; cross: the run is not to be trusted, or incomplete",
        fontsize=9,
        x=0.01,
        ha="left",
    )
    figure.savefig(path, dpi=110)
    plt.close(figure)
    return path


def _draw(
    axes: Axes,
    ended: Sequence[Row],
    values: Sequence[float],
    column: str,
    name: str,
    scale: float,
    colour: str,
) -> None:
    """One column over the swept value, with intervals.  A line joins good points that are
    neighbours, and no others."""
    axes.plot([], [], "o-", ms=4, lw=1, color=colour, label=name)
    line: list[tuple[float, float]] = []
    for value, row in sorted(zip(values, ended, strict=True), key=lambda pair: pair[0]):
        if column not in row:
            continue
        height, width = (scale * float(row.get(key, 0.0)) for key in (column, f"{column}.half_width"))
        kind = _kind(row, column)
        line.append((value, height if kind == "good" else math.nan))
        axes.errorbar(value, height, width, color=colour, capsize=2, ls="", **LOOKS[kind])
    if line:
        axes.plot(*zip(*line, strict=True), lw=1, color=colour)


def _kind(row: Row, column: str) -> str:
    """How far a value may be taken as data: what is of the bed, by the steady state of the bed."""
    if not trust.is_trusted(str(row["status"])):
        return "cross"
    steady = row.get("steady.is_steady") if column in DRAWN else row["settled"] == SETTLED
    return "good" if steady else "open"
