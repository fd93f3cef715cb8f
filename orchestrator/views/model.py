"""The interactive model of a machine in three dimensions: one page that opens without a network.

pyvista makes the scene, and trame-vtk's serializers and viewer (vtk.js) make the page of it; neither opens
a window or a server.
"""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Sequence
from html import escape
from typing import Any

import numpy as np
import pyvista
from vtkmodules.vtkCommonCore import vtkLogger

from orchestrator.case.bed.sources import initial_particles
from orchestrator.case.deck.panels import axes
from orchestrator.case.tables.case import has_particles
from orchestrator.ports import Array, Indices
from orchestrator.ports.grains import placed_spheres
from orchestrator.views.drawings import BLOCK, EXIT, FEED, PANEL_COLORS, SPRING, frame_color
from orchestrator.views.outline import MachineOutline, PanelOutline

MOST_OPENINGS, MOST_PARTICLES = 20_000, 1500
VIEW = (0.45, -1.0, 0.6)  # From the side, the upper end and above.
MATT = {"ambient": 0.45, "diffuse": 0.65}  # Faces that look away from the light stay bright.
OPENING, PARTICLE = "#fdf6df", "#55606b"


def model_page(machine: MachineOutline) -> str:
    """Return the HTML of the page: drag to turn, wheel to zoom, shift and drag to move."""
    from trame_vtk.tools.vtksz2html import write_html

    page = io.StringIO()
    write_html(_serialised(_scene(machine)), page)
    before, after = page.getvalue().rsplit("</body>", 1)
    legend = json.dumps(_legend(machine)).replace("</", "<\\/")  # The viewer empties the body when it starts.
    script = f'document.documentElement.insertAdjacentHTML("beforeend", {legend})'
    return f"{before}<script>{script}</script></body>{after}"


def _scene(machine: MachineOutline) -> Any:
    """Return a plotter with everything in the machine; nothing is rendered."""
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_ERROR)  # No screen is needed, and VTK says it has none.
    plotter = pyvista.Plotter(off_screen=True, window_size=(1200, 800))
    plotter.set_background("white")
    size_m = float(np.ptp(machine.points_m, axis=0).max())
    for number in (0, 1):
        rows = machine.panels[number::2]
        if rows:
            plotter.add_mesh(_polygons([row.free_m for row in rows]), color=PANEL_COLORS[number], **MATT)
    if clamps := [clamp_m for row in machine.panels for clamp_m in _clamps(row)]:
        plotter.add_mesh(_polygons(clamps), color="#333333")
    openings = _openings(machine)
    for corners in {len(outline) for outline in openings}:
        alike = [outline for outline in openings if len(outline) == corners]
        plotter.add_mesh(_polygons(alike), color=OPENING, **MATT)
    for wall in machine.walls:
        color = frame_color(machine, wall.frame)
        plotter.add_mesh(_polygons(wall.triangles_m), color=color, opacity=0.12)
        plotter.add_mesh(_lines(wall.edges_m), color=color, line_width=2)
    for row in machine.bushings:
        for place_m in row.places_m:
            side_m = 0.02 * size_m
            cube = pyvista.Cube(center=place_m, x_length=side_m, y_length=side_m, z_length=side_m)
            plotter.add_mesh(cube, color=SPRING)
    for name, center_m in machine.centers_m.items():
        ball = pyvista.Sphere(radius=0.018 * size_m, center=center_m)
        plotter.add_mesh(ball, color=frame_color(machine, name))
    for exciter in machine.exciters:
        color = frame_color(machine, exciter.table.frame)
        at = {"center": exciter.place_m, "direction": exciter.axis}
        shaft = pyvista.Cylinder(radius=0.008 * size_m, height=0.16 * size_m, **at)
        plotter.add_mesh(shaft, color=color)
        plotter.add_mesh(_turning(exciter.place_m, exciter.axis, 0.05 * size_m), color=color)
    for boxes, color in ((machine.feeds, FEED), (machine.blocks, BLOCK), (machine.exits, EXIT)):
        for box in boxes:
            plotter.add_mesh(_box_edges(_near(box.corners_m, machine)), color=color, line_width=2)
            if box.velocity_m_per_s.any():
                arrow = pyvista.Arrow(start=box.middle_m, direction=box.velocity_m_per_s, scale=0.12 * size_m)
                plotter.add_mesh(arrow, color=color)
    if (spheres := _particles(machine)) is not None:
        plotter.add_mesh(spheres, color=PARTICLE, smooth_shading=True)
    plotter.view_vector(VIEW, viewup=(0, 0, 1))
    low, high = machine.points_m.min(axis=0), machine.points_m.max(axis=0)
    plotter.reset_camera(bounds=np.column_stack([low, high]).ravel())
    plotter.camera.zoom(1.25)
    return plotter


def _serialised(plotter: Any) -> bytes:
    """Return a plotter's scene in the format of vtk.js's viewer, a zipped JSON, and close the plotter."""
    from trame_vtk.modules.vtk.serializers import (
        SynchronizationContext,
        extract_array_hash,
        initialize_serializers,
        reference_id,
        serialize,
    )

    initialize_serializers()
    context, window = SynchronizationContext(), plotter.render_window
    context.set_ignore_last_dependencies(True)
    scene = serialize(None, window, reference_id(window), context, 1)
    camera = plotter.renderer.GetActiveCamera()
    scene["extra"] = {
        "vtkRefId": reference_id(window),
        "centerOfRotation": camera.GetFocalPoint(),
        "camera": reference_id(camera),
    }
    arrays = {
        entry["hash"]: {**entry, "content": context.get_cached_data_array(entry["hash"], False)}
        for entry in extract_array_hash(scene)
    }
    plotter.close()
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as file:
        file.writestr("index.json", json.dumps({"hashes": arrays, "scene": scene}))
    return archive.getvalue()


