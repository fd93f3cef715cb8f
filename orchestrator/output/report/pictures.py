"""Pictures of a finished (or interrupted) run, made from its folder alone.

``python -m orchestrator.output.report.pictures RUN`` runs in a process of its own: the renderer's
libraries do not share memory with the solvers', and a picture that fails loses nothing.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.colors import Normalize
from scipy.integrate import trapezoid

from orchestrator.output.results.run_reader import RunReader

AXES = "xyz"
COLUMNS = 4  # panels side by side in a picture


def frame_motion(history: Any, cycle_s: float, path: Path) -> None:
    """Displacement of every frame's centre of mass over time, and its orbit in the last cycle."""
    names = list(history["frames"])
    figure, axes = _axes(len(names), 2, (11, 3.2 * len(names)), width_ratios=(3, 1))
    for (series, orbit), name in zip(axes, names, strict=True):
        time = history[f"frames/{name}/time_s"][:]
        moved = 1e3 * history[f"frames/{name}/displacement_m"][:]
        for axis in range(3):
            series.plot(time, moved[:, axis], label=AXES[axis], lw=1)
        last = moved[time >= time[-1] - cycle_s]
        orbit.plot(last[:, 0], last[:, 2], lw=1)
        orbit.plot(last[-1, 0], last[-1, 2], "o", ms=4, color="black", label="end")
        series.set(xlabel="time / s", ylabel="displacement / mm")
        series.set_title(f"frame {name}: centre of mass, world axes", loc="left")
        orbit.set(xlabel="x / mm", ylabel="z / mm", title="orbit, last cycle")
        orbit.axis("equal")
        for axis in (series, orbit):
            axis.grid(alpha=0.3)
        series.legend(loc="lower right", bbox_to_anchor=(1, 1), ncols=3, frameon=False)
        orbit.legend(loc="best", fontsize=8)
    _save(figure, path)


