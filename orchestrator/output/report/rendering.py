"""The rendering of the deck with its particles from the snapshots of a run: a picture and a short film.

``python -m orchestrator.output.report.rendering RUN SECONDS FILE`` writes the film as animated WebP.
"""

from __future__ import annotations

import io
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Any

import numpy as np
import pyvista
from PIL import Image

from orchestrator.case.file.folder import part_of
from orchestrator.output.records.run_folder import WALLS

PANELS, GREY = ("#d8b64a", "#b98f2f"), "#8090a0"  # neighbouring panels differ in colour
PICTURE_VIEW = (0.45, -1.0, 0.75)  # from the side and above
FILM_VIEW = (0.12, -1.0, 0.28)  # nearly from the side, a little from above
PICTURE_BAR = {"vertical": True, "position_x": 0.06, "position_y": 0.3, "height": 0.5, "n_labels": 5}
PICTURE_BAR |= {"title_font_size": 18, "label_font_size": 16}  # uphill, where it hides the fewest particles
FILM_BAR = {"position_x": 0.73, "position_y": 0.86, "width": 0.26, "height": 0.12, "n_labels": 2}
FILM_BAR |= {"title_font_size": 15, "label_font_size": 14}
FRAMES = 32
WIDTH, SMALLEST, LARGEST, TEXT = 1120, 300, 620, 70  # pixels
MARGIN = 1.06
FRAME_MS = 90
QUALITY = 65


def render_deck(folder: Path, time_s: float, file: Path) -> None:
    """Write a picture of the last surface, with the particles as spheres in the colours of their speeds."""
    plotter = pyvista.Plotter(off_screen=True, window_size=(1280, 720))
    plotter.enable_anti_aliasing("ssaa")
    surface, walls = pyvista.read(snapshots(folder, "surface")[-1][1]), _wall_edges(folder)
    _add_deck(plotter, surface, walls, show_edges=True, edge_opacity=0.25)
    if last := _grains(folder):
        particles = pyvista.read(last[-1][1])
        _add_spheres(plotter, particles, _fast_m_per_s(particles), **PICTURE_BAR)
    plotter.add_text(f"t = {time_s:.4g} s", position="upper_left", color="black", font_size=12)
    plotter.add_axes(color="black")
    plotter.set_background("white")
    plotter.view_vector(PICTURE_VIEW, viewup=(0, 0, 1))
    plotter.reset_camera(bounds=pyvista.MultiBlock([surface, walls]).bounds)
    plotter.camera.zoom(1.2)
    plotter.screenshot(file)
    plotter.close()


