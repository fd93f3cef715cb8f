"""Error against cost of flipflow and of the ways of others: the table measured/ways_of_others.csv."""

import csv
from pathlib import Path

from drawing import DARK, FRAMES, PANELS, PARTICLES, plots

TABLE = Path(__file__).parents[1] / "measured" / "ways_of_others.csv"
COLORS = {"flipflow": PANELS, "conventional order": PARTICLES, "the paper's way": FRAMES, "Kratos": DARK}
LEAST = 1e-5  # smaller errors are drawn here


def draw() -> None:
    with TABLE.open(encoding="utf-8", newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["way"] in COLORS]
    scenes = list(dict.fromkeys(row["scene"] for row in rows))
    parts = plots(len(scenes), 9.0, 3.6)
    for axes, scene in zip(parts, scenes, strict=True):
        for row in (row for row in rows if row["scene"] == scene):
            color = COLORS[row["way"]]
            is_model = row["error_of"] != "numerics"
            place = float(row["processor_s_per_s"]), max(float(row["error"] or 1.0), LEAST)
            if row["status"] == "done":
                axes.plot(*place, "o", color=color, ms=6, mfc="white" if is_model else color)
            else:
                axes.plot(*place, "x" if row["error"] else "+", color=color, ms=8, mew=2)
        axes.set(xscale="log", yscale="log", ylim=(LEAST / 2, 2), title=scene)
        axes.set(xlabel="processor seconds for each simulated second", ylabel="error of the deflection")
        axes.grid(alpha=0.3)
    for way, color in COLORS.items():
        parts[0].plot([], [], "o", color=color, label=way)
    for mark, words in (("o", "other model or mesh"), ("x", "doubtful"), ("+", "stopped")):
        parts[0].plot([], [], mark, color="#888888", mfc="white", mew=1 if mark == "o" else 2, label=words)
    parts[0].figure.legend(loc="outside lower center", ncols=7, fontsize=7.5)
