"""Predicted over measured processor time of the runs in measured/cost.csv."""

import csv
from pathlib import Path

from drawing import DARK, PANELS, plots

TABLE = Path(__file__).parents[1] / "measured" / "cost.csv"


def draw() -> None:
    with TABLE.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    names, ratios = [row["run"] for row in rows], [float(row["ratio"]) for row in rows]
    axes = plots(1, 7.5, 0.6 + 0.2 * len(names))
    place = range(len(names), 0, -1)
    axes.barh(place, ratios, color=PANELS, alpha=0.6)
    axes.axvline(1, color=DARK, lw=1)
    axes.set_yticks(list(place), names, fontsize=8)
    axes.set(xlabel="predicted over measured processor time", xlim=(0, 1.6))
