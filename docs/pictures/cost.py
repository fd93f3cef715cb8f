"""Predicted over measured processor time of the runs in measured/cost.md."""

from pathlib import Path

from drawing import DARK, PANELS, plots

PAGE = Path(__file__).parents[1] / "measured" / "cost.md"


def draw() -> None:
    names, ratios = [], []
    for row in PAGE.read_text(encoding="utf-8").splitlines():
        cells = [cell.strip() for cell in row.strip("|").split("|")]
        if row.startswith("|") and len(cells) == 4 and cells[3].replace(".", "").isdigit():
            names.append(cells[0])
            ratios.append(float(cells[3]))
    axes = plots(1, 7.5, 0.6 + 0.2 * len(names))
    place = range(len(names), 0, -1)
    axes.barh(place, ratios, color=PANELS, alpha=0.6)
    axes.axvline(1, color=DARK, lw=1)
    axes.set_yticks(list(place), names, fontsize=8)
    axes.set(xlabel="predicted over measured processor time", xlim=(0, 1.6))
