"""The deck seen from the side and above, with the particles on it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pyvista

VIEW = (0.45, -1.0, 0.75)  # from the side and above
PANELS, WALLS = ("#d8b64a", "#b98f2f"), "#8090a0"  # neighbouring panels can be told apart


def deck(folder: Path, time_s: float, path: Path) -> None:
    """The last surface with the particles as spheres, coloured by speed."""
    plotter = pyvista.Plotter(off_screen=True, window_size=(1280, 720))
    plotter.enable_anti_aliasing("ssaa")
    surface = pyvista.read(_last(folder / "surface"))
    panel = surface.cell_data["panel"]
    for number in (0, 1):
        cells = np.flatnonzero((panel >= 0) & (panel % 2 == number))
        if len(cells):
            part = surface.extract_cells(cells)
            plotter.add_mesh(part, color=PANELS[number], show_edges=True, edge_opacity=0.25)
    if (panel < 0).any():
        walls = surface.extract_cells(np.flatnonzero(panel < 0))
        plotter.add_mesh(walls, color=WALLS, opacity=0.12)
        plotter.add_mesh(walls.extract_feature_edges(20), color=WALLS, line_width=2)
    if (folder / "particles").is_dir():
        _add_particles(plotter, pyvista.read(_last(folder / "particles")))
    plotter.add_text(f"t = {time_s:.4g} s", position="upper_left", color="black", font_size=12)
    plotter.add_axes(color="black")
    plotter.set_background("white")
    plotter.view_vector(VIEW, viewup=(0, 0, 1))
    plotter.reset_camera(bounds=surface.bounds)
    plotter.camera.zoom(1.2)
    plotter.screenshot(path)
    plotter.close()


def _add_particles(plotter: Any, particles: Any) -> None:
    """The colour bar stands uphill, where the fewest particles are in the way."""
    if particles.n_points == 0:
        return
    sphere = pyvista.Sphere(radius=0.5, theta_resolution=16, phi_resolution=16)
    fast = float(np.percentile(particles["speed_m_per_s"], 98))  # a few that fall do not dim the rest
    plotter.add_mesh(
        particles.glyph(scale="diameter_m", orient=False, geom=sphere),
        scalars="speed_m_per_s",
        cmap="viridis",
        clim=(0.0, fast or 1.0),
        smooth_shading=True,
        scalar_bar_args={
            "title": "speed / (m/s)\n",
            "color": "black",
            "vertical": True,
            "position_x": 0.06,
            "position_y": 0.3,
            "height": 0.5,
            "n_labels": 5,
            "fmt": "%.2g",
            "title_font_size": 18,
            "label_font_size": 16,
        },
    )


def _last(series: Path) -> Path:
    return sorted(series.glob("*.vtu"))[-1]
