"""A picture of how the mats flip, and of how they would at other strokes, speeds and pre-stretches."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from typing import Any

import numpy as np
from matplotlib.patches import Patch, Rectangle

from orchestrator.ports.plans import SolverFailed
from orchestrator.preflight.mats.chart import Chart, make_chart
from orchestrator.preflight.mats.mats import Mats, mats_or_reason
from orchestrator.preflight.scene.scene import Scene
from orchestrator.views.style import WIDE, figure

COLORS = {"down": "#bfe3dd", "both": "#f3c3bd", "up": "#f7dcb5", "taut": "#e3e6ea"}
WORDS = {
    "down": "hangs down in every turn",
    "both": "up in some turns",
    "up": "up in every turn",
    "taut": "taut",
}


def draw_mats(scene: Scene) -> Iterator[tuple[str, Any]]:
    """Return the name and the figure of each kind of mats; none where it is not known how they flip.

    The charts are made at once, beside what the caller does until it asks for the first figure.
    """
    found = mats_or_reason(scene)
    if isinstance(found, str):
        return iter(())
    with_others = ThreadPoolExecutor()
    charts = [with_others.submit(make_chart, mats.trial) for mats in found]
    with_others.shutdown(wait=False)
    return _drawn(found, charts)


def _drawn(found: Sequence[Mats], charts: Sequence[Future[Chart]]) -> Iterator[tuple[str, Any]]:
    for mats, chart in zip(found, charts, strict=True):
        with suppress(SolverFailed):  # another stroke may be more than the solver can
            yield mats.panels[0], _draw(mats, chart.result())


def _draw(mats: Mats, chart: Chart) -> Any:
    """Return the figure: the middle's height over some turns, and a chart for each pre-stretch."""
    fig, ((over_time, *_), parts) = figure(2, len(chart.tension_m), WIDE, 7.2)
    grid = over_time.get_gridspec()
    for axes in fig.axes[: len(chart.tension_m)]:
        axes.remove()
    _draw_heights(fig.add_subplot(grid[0, :]), mats)
    for axes, tension_m, rows in zip(parts, chart.tension_m, chart.regimes, strict=True):
        for (y, row), (x, _) in ((a, b) for a in enumerate(rows) for b in enumerate(chart.stroke_m)):
            own = y == len(rows) // 2 and x == len(row) // 2 and axes is parts[len(parts) // 2]
            regime = mats.empty if own else row[x]
            edge, width, order = ("black", 2.0, 3) if own else ("white", 1.0, 2)
            corner, color = (x - 0.5, y - 0.5), COLORS[regime.side]
            axes.add_patch(Rectangle(corner, 1.0, 1.0, fc=color, ec=edge, lw=width, zorder=order))
            text = f"{regime.mean_peak_g:.0f}\n{regime.mean_quoted_peak_g:.0f}"
            axes.text(x, y, text, ha="center", va="center", fontsize=7.5, zorder=4)
        rpm = 60 / (2 * math.pi) * chart.speed_rad_per_s
        axes.set_xticks(range(len(chart.stroke_m)), [f"{1e3 * value:.2g}" for value in chart.stroke_m])
        axes.set_yticks(range(len(rpm)), [f"{value:.0f}" for value in rpm])
        axes.set(xlim=(-0.5, len(chart.stroke_m) - 0.5), ylim=(-0.5, len(rpm) - 0.5))
        axes.grid(visible=False)
        how = f"{'taut' if tension_m > 0 else 'slack'} by {1e3 * abs(tension_m):.2g} mm"
        axes.set_title("neither taut nor slack" if abs(tension_m) <= 1e-6 else how)
        axes.set_xlabel("stroke / mm")
    parts[0].set_ylabel("speed / rpm")
    handles = [Patch(fc=color, label=WORDS[side]) for side, color in COLORS.items()]
    fig.legend(handles=handles, loc="outside lower center", ncols=len(handles))
    fig.suptitle(
        f"{mats.name}, empty: mean peak of a turn in g, below 500 Hz (upper) and below 100 Hz (lower number)"
    )
    return fig


def _draw_heights(axes: Any, mats: Mats) -> None:
    """Draw the height of the middle over the line between the clamps, turn by turn."""
    for regime, label in ((mats.empty, "empty"), (mats.loaded, "with the bed's mass moving along")):
        if regime is not None:
            turn = np.arange(regime.height_m.size) / regime.height_m.shape[1]
            axes.plot(turn, 1e3 * regime.height_m.ravel(), label=label)
    axes.axhline(0.0, color="black", lw=0.8)
    axes.set(xlabel="turns of the machine", ylabel="middle over its clamps / mm", xlim=(0, mats.empty.turns))
    axes.set_title(f"{mats.name}: {mats.empty.in_words}")
    axes.legend(loc="upper right", ncols=2)
