"""Pictures of a run's machine, from its folder alone: for the report's page, and as files.

``python -m orchestrator.output.report.pictures RUN`` writes the files.  It runs in a process of its
own: the renderer's libraries do not share memory with the solvers', and a picture that fails loses
nothing.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import colormaps
from scipy.integrate import trapezoid

from orchestrator.case.deck.panels import single_panels
from orchestrator.output.report.drawing import HALF, HELD, WIDE, figure, save
from orchestrator.output.results.run_reader import RunReader

COLUMNS = 4  # panels or bushings side by side
LOWEST = 3.8  # inches high: a single row of panels is legible
MOMENTS = 8  # of a cycle
MOST_POINTS = 4000  # of a line
SMALLEST_SHARE = 1e-3  # of the largest term of a picture: smaller ones are left out


def draw_frames(run: RunReader) -> Any:
    """Draws the displacement of the frames' centres of mass along and normal to the deck over the
    run, and their orbits in the last cycle."""
    drawn, axes = figure(2, 2, WIDE, 5.0, width_ratios=(2, 1))
    for row in axes:
        row[1].remove()
    orbit = drawn.add_subplot(axes[0, 1].get_gridspec()[:, 1])
    for name in run.names("frames"):
        time_s = run.read(f"frames/{name}/time_s")
        moved_mm = 1e3 * run.read(f"frames/{name}/displacement_m") @ run.deck_axes
        stride = max(len(moved_mm) // MOST_POINTS, 1)
        for series, axis in ((axes[0, 0], 0), (axes[1, 0], 2)):
            series.plot(time_s[::stride], moved_mm[::stride, axis], lw=0.8, label=name)
        last_mm = moved_mm[time_s > time_s[-1] - run.cycle_s]
        last_mm = last_mm - (last_mm.max(axis=0) + last_mm.min(axis=0)) / 2
        orbit.plot(last_mm[:, 0], last_mm[:, 2], lw=1)
    axes[0, 0].set(ylabel="along / mm", title="frames' centres of mass")
    axes[1, 0].set(ylabel="normal / mm", xlabel="time / s")
    axes[1, 0].legend(loc="upper left", ncols=3, bbox_to_anchor=(0, -0.25))
    orbit.set(xlabel="along the deck / mm", ylabel="normal to the deck / mm", title="orbits, last cycle")
    orbit.set_aspect("equal", "datalim")
    return drawn


def draw_panel_shapes(run: RunReader) -> Any:
    """Draws the centre lines of the panels at moments of the last cycle (of the whole run where
    nothing drives it), over the line between their ends as built."""
    panels = {panel.name: panel.rectangle for panel in single_panels(run.case)}
    drawn, axes = _grid(len(panels), "height / mm, enlarged", 0.6, 2.3)
    for ax, (name, at) in zip(axes.flat, panels.items(), strict=False):
        time_s = run.read(f"panels/{name}/time_s")
        lines_m = run.read(f"panels/{name}/centre_line_m") - at.corner_m
        span_s = 15 / 16 * run.cycle_s if run.is_driven else np.inf  # each phase once
        last = np.flatnonzero(time_s > time_s[-1] - span_s)
        for number in last[np.linspace(0, len(last) - 1, min(MOMENTS, len(last))).astype(int)]:
            phase = time_s[number] / run.cycle_s % 1.0 if run.is_driven else time_s[number] / time_s[-1]
            line_mm = 1e3 * lines_m[number]
            colour = colormaps["twilight_shifted"](0.1 + 0.8 * phase)  # comes round after a cycle
            ax.plot(line_mm @ at.along, line_mm @ at.normal, lw=1.1, color=colour)
        ax.set(title=name, xlabel="along / mm")
    return drawn


def draw_bushing_loops(run: RunReader) -> Any:
    """Draws force against deformation of every bushing in the last cycle, along the axis in which it
    is deformed most; the area is the energy lost in the cycle."""
    names = run.names("bushings")
    drawn, axes = _grid(len(names), "force / kN", 1.0, 2.8)
    for ax, name in zip(axes.flat, names, strict=False):
        end_s = float(run.read(f"bushings/{name}/time_s")[-1])
        deformation_m, force_N = (
            run.read_between(f"bushings/{name}", what, end_s - run.cycle_s, end_s)
            for what in ("deformation_m", "force_N")
        )
        axis = int(np.ptp(deformation_m, axis=0).argmax())
        x, y = 1e3 * deformation_m[:, axis], 1e-3 * force_N[:, axis]
        ax.plot(x, y, lw=1.2)
        ax.set(title=f"{name}, {'xyz'[axis]}: {abs(trapezoid(y, x)):.3g} J", xlabel="deformation / mm")
    return drawn


def draw_energy(run: RunReader) -> Any:
    """Draws the energy ledger in three parts: what went in and out, what is stored, and what should
    be zero.  Terms below a thousandth of a part's largest are left out."""
    time_s = run.read("energy/time_s")
    terms_J = {name: run.read(f"energy/{name}") for name in run.names("energy") if name != "time_s"}
    parts = {
        "supplied and lost since t = 0": ("supplied.", "lost."),
        "change of what is stored": ("stored.",),
        "out of nothing: should be small": ("created.", "defect."),
    }
    drawn, (row,) = figure(1, 3, WIDE, 3.8)
    for ax, (title, books) in zip(row, parts.items(), strict=True):
        sizes_J = {name: float(np.abs(v).max()) for name, v in terms_J.items() if name.startswith(books)}
        for name in sorted(sizes_J, key=lambda name: -sizes_J[name])[:8]:
            if sizes_J[name] >= SMALLEST_SHARE * max(sizes_J.values()):
                ax.plot(time_s, terms_J[name], lw=1.2, label=name.removesuffix("_J").removeprefix("stored."))
        ax.set(title=title, xlabel="time / s", ylabel="energy / J")
        ax.legend(loc="upper left", bbox_to_anchor=(0, -0.2), fontsize=7.5)
    return drawn


