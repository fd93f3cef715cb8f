"""What a sweep found: ``sweep.csv`` with a row for each point, and ``sweep.png``."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path

import matplotlib

from orchestrator.studies.points import Vary
from orchestrator.studies.steady import NotSteady, Steady, steady
from orchestrator.studies.sweep import Point

matplotlib.use("Agg")
import matplotlib.pyplot as plt

AXES = {0: "x", 2: "z"}
Row = dict[str, str | float]


def rows(vary: Vary, points: Sequence[Point]) -> list[Row]:
    """Per point: the value, how the run ended, and amplitudes along (x) and normal to the deck (z)
    of every frame, every probe on a frame, and of the frames against each other."""
    found = []
    for point in points:
        row: Row = {vary.name: point.value, "status": point.status()}
        if row["status"] == "done":
            try:
                row |= _figures(steady(point.folder))
            except NotSteady as short:
                row["status"] = f"done, but {short}"
        found.append(row)
    return found


def _figures(motion: Steady) -> Row:
    figures: Row = {"speed_rad_s": motion.speed_rad_s, "drift": motion.drift}
    for name, amplitude in (motion.points | motion.relative).items():
        figures |= {f"{name}.{letter}_m": abs(amplitude[axis]) for axis, letter in AXES.items()}
    return figures


def write(table: Sequence[Row], vary: Vary, folder: Path) -> list[Path]:
    """Both files; the picture only where values are numbers and two or more were run."""
    columns = list(dict.fromkeys(name for row in table for name in row))
    file = folder / "sweep.csv"
    with file.open("w", newline="", encoding="utf-8") as text:
        writer = csv.DictWriter(text, columns)
        writer.writeheader()
        writer.writerows(table)
    done = [row for row in table if row["status"] == "done"]
    try:
        values = [float(row[vary.name]) for row in done]
    except ValueError:
        return [file]
    if len(values) < 2:
        return [file]
    return [file, _plot(done, values, vary, folder / "sweep.png")]


def _plot(done: Sequence[Row], values: Sequence[float], vary: Vary, path: Path) -> Path:
    figure, axes = plt.subplots(1, 2, figsize=(11, 4.5), layout="constrained", sharex=True)
    for axis, (letter, where) in zip(axes, (("x", "along"), ("z", "normal to")), strict=True):
        for name in (name for name in done[0] if name.endswith(f".{letter}_m")):
            heights = [1e3 * float(row[name]) for row in done]
            axis.plot(values, heights, "o-", ms=3, lw=1, label=name.removesuffix(f".{letter}_m"))
        axis.set_title(f"{where} the deck", loc="left")
        axis.set(xlabel=vary.key, ylabel="amplitude / mm", ylim=(0, None))
        axis.grid(alpha=0.3)
        axis.legend(fontsize=8)
    figure.savefig(path, dpi=110)
    plt.close(figure)
    return path
