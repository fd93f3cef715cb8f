"""A short film of the deck from its snapshots, as animated WebP:

python -m orchestrator.output.report.animation RUN SECONDS FILE
"""

from __future__ import annotations

import io
import json
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Any

import numpy as np
import pyvista
from PIL import Image

from orchestrator.output.report.rendering import PANELS, WALLS

FRAMES = 32
WIDTH, SMALLEST, LARGEST, TEXT = 1120, 300, 620, 70  # pixels
MARGIN = 1.06
FRAME_MS = 90
QUALITY = 65
VIEW = (0.12, -1.0, 0.28)  # nearly from the side, a little from above


def film(folder: Path, lasting_s: float) -> tuple[bytes, list[float]]:
    """WebP of the run's last ``lasting_s`` seconds, at most ``FRAMES`` frames, and their times.
    Raises FileNotFoundError without snapshots."""
    shown = _chosen(listed(folder, "surface"), lasting_s)
    if not shown:
        raise FileNotFoundError("the run has no snapshots of the surface")
    particles = dict(listed(folder, "particles"))
    ends = np.vstack([_touched_m(pyvista.read(file)) for _, file in (shown[0], shown[-1])])
    fast = _fast(particles, shown)
    plotter = pyvista.Plotter(off_screen=True)
    plotter.set_background("white")
    pictures = []
    for time_s, surface in shown:
        plotter.clear()
        _add_deck(plotter, pyvista.read(surface))
        _add_spheres(plotter, _read(particles.get(time_s)), fast)
        plotter.add_text(f"t = {time_s:.3f} s", color="black", font_size=10)
        _look(plotter, ends)
        pictures.append(Image.fromarray(plotter.screenshot(return_img=True)))
    plotter.close()
    return _webp(pictures), [time_s for time_s, _ in shown]


def listed(folder: Path, series: str) -> list[tuple[float, Path]]:
    """Times and files of a ParaView series; empty if there is none."""
    index = folder / f"{series}.pvd"
    if not index.is_file():
        return []
    entries = ElementTree.parse(index).getroot().iter("DataSet")
    pairs = [(float(e.get("timestep", "nan")), folder / e.get("file", "")) for e in entries]
    return [(time_s, file) for time_s, file in pairs if file.is_file()]


def _chosen(pairs: list[tuple[float, Path]], lasting_s: float) -> list[tuple[float, Path]]:
    if not pairs:
        return []
    last = [pair for pair in pairs if pair[0] > pairs[-1][0] - lasting_s]
    stride = -(-len(last) // FRAMES)
    return last[::-stride][::-1]


def _read(file: Path | None) -> Any:
    return pyvista.read(file) if file is not None else None


def _fast(particles: dict[float, Path], shown: list[tuple[float, Path]]) -> float:
    """Where the colours end: nearly all of the particles in the middle of the film are slower."""
    read = _read(particles.get(shown[len(shown) // 2][0]))
    if read is None or read.n_points == 0:
        return 1.0
    return float(np.percentile(read["speed_m_per_s"], 95)) or 1.0


def _touched_m(surface: Any) -> Any:
    """(n, 3) points of triangles; others are only looked at, and may be anywhere."""
    return surface.points[np.unique(surface.cells_dict[pyvista.CellType.TRIANGLE])]


def _add_deck(plotter: Any, surface: Any) -> None:
    """Panels in two colours, walls as their edges."""
    panel = surface.cell_data["panel"]
    for number in (0, 1):
        cells = np.flatnonzero((panel >= 0) & (panel % 2 == number))
        if len(cells):
            plotter.add_mesh(surface.extract_cells(cells), color=PANELS[number], ambient=0.3)
    if (panel < 0).any():
        walls = surface.extract_cells(np.flatnonzero(panel < 0))
        plotter.add_mesh(walls.extract_feature_edges(20), color=WALLS, line_width=1)


def _add_spheres(plotter: Any, particles: Any, fast: float) -> None:
    """As splats, which cost a fraction of meshed spheres."""
    if particles is None or particles.n_points == 0:
        return
    spheres = pyvista.PolyData(np.asarray(particles.points))
    for name in ("speed_m_per_s", "diameter_m"):
        spheres[name] = particles[name]
    actor = plotter.add_mesh(
        spheres,
        style="points_gaussian",
        render_points_as_spheres=True,
        emissive=False,
        scalars="speed_m_per_s",
        cmap="viridis",
        clim=(0.0, fast),
        show_scalar_bar=True,
        scalar_bar_args={
            "title": "speed / (m/s)",
            "color": "black",
            "position_x": 0.73,
            "position_y": 0.86,
            "width": 0.26,
            "height": 0.12,
            "n_labels": 2,
            "fmt": "%.2g",
            "title_font_size": 15,
            "label_font_size": 14,
        },
    )
    actor.mapper.scale_array = "diameter_m"
    actor.mapper.scale_factor = 0.5


def _look(plotter: Any, points_m: Any) -> None:
    """The points (n, 3) fill the view, with some room above them for what is thrown."""
    toward = np.array(VIEW) / np.linalg.norm(VIEW)
    right = np.cross([0.0, 0.0, 1.0], toward)
    right /= np.linalg.norm(right)
    axes = np.stack([right, np.cross(toward, right), toward])
    seen = points_m @ axes.T
    wide, tall, _ = MARGIN * np.ptp(seen, axis=0)
    height = min(max(WIDTH * tall / wide + TEXT, SMALLEST), LARGEST)
    scale = max(wide / WIDTH, tall / (height - TEXT))  # m to a pixel
    middle = (seen.max(axis=0) + seen.min(axis=0)) / 2 + [0.0, scale * TEXT / 2, 0.0]
    plotter.window_size = [WIDTH, int(height) // 2 * 2]
    plotter.enable_parallel_projection()
    plotter.camera.focal_point = middle @ axes
    plotter.camera.position = middle @ axes + 10.0 * wide * toward
    plotter.camera.up = (0.0, 0.0, 1.0)
    plotter.camera.parallel_scale = scale * height / 2
    plotter.reset_camera_clipping_range()


def _webp(pictures: list[Image.Image]) -> bytes:
    made = io.BytesIO()
    pictures[0].save(
        made,
        "WEBP",
        save_all=True,
        append_images=pictures[1:],
        duration=FRAME_MS,
        loop=0,
        quality=QUALITY,
        method=4,
    )
    return made.getvalue()


if __name__ == "__main__":
    webp, times_s = film(Path(sys.argv[1]), float(sys.argv[2]))
    Path(sys.argv[3]).write_bytes(webp)
    said = {"frames": len(times_s), "start_s": times_s[0], "end_s": times_s[-1]}
    sys.stdout.write(json.dumps(said))
