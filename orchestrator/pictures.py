"""Pictures of a finished (or interrupted) run, made from its folder alone.

``python -m orchestrator.pictures RUN`` runs in a process of its own: the renderer's libraries do
not share memory with the solvers', and a picture that fails loses nothing.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import h5py
import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.colors import Normalize

AXES = "xyz"
VIEW = (0.35, -1.0, 0.55)  # from the side and above


def frame_motion(history: Any, cycle_s: float, path: Path) -> None:
    """Displacement of every frame's centre of mass over time, and its orbit in the last cycle."""
    names = list(history["frames"])
    figure, axes = plt.subplots(
        len(names), 2, figsize=(11, 3.2 * len(names)), width_ratios=(3, 1), squeeze=False
    )
    for (series, orbit), name in zip(axes, names, strict=True):
        time = history[f"frames/{name}/time_s"][:]
        moved = 1e3 * history[f"frames/{name}/displacement_m"][:]
        for axis in range(3):
            series.plot(time, moved[:, axis], label=AXES[axis], lw=1)
        last = time >= time[-1] - cycle_s
        orbit.plot(moved[last, 0], moved[last, 2], lw=1)
        series.set(xlabel="time / s", ylabel="displacement / mm", title=f"frame {name}")
        orbit.set(xlabel="x / mm", ylabel="z / mm", title="orbit, last cycle")
        orbit.axis("equal")
        series.legend(loc="upper left", ncols=3)
    _save(figure, path)


def panel_shapes(history: Any, cycle_s: float, path: Path) -> None:
    """Centre lines of all panels, side view, at eight moments of the last cycle."""
    figure, axis = plt.subplots(figsize=(11, 4.5))
    colours = plt.get_cmap("twilight_shifted")
    for name in history["panels"]:
        time = history[f"panels/{name}/time_s"][:]
        for phase in np.arange(8) / 8:
            moment = int(np.argmin(np.abs(time - (time[-1] - cycle_s * (1 - phase)))))
            line = history[f"panels/{name}/centre_line_m"][moment]
            axis.plot(line[:, 0], line[:, 2], color=colours(phase), lw=1.2)
    axis.set(xlabel="x / m", ylabel="z / m", title="panels in the last cycle, coloured by phase")
    axis.axis("equal")
    scale = plt.cm.ScalarMappable(Normalize(0, 1), colours)
    figure.colorbar(scale, ax=axis, label="phase of the cycle")
    _save(figure, path)


def energy(history: Any, path: Path) -> None:
    """Every term of the ledger that ever reaches a thousandth of the largest."""
    figure, axis = plt.subplots(figsize=(11, 4.5))
    time = history["energy/time_s"][:]
    terms = {name: values[:] for name, values in history["energy"].items() if name != "time_s"}
    largest = max(float(np.abs(values).max()) for values in terms.values()) or 1.0
    for name, values in sorted(terms.items(), key=lambda term: -float(np.abs(term[1]).max())):
        if np.abs(values).max() >= 1e-3 * largest:
            axis.plot(time, values, lw=1, label=name.removesuffix("_J"))
    axis.set(xlabel="time / s", ylabel="energy / J", title="energy ledger")
    axis.legend(fontsize=7, ncols=2, loc="upper left")
    _save(figure, path)


def deck(folder: Path, path: Path) -> None:
    """The last surface with the particles on it, coloured by speed."""
    import pyvista

    plotter = pyvista.Plotter(off_screen=True, window_size=(1280, 720))
    surface = pyvista.read(_last(folder / "surface"))
    plotter.add_mesh(surface, color="#c9a227", show_edges=True, edge_color="#8a7020", opacity=0.9)
    if (folder / "particles").is_dir():
        particles = pyvista.read(_last(folder / "particles"))
        if particles.n_points:
            sphere = pyvista.Sphere(radius=0.5, theta_resolution=14, phi_resolution=14)
            balls = particles.glyph(scale="diameter_m", orient=False, geom=sphere)
            plotter.add_mesh(
                balls,
                scalars="speed_m_s",
                cmap="viridis",
                scalar_bar_args={"title": "speed / (m/s)", "color": "black"},
            )
    plotter.set_background("white")
    plotter.view_vector(VIEW, viewup=(0, 0, 1))
    plotter.camera.zoom(1.3)
    plotter.screenshot(path)
    plotter.close()


def _last(series: Path) -> Path:
    return sorted(series.glob("*.vtu"))[-1]


def _save(figure: Any, path: Path) -> None:
    figure.tight_layout()
    figure.savefig(path, dpi=110)
    plt.close(figure)


def draw(folder: Path) -> list[str]:
    """All pictures that the folder has data for; returns their names."""
    cycle_s = json.loads((folder / "summary.json").read_text())["cycle_s"]
    with h5py.File(folder / "history.h5") as history:
        if "frames" in history:
            frame_motion(history, cycle_s, folder / "frame_motion.png")
        if "panels" in history:
            panel_shapes(history, cycle_s, folder / "panel_shapes.png")
        if "energy" in history:
            energy(history, folder / "energy.png")
    if (folder / "surface").is_dir():
        deck(folder, folder / "deck.png")
    return sorted(picture.name for picture in folder.glob("*.png"))


if __name__ == "__main__":
    sys.stdout.write("\n".join(draw(Path(sys.argv[1]))) + "\n")
