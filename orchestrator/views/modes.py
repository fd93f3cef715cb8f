"""The modes of the frames as one animated drawing, an SVG that moves in every browser.

Each mode has a cell.  It shows the frames as pale bodies that move with the shape of the mode, many times
larger than in the machine, and the panels between them.  The view is the one in which the mode is seen
best.  The animation is SVG's own (SMIL): W3C, SVG Animations Level 2.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

from orchestrator.case.deck.panels import to_world
from orchestrator.ports import Array
from orchestrator.preflight.scene.frame_modes import FrameMode
from orchestrator.views.drawings import FRONT, PANEL_COLORS, SIDE, TOP, View, convex_hull, frame_color
from orchestrator.views.outline import MachineOutline, carried_points_m

CELL_PX, COLUMNS, MARGIN_PX, HEAD_PX = (360, 230), 3, 22, 46
STROKE = 0.075  # Largest displacement over the size of the machine.
FRAMES, PERIOD_S = 24, 1.6
SHARES = np.sin(2 * np.pi * np.arange(FRAMES + 1) / FRAMES)
"""The shares of the amplitude over one period, the first again at the end."""
VIEWS = (SIDE, TOP, SIDE, FRONT, SIDE, TOP)
"""The view for each coordinate of a frame: along, across, normal, roll, pitch, yaw."""
NEAR = "#c1443c"


@dataclass(frozen=True)
class Cell:
    """The drawing of one mode: a view, and the scale (px/m) and the shift (2,) of its points."""

    view: View
    scale: float
    shift: Array

    def of(self, points_m: Array) -> Array:
        """Return points (n, 3) of the world in pixels of the cell (n, 2); y points down."""
        return self.shift + self.view.of(points_m) * self.scale * [1.0, -1.0]


def modes_svg(machine: MachineOutline, modes: Sequence[FrameMode], excited_Hz: Sequence[float]) -> str:
    """Return an SVG with a cell for each mode; modes within 15 % of an excitation have red titles."""
    rows = -(-len(modes) // COLUMNS)
    width, height = COLUMNS * CELL_PX[0], rows * (CELL_PX[1] + HEAD_PX)
    cells = "".join(
        f'<g transform="translate({number % COLUMNS * CELL_PX[0]},'
        f'{number // COLUMNS * (CELL_PX[1] + HEAD_PX)})">{"".join(_cell(machine, mode, excited_Hz))}</g>'
        for number, mode in enumerate(modes)
    )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" '
        f'viewBox="0 0 {width} {height}" font-family="DejaVu Sans, sans-serif" font-size="11">'
        f'<rect width="100%" height="100%" fill="white"/>{cells}</svg>\n'
    )


def _cell(machine: MachineOutline, mode: FrameMode, excited_Hz: Sequence[float]) -> Iterator[str]:
    view = VIEWS[int(np.argmax(mode.energy.sum(axis=0)))]
    cell = _fit(machine, view)
    near = [f for f in excited_Hz if abs(mode.frequency_Hz - f) <= 0.15 * f]
    color = NEAR if near else "#222222"
    title = f"{mode.frequency_Hz:.3g} Hz, {mode.damping_ratio:.1%} damping, {view.name} view"
    yield f'<text x="12" y="16" font-weight="bold" fill="{color}">{escape(title)}</text>'
    for number, line in enumerate(_two_lines(mode.shape)):
        yield f'<text x="12" y="{30 + 13 * number}" fill="{color}">{escape(line)}</text>'
    bodies = {name: carried_points_m(machine, name) for name in mode.frames}
    moved = {name: _displacement(machine, mode, name, points) for name, points in bodies.items()}
    largest_m = max(
        (float(np.linalg.norm(part, axis=1).max()) for part in moved.values() if len(part)), default=0.0
    )
    size_m = float(np.ptp(machine.points_m, axis=0).max())
    factor = STROKE * size_m / largest_m if largest_m else 0.0
    for name, points in bodies.items():
        if len(points) < 2:
            continue
        own = frame_color(machine, name)
        drawn = cell.of(points)
        hull = [int(np.linalg.norm(drawn - corner, axis=1).argmin()) for corner in convex_hull(drawn)]
        outline = _listed(drawn[hull])
        yield f'<polygon points="{outline}" fill="none" stroke="#b5bcc4" stroke-dasharray="3 3"/>'
        path = [cell.of(points + share * factor * moved[name])[hull] for share in SHARES]
        yield _moving(path, f'fill="{own}" fill-opacity="0.18" stroke="{own}" stroke-width="1.5"')
    for number, row in enumerate(machine.panels):
        ends = []
        for end, corners in ((0, [0, 3]), (1, [1, 2])):
            places = row.corners_m[corners]
            frame = row.panel.frames[end]
            shift = _displacement(machine, mode, frame, places) if frame in mode.frames else np.zeros((2, 3))
            ends.append((places, shift))
        (one, one_by), (two, two_by) = ends
        path = [
            cell.of(np.vstack([one + s * factor * one_by, (two + s * factor * two_by)[::-1]])) for s in SHARES
        ]
        style = f'fill="{PANEL_COLORS[number % 2]}" fill-opacity="0.5" stroke="{PANEL_COLORS[number % 2]}"'
        yield _moving(path, f'{style} stroke-width="2"')


def _displacement(machine: MachineOutline, mode: FrameMode, frame: str, points_m: Array) -> Array:
    """Return the displacement (n, 3) of points of a frame in a mode, in world axes."""
    number = mode.frames.index(frame)
    shift = to_world(machine.case, mode.displacement[number])
    turn = to_world(machine.case, mode.rotation[number])
    center_m = machine.centers_m.get(frame, points_m.mean(axis=0) if len(points_m) else np.zeros(3))
    return np.asarray(shift + np.cross(turn, points_m - center_m))


def _fit(machine: MachineOutline, view: View) -> Cell:
    """Return the cell that shows the frames' points and the panels in a view, with room for motion."""
    parts = [carried_points_m(machine, name) for name in machine.frames]
    parts += [row.corners_m for row in machine.panels]
    shown = view.of(np.concatenate(parts))
    low, high = shown.min(axis=0), shown.max(axis=0)
    size = np.maximum(high - low, 1e-9)
    room = np.array(CELL_PX) - 2 * MARGIN_PX
    motion = 2 * STROKE * float(np.ptp(machine.points_m, axis=0).max())
    scale = float(min(room / (size + motion)))
    middle = (low + high) / 2
    center = np.array([CELL_PX[0] / 2, HEAD_PX + CELL_PX[1] / 2])
    return Cell(view, scale, center - middle * scale * [1.0, -1.0])


def _two_lines(shape: str) -> tuple[str, str]:
    for word in (" against ", " with "):
        if word in shape:
            first, second = shape.split(word, 1)
            return first, f"{word.strip()} {second}"
    return shape, ""


def _moving(path: Sequence[Array], style: str) -> str:
    values = ";".join(_listed(points) for points in path)
    return (
        f'<polygon points="{_listed(path[0])}" {style}><animate attributeName="points" '
        f'dur="{PERIOD_S}s" repeatCount="indefinite" values="{values}"/></polygon>'
    )


def _listed(points: Array) -> str:
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