def panel_shapes(history: Any, cycle_s: float, path: Path) -> None:
    """Centre lines at up to eight moments of the last cycle: height above the straight line
    between the panel's ends at t = 0, enlarged against the length."""
    names = list(history["panels"])
    columns = min(COLUMNS, len(names))
    rows = -(-len(names) // columns)
    figure, axes = _axes(rows, columns, (11, 1 + 3.5 * rows), sharey=True)
    colours = plt.get_cmap("hsv")
    for axis, name in zip(axes.flat, names, strict=False):
        time, lines = (history[f"panels/{name}/{what}"][:] for what in ("time_s", "centre_line_m"))
        along, up = _chord(lines[0])
        last = np.flatnonzero(time > time[-1] - 15 / 16 * cycle_s)  # each phase once
        for moment in last[np.linspace(0, len(last) - 1, min(8, len(last))).astype(int)]:
            line = 1e3 * (lines[moment] - lines[0][0])
            phase = time[moment] / cycle_s % 1
            axis.plot(line @ along, line @ up, color=colours(phase), lw=1.5)
        axis.set(title=f"panel {name}", xlabel="along / mm")
        axis.grid(alpha=0.3)
    for axis in axes.flat[len(names) :]:
        axis.axis("off")
    for row in axes:
        row[0].set_ylabel("height / mm, enlarged")
    scale = plt.cm.ScalarMappable(Normalize(0, 1), colours)
    figure.colorbar(scale, ax=axes, label=f"part of the cycle of {cycle_s:.4g} s")
    figure.suptitle("centre lines in the last cycle")
    _save(figure, path)


def _chord(line: Any) -> tuple[Any, Any]:
    """Unit vectors along a line of points from its first to its last, and up from it."""
    along = (line[-1] - line[0]) / np.linalg.norm(line[-1] - line[0])
    vertical = np.array([0.0, 0.0, 1.0]) if abs(along[2]) < 0.9 else np.array([1.0, 0.0, 0.0])
    up = vertical - (vertical @ along) * along
    return along, up / np.linalg.norm(up)


def bushing_loops(history: Any, cycle_s: float, path: Path) -> None:
    """Force against deformation of every bushing in the last cycle, along the axis in which it is
    deformed most; the area is the energy lost in the cycle."""
    names = list(history["bushings"])
    columns = min(COLUMNS, len(names))
    rows = -(-len(names) // columns)
    figure, axes = _axes(rows, columns, (11, 1 + 3.2 * rows), sharex=True, sharey=True)
    for axis, name in zip(axes.flat, names, strict=False):
        time, deformed, force = (
            history[f"bushings/{name}/{what}"][:] for what in ("time_s", "deformation_m", "force_N")
        )
        last = time >= time[-1] - cycle_s
        along = int(np.ptp(deformed[last], axis=0).argmax())
        x, y = 1e3 * deformed[last, along], 1e-3 * force[last, along]
        axis.plot(x, y, lw=1.2)
        lost_J = abs(trapezoid(y, x))
        axis.set_title(f"{name}, its {AXES[along]} axis: {lost_J:.3g} J", loc="left", fontsize=9)
        axis.grid(alpha=0.3)
    for axis in axes.flat[len(names) :]:
        axis.axis("off")
    for axis in axes[-1]:
        axis.set_xlabel("deformation / mm")
    for row in axes:
        row[0].set_ylabel("force / kN")
    figure.suptitle("bushings in the last cycle, and the energy that each loses in it")
    _save(figure, path)


def energy(history: Any, path: Path) -> None:
    """The ledger in three parts of very different size: what went in and out, what is stored,
    and what should be zero.  Terms below a thousandth of a part's largest are left out."""
    figure, axes = _axes(3, 1, (11, 10), sharex=True)
    time = history["energy/time_s"][:]
    terms = {name: values[:] for name, values in history["energy"].items() if name != "time_s"}
    parts = {
        "supplied and lost since t = 0": ("supplied.", "lost."),
        "change of what is stored since t = 0": ("stored.",),
        "created by the coupling, and the members' own defects": ("created.", "defect."),
    }
    for axis, (title, books) in zip(axes.flat, parts.items(), strict=True):
        part = {name: values for name, values in terms.items() if name.startswith(books)}
        size = {name: float(np.abs(values).max()) for name, values in part.items()}
        for name in sorted(part, key=lambda name: -size[name])[:10]:
            if size[name] >= 1e-3 * max(size.values()):
                label = name.removesuffix("_J").removeprefix("stored.")
                axis.plot(time, part[name], lw=1.2, label=label)
        axis.set_title(title, loc="left")
        axis.set_ylabel("energy / J")
        axis.grid(alpha=0.3)
        axis.legend(fontsize=8, loc="center left", bbox_to_anchor=(1, 0.5), frameon=False)
    axis.set_xlabel("time / s")
    _save(figure, path)


def _axes(rows: int, columns: int, figsize: tuple[float, float], **more: Any) -> Any:
    return plt.subplots(rows, columns, figsize=figsize, squeeze=False, layout="constrained", **more)


def _save(figure: Any, path: Path) -> None:
    figure.savefig(path, dpi=110)
    plt.close(figure)


def draw(folder: Path) -> list[str]:
    """All pictures that the folder has data for; returns their names."""
    with RunReader(folder) as run:
        history, cycle_s, end_s = run.history, run.summary["cycle_s"], run.summary["simulated_s"]
        if "frames" in history:
            frame_motion(history, cycle_s, folder / "frame_motion.png")
        if "panels" in history:
            panel_shapes(history, cycle_s, folder / "panel_shapes.png")
        if "bushings" in history:
            bushing_loops(history, cycle_s, folder / "bushing_loops.png")
        if "energy" in history:
            energy(history, folder / "energy.png")
            end_s = float(history["energy/time_s"][-1])
    if any((folder / "surface").glob("*.vtu")):
        from orchestrator.output.report.rendering import deck

        deck(folder, end_s, folder / "deck.png")
    return sorted(picture.name for picture in folder.glob("*.png"))


if __name__ == "__main__":
    sys.stdout.write("\n".join(draw(Path(sys.argv[1]))) + "\n")