def _legend(machine: MachineOutline) -> str:
    rows = [(PANEL_COLORS[0], f"{len(machine.panels)} panels")] if machine.panels else []
    rows += [(frame_color(machine, name), f"frame {name}") for name in machine.frames]
    for what, color, things in (
        ("bushings", SPRING, machine.bushings),
        ("feed", FEED, machine.feeds),
        ("block", BLOCK, machine.blocks),
        ("exit", EXIT, machine.exits),
    ):
        if things:
            rows.append((color, f"{what} {', '.join(row.name for row in things)}"))
    items = "".join(
        f'<div><span style="display:inline-block;width:12px;height:12px;margin-right:6px;background:{color}">'
        f"</span>{escape(text)}</div>"
        for color, text in rows
    )
    return (
        '<div style="position:fixed;z-index:10;left:14px;top:12px;padding:8px 12px;border-radius:4px;'
        'font:13px sans-serif;background:rgba(255,255,255,.85);pointer-events:none">'
        f"<b>{escape(machine.case.title)}</b>{items}"
        '<div style="color:#666;margin-top:4px">drag: turn · wheel: zoom · shift and drag: move</div></div>'
    )


def _polygons(corners_m: Sequence[Array] | Array) -> Any:
    """Return polygons of equally many corners, (n, corners, 3), as one mesh."""
    points_m, cells = _points_and_cells(corners_m)
    return pyvista.PolyData(points_m, cells)


def _lines(ends_m: Sequence[Array] | Array) -> Any:
    """Return straight lines (n, 2, 3) as one mesh."""
    points_m, cells = _points_and_cells(ends_m)
    return pyvista.PolyData(points_m, lines=cells)


def _points_and_cells(corners_m: Sequence[Array] | Array) -> tuple[Array, Indices]:
    """Return the points of equal cells, (n, corners, 3), and VTK's list of their numbers, cell by cell."""
    count, corners = np.shape(corners_m)[:2]
    numbers = np.arange(count * corners).reshape(count, corners)
    return np.reshape(corners_m, (-1, 3)), np.column_stack([np.full(count, corners), numbers]).ravel()


def _openings(machine: MachineOutline) -> list[Array]:
    """Return the openings as polygons (n, 3) on the panels' faces; none if there are very many."""
    rows: list[Array] = []
    for outline in machine.panels:
        lift_m = 1e-3 * outline.panel.rectangle.normal
        rows += [corners + way * lift_m for way in (1.0, -1.0) for corners in outline.openings_m]
    return rows if len(rows) <= 2 * MOST_OPENINGS else []


def _turning(place_m: Array, axis: Array, radius_m: float) -> Any:
    """Return a ring with a cone that shows the positive sense about an axis."""
    unit = axis / np.linalg.norm(axis)
    first = np.cross(unit, [1.0, 0.0, 0.0] if abs(unit[0]) < 0.9 else [0.0, 1.0, 0.0])
    first /= np.linalg.norm(first)
    second = np.cross(unit, first)
    angles = np.radians(np.linspace(20, 320, 40))
    ring = place_m + radius_m * (np.outer(np.cos(angles), first) + np.outer(np.sin(angles), second))
    way = -np.sin(angles[-1]) * first + np.cos(angles[-1]) * second
    tube = pyvista.lines_from_points(ring).tube(radius=0.07 * radius_m, n_sides=8)
    tip = pyvista.Cone(
        center=ring[-1] + 0.15 * radius_m * way,
        direction=way,
        height=0.5 * radius_m,
        radius=0.2 * radius_m,
        resolution=16,
    )
    return tube.merge(tip)


def _near(corners_m: Array, machine: MachineOutline) -> Array:
    """Return a box's corners (8, 3), drawn in along the deck axes to the surroundings of the machine."""
    turn = axes(machine.case)
    points_m = machine.points_m @ turn
    low, high = points_m.min(axis=0), points_m.max(axis=0)
    room = 0.2 * float(max(high - low))
    return np.asarray(np.clip(corners_m @ turn, low - room, high + room) @ turn.T)


def _clamps(row: PanelOutline) -> tuple[Array, Array]:
    """Return the parts (4, 3) of a panel under its two clamps."""
    whole, free = row.corners_m, row.free_m
    return np.stack([whole[0], free[0], free[3], whole[3]]), np.stack([free[1], whole[1], whole[2], free[2]])


def _box_edges(corners_m: Array) -> Any:
    """Return the twelve edges of a box whose corners (8, 3) are in the order of a product of limits."""
    pairs = [(a, a | bit) for bit in (1, 2, 4) for a in range(8) if not a & bit]
    return _lines(corners_m[np.array(pairs)])


def _particles(machine: MachineOutline) -> Any:
    """Return the spheres of the particles at the start, of a sample if there are many; None without any."""
    case = machine.case
    bed = case.bed
    if not has_particles(case) or not (bed.particles or bed.blocks or bed.carried):
        return None
    start = initial_particles(case)
    shown = np.unique(np.linspace(0, len(start) - 1, min(len(start), MOST_PARTICLES)).astype(int))
    some = start.part(shown)
    _, center_m, radius_m = placed_spheres(some.grains, some.position_m, some.orientation)
    cloud = pyvista.PolyData(center_m)
    cloud["size_m"] = 2.0 * radius_m
    ball = pyvista.Sphere(radius=0.5, theta_resolution=8, phi_resolution=6)
    return cloud.glyph(scale="size_m", orient=False, geom=ball)