def render_film(folder: Path, lasting_s: float) -> tuple[bytes, list[float]]:
    """Return the WebP of the run's last ``lasting_s`` seconds and the times of its frames.

    The film has at most ``FRAMES`` frames.  Raises FileNotFoundError if the run has no snapshots.
    """
    frames = last_snapshots(snapshots(folder, "surface"), lasting_s)
    if not frames:
        raise FileNotFoundError("the run has no snapshots of the surface")
    particles = dict(_grains(folder))
    walls = _wall_edges(folder)
    ends = [_triangle_points_m(pyvista.read(file)) for _, file in (frames[0], frames[-1])]
    ends_m = np.vstack(ends if walls is None else [*ends, walls.points])
    middle = _read(particles.get(frames[len(frames) // 2][0]))
    fast_m_per_s = _fast_m_per_s(middle) if middle is not None else 1.0
    plotter = pyvista.Plotter(off_screen=True)
    plotter.set_background("white")
    pictures = []
    for time_s, surface in frames:
        plotter.clear()
        _add_deck(plotter, pyvista.read(surface), walls, ambient=0.3)
        _add_spheres(plotter, _read(particles.get(time_s)), fast_m_per_s, **FILM_BAR)
        plotter.add_text(f"t = {time_s:.3f} s", color="black", font_size=10)
        _aim_camera(plotter, ends_m)
        pictures.append(Image.fromarray(plotter.screenshot(return_img=True)))
    plotter.close()
    webp, first = io.BytesIO(), pictures[0]
    animation = {"save_all": True, "append_images": pictures[1:], "duration": FRAME_MS, "loop": 0}
    first.save(webp, "WEBP", quality=QUALITY, method=4, **animation)
    return webp.getvalue(), [time_s for time_s, _ in frames]


def snapshots(folder: Path, series: str) -> list[tuple[float, Path]]:
    """Return the times and files of a ParaView series, without what only stands beside; empty if there is no
    such series."""
    index = folder / f"{series}.pvd"
    if not index.is_file():
        return []
    entries = [e for e in ElementTree.parse(index).getroot().iter("DataSet") if e.get("part", "0") == "0"]
    pairs = [(float(e.get("timestep", "nan")), part_of(folder, e.get("file", ""))) for e in entries]
    return [(time_s, file) for time_s, file in pairs if file.is_file()]


def last_snapshots(pairs: list[tuple[float, Path]], lasting_s: float) -> list[tuple[float, Path]]:
    """Return at most ``FRAMES`` snapshots of the last ``lasting_s`` seconds, and the last one at least."""
    if not pairs:
        return []
    last = [pair for pair in pairs if pair[0] > pairs[-1][0] - lasting_s] or pairs[-1:]
    stride = -(-len(last) // FRAMES)
    return last[::-stride][::-1]


def _grains(folder: Path) -> list[tuple[float, Path]]:
    """Return the snapshots of all spheres of which particles are made, or those of the particles."""
    return snapshots(folder, "spheres") or snapshots(folder, "particles")


def _read(file: Path | None) -> Any:
    return pyvista.read(file) if file is not None else None


def _fast_m_per_s(particles: Any) -> float:
    """Return the upper end of the colour scale: a few particles that fall do not dim the slower ones."""
    if particles.n_points == 0:
        return 1.0
    return float(np.percentile(particles["speed_m_per_s"], 97)) or 1.0


def _triangle_points_m(surface: Any) -> Any:
    """Return the points (n, 3) of triangles; other points, such as probes, may lie anywhere."""
    return surface.points[np.unique(surface.cells_dict[pyvista.CellType.TRIANGLE])]


def _wall_edges(folder: Path) -> Any:
    """Return the edges of a run's rigid surfaces; None without any."""
    file = folder / WALLS
    edges = pyvista.read(file).extract_feature_edges(20) if file.is_file() else None
    return edges if edges is not None and edges.n_points else None


def _add_deck(plotter: Any, surface: Any, walls: Any, **panels: Any) -> None:
    """Add the panels in two colours, and the edges of walls."""
    panel = surface.cell_data.get("panel", np.empty(0))
    for number in (0, 1):
        cells = np.flatnonzero(panel % 2 == number)
        if len(cells):
            plotter.add_mesh(surface.extract_cells(cells), color=PANELS[number], **panels)
    if walls is not None:
        plotter.add_mesh(walls, color=GREY, line_width=1)


def _add_spheres(plotter: Any, particles: Any, fast_m_per_s: float, **bar: Any) -> None:
    """Add particles as discs that are shaded as spheres, with a colour bar of their speeds.

    100 000 of them take half a second; as meshes they take twenty.
    """
    if particles is None or particles.n_points == 0:
        return
    spheres = pyvista.PolyData(np.asarray(particles.points))
    spheres["speed_m_per_s"] = particles["speed_m_per_s"]
    single = "diameter_m" in particles.point_data
    spheres["diameter_m"] = particles["diameter_m" if single else "equivalent_diameter_m"]
    actor = plotter.add_mesh(
        spheres,
        style="points_gaussian",
        render_points_as_spheres=True,
        emissive=False,
        ambient=0.4,  # so that the rims of small particles are not black
        scalars="speed_m_per_s",
        cmap="viridis",
        clim=(0.0, fast_m_per_s),
        show_scalar_bar=True,
        scalar_bar_args={"title": "speed / (m/s)", "color": "black", "fmt": "%.2g", **bar},
    )
    actor.mapper.scale_array = "diameter_m"
    actor.mapper.scale_factor = 0.5


def _aim_camera(plotter: Any, points_m: Any) -> None:
    """Make the points (n, 3) fill the view, with some room above them for thrown particles."""
    toward = np.array(FILM_VIEW) / np.linalg.norm(FILM_VIEW)
    right = np.cross([0.0, 0.0, 1.0], toward)
    right /= np.linalg.norm(right)
    axes = np.stack([right, np.cross(toward, right), toward])
    shown_m = points_m @ axes.T
    wide, tall, _ = MARGIN * np.ptp(shown_m, axis=0)
    height = min(max(WIDTH * tall / wide + TEXT, SMALLEST), LARGEST)
    scale = max(wide / WIDTH, tall / (height - TEXT))  # m to a pixel
    middle = (shown_m.max(axis=0) + shown_m.min(axis=0)) / 2 + [0.0, scale * TEXT / 2, 0.0]
    plotter.window_size = [WIDTH, int(height) // 2 * 2]
    plotter.enable_parallel_projection()
    plotter.camera.focal_point = middle @ axes
    plotter.camera.position = middle @ axes + 10.0 * wide * toward
    plotter.camera.up = (0.0, 0.0, 1.0)
    plotter.camera.parallel_scale = scale * height / 2
    plotter.reset_camera_clipping_range()


if __name__ == "__main__":
    webp, times_s = render_film(Path(sys.argv[1]), float(sys.argv[2]))
    Path(sys.argv[3]).write_bytes(webp)
    print(len(times_s), times_s[0], times_s[-1])
