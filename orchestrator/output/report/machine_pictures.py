"""Figures of the machine: orbits, panel shapes, energy, and where the time went."""

from __future__ import annotations

from typing import Any

import numpy as np

from orchestrator.case.deck.panels import single_panels
from orchestrator.output.report.drawing import HALF, HELD, LINES, WIDE, embedded, figure
from orchestrator.output.results.run_reader import RunReader

COLUMNS = 4
MOMENTS = 8


def orbits(data: RunReader, start_s: float, end_s: float) -> str:
    """Paths of the frames' centres of mass in deck axes, in the cycles averaged over."""
    drawn, ((axes,),) = figure(1, 1, HALF, 4.0)
    for name in data.names("frames"):
        moved = 1e3 * data.read_between(f"frames/{name}", "displacement_m", start_s, end_s) @ data.deck_axes
        moved -= (moved.max(axis=0) + moved.min(axis=0)) / 2
        stride = max(len(moved) // 3000, 1)
        axes.plot(moved[::stride, 0], moved[::stride, 2], lw=1, label=name)
    axes.set(xlabel="along the deck / mm", ylabel="normal to the deck / mm")
    axes.set(title="orbits of the frames' centres of mass")
    axes.set_aspect("equal", "datalim")
    axes.legend(loc="upper left", ncols=3, bbox_to_anchor=(0, -0.15))
    return embedded(drawn)


def motion(data: RunReader) -> str:
    """Displacement of the frames along and normal to the deck over the whole run."""
    drawn, axes = figure(2, 1, HALF, 4.0)
    for name in data.names("frames"):
        time = data.read(f"frames/{name}/time_s")
        moved = 1e3 * data.read(f"frames/{name}/displacement_m") @ data.deck_axes
        stride = max(len(moved) // 4000, 1)
        for ax, axis in ((axes[0, 0], 0), (axes[1, 0], 2)):
            ax.plot(time[::stride], moved[::stride, axis], lw=0.8, label=name)
    axes[0, 0].set(ylabel="along / mm", title="frames over the whole run")
    axes[1, 0].set(ylabel="normal / mm", xlabel="time / s")
    axes[1, 0].legend(loc="upper left", ncols=3, bbox_to_anchor=(0, -0.35))
    return embedded(drawn)


def shapes(data: RunReader) -> str:
    """Centre lines of the panels at moments of the last cycle (of the whole run where nothing
    drives it), over the line between their ends."""
    panels = single_panels(data.case)
    columns = min(COLUMNS, len(panels))
    rows = -(-len(panels) // columns)
    drawn, axes = figure(rows, columns, WIDE, 0.6 + 2.3 * rows)
    for ax, panel in zip(axes.flat, panels, strict=False):
        time = data.read(f"panels/{panel.name}/time_s")
        lines = data.read(f"panels/{panel.name}/centre_line_m") - panel.rectangle.corner_m
        normal = np.cross(panel.rectangle.along, panel.rectangle.across)
        span_s = 15 / 16 * data.cycle_s if data.is_driven else np.inf
        last = np.flatnonzero(time > time[-1] - span_s)
        for number in last[np.linspace(0, len(last) - 1, min(MOMENTS, len(last))).astype(int)]:
            phase = (time[number] / data.cycle_s) % 1.0 if data.is_driven else time[number] / time[-1]
            line = 1e3 * lines[number]
            ax.plot(line @ panel.rectangle.along, line @ normal, lw=1.1, color=_phase(phase))
        ax.set_title(panel.name)
        ax.set_xlabel("along / mm")
    for ax in axes.flat[len(panels) :]:
        ax.axis("off")
    for row in axes:
        row[0].set_ylabel("height / mm, enlarged")
    return embedded(drawn)


def _phase(part: float) -> Any:
    """A colour that comes round again after a cycle."""
    from matplotlib import colormaps

    return colormaps["twilight_shifted"](0.1 + 0.8 * part)


def energy(data: RunReader) -> str:
    """What came in, what is lost and stored, and what the coupling made of it."""
    time = data.read("energy/time_s")
    terms = {name: data.read(f"energy/{name}") for name in data.names("energy")}
    drawn, ((books, made),) = figure(1, 2, WIDE, 3.2)
    for number, book in enumerate(("supplied", "lost", "stored")):
        total = sum(v for name, v in terms.items() if name.startswith(f"{book}."))
        books.plot(time, total * np.ones_like(time), color=LINES[number], label=book)
    for name, values in terms.items():
        if name.startswith(("created.", "defect.")):
            made.plot(time, values, label=name.removesuffix("_J"))
    books.set(title="energy since t = 0", ylabel="energy / J")
    made.set(title="energy out of nothing: should be small", ylabel="energy / J")
    for ax in (books, made):
        ax.set_xlabel("time / s")
        ax.legend(loc="upper left", ncols=2, bbox_to_anchor=(0, -0.2), fontsize=8.5)
    return embedded(drawn)


def cost(wall_by_part_s: dict[str, float]) -> str:
    """Where the wall time went."""
    drawn, ((axes,),) = figure(1, 1, HALF, 2.6)
    parts = list(wall_by_part_s)[::-1]
    seconds = [wall_by_part_s[part] for part in parts]
    bars = axes.barh(parts, seconds, color=HELD)
    whole = sum(seconds) or 1.0
    axes.bar_label(bars, [f" {100 * s / whole:.0f} %" for s in seconds], fontsize=9)
    axes.set(title="where the time went", xlabel="wall time / s", xlim=(0, 1.15 * max(seconds)))
    axes.grid(axis="y", visible=False)
    return embedded(drawn)
