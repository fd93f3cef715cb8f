"""The stability map as a picture, and the page with it and all hard cases."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
from matplotlib.lines import Line2D

from orchestrator.output.records.run_folder import write_text
from orchestrator.output.report.drawing import data_uri, figure
from orchestrator.output.report.filled import filled
from orchestrator.studies.hard.stability_map import HEAD as MAP_HEAD
from orchestrator.studies.hard.stability_map import Spot
from orchestrator.studies.hard.verdicts import HEAD, Line

# outcome: colour, mark, what it says; told apart by shape, too
SHOWN = {
    "stable": ("#2b7a4b", "o", "stable"),
    "warned": ("#d08a00", "^", "warned: over 1 % of the energy made or lost, or a mode that grows"),
    "stopped": ("#b3261e", "X", "stopped, with a reason"),
    "not run": ("#9aa4b0", "_", "not run"),
}


def draw(spots: Sequence[Spot], file: Path) -> Path:
    """A panel for each scheme: sync interval across, mass of the bed upwards."""
    schemes = list(dict.fromkeys(spot.scheme for spot in spots))
    columns = min(3, len(schemes))
    rows = -(-len(schemes) // columns)
    drawn, grid = figure(rows, columns, 3.6 * columns + 0.4, 3.0 * rows + 0.6)
    for axis in grid.ravel()[len(schemes) :]:
        axis.set_visible(False)
    for axis, scheme in zip(grid.ravel(), schemes, strict=False):
        _one(axis, scheme, [spot for spot in spots if spot.scheme == scheme])
    handles = [
        Line2D([], [], color=colour, marker=mark, ls="", ms=9, label=text)
        for name, (colour, mark, text) in SHOWN.items()
        if any(spot.outcome == name for spot in spots)
    ]
    drawn.legend(handles=handles, loc="outside upper center", ncols=len(handles))
    drawn.supxlabel("sync interval / largest safe one of the plain scheme", fontsize=10)
    drawn.supylabel("mass of the bed / of the panel", fontsize=10)
    drawn.savefig(file, dpi=110)
    plt.close(drawn)
    return file


def _one(axis: Any, scheme: str, spots: Sequence[Spot]) -> None:
    for name, (colour, mark, _) in SHOWN.items():
        at = [(s.multiple, s.mass_ratio) for s in spots if s.outcome == name]
        if at:
            axis.scatter(*zip(*at, strict=True), c=colour, marker=mark, s=95, zorder=3)
    axis.axvline(1.0, color="#24406e", lw=1.0, ls="--", zorder=1)
    axis.set(xscale="log", yscale="log")
    axis.set_title(scheme, loc="left", fontsize=11)
    multiples = sorted({spot.multiple for spot in spots})
    axis.set_xticks(multiples, [f"{x:g}" for x in multiples])
    ratios = sorted({spot.mass_ratio for spot in spots})
    axis.set_yticks(ratios, [f"{x:.2g}" for x in ratios])
    axis.minorticks_off()
    axis.margins(0.12)
    axis.grid(alpha=0.25)


def page(lines: Sequence[Line], spots: Sequence[Spot], picture: Path | None, folder: Path) -> Path:
    """``stability.html``: everything in itself."""
    cases = {line.case.name: line.case for line in lines}
    text = filled(
        "studies/hard/page.html",
        head=HEAD[1:],
        map_head=MAP_HEAD,
        cases=[(case, [one for one in lines if one.case is case]) for case in cases.values()],
        picture=data_uri(picture.read_bytes(), "image/png") if picture else "",
        spots=[spot.words() for spot in spots],
        counts={name: sum(line.verdict == name for line in lines) for name in _verdicts(lines)},
    )
    write_text(folder / "stability.html", text)
    return folder / "stability.html"


def _verdicts(lines: Sequence[Line]) -> list[str]:
    return list(dict.fromkeys(line.verdict for line in lines))