def draw_cost(wall_by_part_s: dict[str, float]) -> Any:
    """Draws where the wall time went."""
    drawn, ((axes,),) = figure(1, 1, HALF, 2.6)
    parts = list(wall_by_part_s)[::-1]
    seconds = [wall_by_part_s[part] for part in parts]
    bars = axes.barh(parts, seconds, color=HELD)
    whole = sum(seconds) or 1.0
    axes.bar_label(bars, [f" {100 * s / whole:.0f} %" for s in seconds], fontsize=9)
    axes.set(title="where the time went", xlabel="wall time / s", xlim=(0, 1.15 * max(seconds)))
    axes.grid(axis="y", visible=False)
    return drawn


def draw_machine(run: RunReader) -> Iterator[tuple[str, Any]]:
    """Yields the name of every picture that the run has data for, and its figure."""
    drawings = {
        "frames": ("frame_motion", draw_frames),
        "panels": ("panel_shapes", draw_panel_shapes),
        "bushings": ("bushing_loops", draw_bushing_loops),
        "energy": ("energy", draw_energy),
    }
    for group, (name, draw) in drawings.items():
        if run.has(group):
            yield name, draw(run)


def write_pictures(folder: Path) -> None:
    """Writes all pictures that the folder of a run has data for."""
    with RunReader(folder) as run:
        end_s = run.end_s
        for name, drawn in draw_machine(run):
            save(drawn, folder / f"{name}.png")
    if any((folder / "surface").glob("*.vtu")):
        from orchestrator.output.report.rendering import render_deck

        render_deck(folder, end_s, folder / "deck.png")


def _grid(count: int, ylabel: str, edge: float, height: float) -> tuple[Any, Any]:
    """A figure with axes for so many parts, side by side in rows."""
    columns = min(COLUMNS, count)
    rows = -(-count // columns)
    drawn, axes = figure(rows, columns, WIDE, max(edge + height * rows, LOWEST))
    for ax in axes.flat[count:]:
        ax.axis("off")
    for row in axes:
        row[0].set_ylabel(ylabel)
    return drawn, axes


if __name__ == "__main__":
    write_pictures(Path(sys.argv[1]))
