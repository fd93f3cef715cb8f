"""The dimensioned side view and top view of a machine, drawn to scale with matplotlib."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.collections import EllipseCollection, LineCollection, PolyCollection
from matplotlib.patches import Arc, Circle, Polygon, Wedge

from orchestrator.case.deck.panels import to_world
from orchestrator.case.tables.frames import Drive
from orchestrator.case.tables.quantities import GROUND
from orchestrator.ports import Array
from orchestrator.ports.grains import placed_spheres
from orchestrator.views.labels import Labels
from orchestrator.views.outline import BoxOutline, MachineOutline, carried_points_m
from orchestrator.views.style import LINES, figure

PANEL_COLORS = ("#c79a1e", "#8f6a0f")  # Neighbouring panels differ.
WALL, FEED, EXIT, BLOCK, DIMENSION = "#7d8b99", "#2e7d32", "#c1443c", "#6b7f1f", "#444444"
SPRING, BED = "#7a5195", "#8a7f72"
WIDTH_IN, TALLEST_IN = 12.0, 9.0
COINCIDING = 0.03  # of the drawing's size: arrows of driven frames whose middles are nearer share a label
EXIT_DEPTH = 0.16  # of the drawing's width: exits are shown so far below the machine


@dataclass(frozen=True)
class View:
    """A projection of the world onto a plane: the rows (3,) of ``to_right`` and ``to_top``."""

    name: str
    to_right: tuple[float, float, float]
    to_top: tuple[float, float, float]
    right_text: str
    top_text: str

    @property
    def toward(self) -> Array:
        """The unit vector (3,) that points out of the drawing, to the reader."""
        return np.asarray(np.cross(np.array(self.to_right), np.array(self.to_top)))

    def of(self, points_m: Array) -> Array:
        """Return points (..., 3) of the world in the drawing (..., 2)."""
        return np.asarray(np.asarray(points_m) @ np.array([self.to_right, self.to_top]).T)


SIDE = View("side", (1.0, 0.0, 0.0), (0.0, 0.0, 1.0), "x / m, horizontal", "z / m, up")
TOP = View("top", (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), "x / m, horizontal", "y / m, across")
FRONT = View("front", (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), "y / m, across", "z / m, up")


def frame_color(machine: MachineOutline, name: str) -> str:
    """Return the colour of a frame in all views; the ground is grey."""
    return WALL if name == GROUND else LINES[machine.frames.index(name) % len(LINES)]


def draw_view(machine: MachineOutline, view: View) -> Any:
    """Return the figure of a machine in a view, with dimensions and a label for everything."""
    drawing = _Drawing(machine, view)
    drawing.walls()
    drawing.boxes()
    drawing.panels()
    drawing.bushings()
    drawing.centers()
    drawing.exciters()
    drawing.carried_bed()
    drawing.particles()
    drawing.dimensions()
    drawing.label()
    return drawing.figure


class _Drawing:
    """A drawing that grows call by call; ``label`` comes last, when all that labels avoid is there."""

    def __init__(self, machine: MachineOutline, view: View) -> None:
        self._machine, self._view = machine, view
        shown = view.of(machine.points_m)
        low, high = shown.min(axis=0), shown.max(axis=0)
        size = float(max(high - low)) or 1.0  # a machine may be a single point
        below = EXIT_DEPTH if machine.exits or machine.panels else 0.06
        low = low - size * np.array([0.14, below + 0.04])
        high = high + size * np.array([0.14, 0.14])
        wide, tall = high - low
        grow = np.array([max(0.0, tall / 0.68 - wide), max(0.0, 0.4 * wide - tall)]) / 2
        self._low, self._high = low - grow, high + grow
        wide, tall = self._high - self._low
        height_in = min(TALLEST_IN, (WIDTH_IN - 1.0) * tall / wide + 1.0)
        self.figure, ((axes,),) = figure(width=WIDTH_IN, height=height_in, layout="none")
        axes.set_position((0.075, 0.55 / height_in, 0.915, 1 - 1.0 / height_in))
        axes.set(xlim=(self._low[0], self._high[0]), ylim=(self._low[1], self._high[1]), aspect="equal")
        axes.set_xlabel(view.right_text)
        axes.set_ylabel(view.top_text)
        axes.set_title(f"{machine.case.title} ({view.name} view)")
        axes.grid(visible=False)
        self._axes, self._size = axes, size
        self._points_per_m = 72 * 0.915 * WIDTH_IN / float(self._high[0] - self._low[0])
        self._lines: list[Array] = []
        self._symbols: list[tuple[Array, float]] = []
        self._texts: list[Any] = []
        self._wanted: list[tuple[str, Array, str, float]] = []

    def walls(self) -> None:
        """Draw the rigid surfaces: faces pale, edges as lines, in the colours of their frames."""
        groups: dict[str, list[Array]] = {}
        colors: dict[str, str] = {}
        for wall in self._machine.walls:
            color = frame_color(self._machine, wall.frame)
            triangles, edges = self._view.of(wall.triangles_m), list(self._view.of(wall.edges_m))
            faces = PolyCollection([*triangles], fc=color, ec="none", alpha=0.07, zorder=1)
            self._axes.add_collection(faces)
            self._axes.add_collection(LineCollection(edges, colors=color, lw=0.8, alpha=0.7, zorder=2))
            self._lines += edges
            name = wall.name.rstrip("0123456789").rstrip("-") or wall.name
            groups.setdefault(name, []).append(triangles.reshape(-1, 2))
            colors[name] = color
        named: dict[tuple[float, ...], tuple[list[str], Array, str]] = {}
        for name, parts in groups.items():
            points = np.concatenate(parts)
            key = tuple(np.round(np.concatenate([points.min(axis=0), points.max(axis=0)]), 3))
            middle = max(parts, key=lambda part: float(np.ptp(part, axis=0).sum())).mean(axis=0)
            names, _, _ = named.setdefault(key, ([], middle, colors[name]))
            names.append(name)
        for names, middle, color in named.values():
            self._wanted.append((", ".join(names), middle, color, 100.0))

    def boxes(self) -> None:
        """Draw feeds, blocks and exits as boxes; an arrow shows the velocity of a feed."""
        for kind, color, boxes in (
            ("exit", EXIT, self._machine.exits),
            ("feed", FEED, self._machine.feeds),
            ("block", BLOCK, self._machine.blocks),
        ):
            for box in boxes:
                self._box(kind, color, box)

    def _box(self, kind: str, color: str, box: BoxOutline) -> None:
        around = convex_hull(self._view.of(box.corners_m))
        pale = {"exit": 0.05, "feed": 0.18, "block": 0.15}[kind]
        self._axes.add_patch(Polygon(around, fc=color, ec="none", alpha=pale, zorder=0))
        self._axes.add_patch(Polygon(around, fill=False, ec=color, lw=0.9, ls=(0, (4, 3)), zorder=3))
        self._lines.append(np.vstack([around, around[:1]]))
        middle = clipped_middle(around, self._low, self._high)
        if middle is None:
            return
        title = box.name if kind == "exit" else f"{kind} {box.name}"
        if kind == "exit" and self._view.name == "top":  # The machine hides the middle.
            middle = np.array([middle[0], max(around[:, 1].min(), self._low[1]) + 0.03 * self._size])
        self._wanted.append((f"{title}\n{box.text}", middle, color, 80.0))
        velocity = self._view.of(box.velocity_m_per_s)
        if np.linalg.norm(velocity) > 0.05 * np.linalg.norm(box.velocity_m_per_s) > 0:
            arrow = 0.09 * self._size * velocity / np.linalg.norm(velocity)
            self._arrow(middle, middle + arrow, color)

    def _arrow(self, start: Array, end: Array, color: str, style: str = "-|>", width: float = 1.6) -> None:
        props = {"arrowstyle": style, "lw": width, "color": color, "shrinkA": 0, "shrinkB": 0}
        self._axes.annotate("", end, xytext=start, arrowprops=props, zorder=8)
        self._lines.append(np.array([start, end]))

    def panels(self) -> None:
        """Draw the panels, their clamps as dark ends, and seen from above their openings."""
        for number, row in enumerate(self._machine.panels):
            whole, free = self._view.of(row.corners_m), self._view.of(row.free_m)
            color = PANEL_COLORS[number % 2]
            self._axes.add_patch(Polygon(whole, fc="#333333", ec="#333333", lw=3.2, alpha=0.9, zorder=4))
            self._axes.add_patch(Polygon(free, fc=color, ec=color, lw=2.6, zorder=5))
            self._lines.append(np.vstack([whole, whole[:1]]))
            if self._view.name == "top" and row.panel.apertures is not None:
                places = [self._view.of(corners) for corners in row.openings_m]
                openings = PolyCollection(places, fc="white", ec="none", rasterized=True, zorder=6)
                self._axes.add_collection(openings)
        if not self._machine.panels:
            return
        middle = self._machine.panels[len(self._machine.panels) // 2]
        table = middle.panel.table
        count = len(self._machine.panels)
        sizes = f"{1e3 * table.length_m:g} × {1e3 * table.width_m:g} × {1e3 * table.thickness_m:g} mm"
        text = f"{count} panel{'s' if count > 1 else ''} of {table.material}\n{sizes}"
        self._wanted.append((text, self._view.of(middle.free_m).mean(axis=0), PANEL_COLORS[1], 110.0))

    def bushings(self) -> None:
        """Draw each bushing as a square with a cross, labelled once for each group."""
        for row in self._machine.bushings:
            places = self._view.of(row.places_m)
            self._axes.plot(
                *places.T, ls="none", marker="s", ms=7, mfc="white", mec=SPRING, mew=1.2, zorder=9
            )
            self._axes.plot(*places.T, ls="none", marker="x", ms=5, mec=SPRING, mew=1.0, zorder=10)
            self._symbols.append((places, 7.0))
            stiffness = stiffness_text(row.table.stiffness_N_per_m)
            curves = " and curves" if row.table.curves else ""
            text = (
                f"{row.name}, {len(places)} bushing{'s' if len(places) > 1 else ''}\n"
                f"{stiffness}{curves}\n"
                f"{row.table.between[0]} – {row.table.between[1]}"
            )
            self._wanted.append((text, places[np.argmin(places @ [0.3, 1.0])], SPRING, 250.0))

    def centers(self) -> None:
        """Draw each frame's centre of mass as a quartered circle, and the strokes of driven frames."""
        radius = 0.011 * self._size
        for name, center_m in self._machine.centers_m.items():
            at, color = self._view.of(center_m), frame_color(self._machine, name)
            self._axes.add_patch(Circle(_xy(at), radius, fc="white", ec=color, lw=1.4, zorder=11))
            for start in (0, 180):
                self._axes.add_patch(
                    Wedge(_xy(at), radius, start, start + 90, fc=color, ec="none", zorder=12)
                )
            self._symbols.append((at, 9.0))
            mass_kg = self._machine.case.screen.frames[name].mass_kg
            self._wanted.append((f"{name}, centre of mass\n{mass_kg:.4g} kg", at, color, 320.0))
        self._drives()

    def _drives(self) -> None:
        """Draw the stroke of each driven frame as an arrow; arrows about one point share a label."""
        groups: list[tuple[Array, dict[str, str]]] = []
        for name, frame in self._machine.case.screen.frames.items():
            if frame.drive is None:
                continue
            at = self._stroke(name, frame.drive)
            near = [row for place, row in groups if np.linalg.norm(at - place) < COINCIDING * self._size]
            if not near:
                near = [{}]
                groups.append((at, near[0]))
            sizes = " / ".join(f"{1e3 * value:.3g}" for value in frame.drive.amplitude_m)
            rate_Hz = frame.drive.speed_rad_per_s / (2 * math.pi)
            near[0][name] = f"{sizes} mm at {rate_Hz:.3g} Hz"
        for at, motions in groups:
            color = frame_color(self._machine, next(iter(motions)))
            self._wanted.append((motions_text(motions), at, color, 60.0))

    def _stroke(self, name: str, drive: Drive) -> Array:
        """Draw the arrow of a driven frame, unless it has no stroke in this view; return its middle (2,)."""
        carried = carried_points_m(self._machine, name)
        at = self._view.of(carried.mean(axis=0) if len(carried) else np.array(drive.center_m or (0, 0, 0)))
        stroke = self._view.of(to_world(self._machine.case, drive.amplitude_m))
        length = np.linalg.norm(stroke)
        if length > 0:
            half = 0.06 * self._size * stroke / length
            self._arrow(at - half, at + half, frame_color(self._machine, name), "<|-|>", 2.0)
        return at

    def exciters(self) -> None:
        """Draw each exciter as a circle whose arrow shows the turning sense in this view."""
        for row in self._machine.exciters:
            at, color = self._view.of(row.place_m), frame_color(self._machine, row.table.frame)
            turned = float(row.axis @ self._view.toward) / float(np.linalg.norm(row.axis))
            radius = 0.024 * self._size
            if abs(turned) > 0.5:  # The shaft points out of the drawing or into it.
                self._turning_arrow(at, radius, turned > 0, color)
            else:
                along = self._view.of(row.axis / np.linalg.norm(row.axis)) * 2.2 * radius
                self._axes.plot(*np.array([at - along, at + along]).T, color=color, lw=3, zorder=9)
                self._lines.append(np.array([at - along, at + along]))
            self._axes.plot(*at, marker="o", ms=4, color=color, zorder=13)
            self._symbols.append((at, radius * self._points_per_m + 2.0))
            speed = row.table.speed_rad_per_s
            force_N = row.table.mass_moment_kg_m * speed**2
            text = (
                f"exciter {row.name} on {row.table.frame}\n"
                f"{speed * 30 / math.pi:.0f} rpm = {speed / (2 * math.pi):.4g} Hz\n"
                f"{row.table.mass_moment_kg_m:.4g} kg m, {1e-3 * force_N:.3g} kN"
            )
            self._wanted.append((text, at, color, 40.0))

    def _turning_arrow(self, at: Array, radius: float, counterclockwise: bool, color: str) -> None:
        self._axes.add_patch(
            Arc(_xy(at), 2 * radius, 2 * radius, theta1=40, theta2=320, color=color, lw=2, zorder=12)
        )
        end_deg, way = (320.0, 1.0) if counterclockwise else (40.0, -1.0)
        angle = math.radians(end_deg)
        tip = at + radius * np.array([math.cos(angle), math.sin(angle)])
        step = way * 0.3 * radius * np.array([-math.sin(angle), math.cos(angle)])
        props = {
            "arrowstyle": "-|>",
            "lw": 2,
            "color": color,
            "shrinkA": 0,
            "shrinkB": 0,
            "mutation_scale": 14,
        }
        self._axes.annotate("", tip + 1.6 * step, xytext=tip - 0.2 * step, arrowprops=props, zorder=13)

    def carried_bed(self) -> None:
        """Draw the particles that are taken over from a run or a table, to scale."""
        bed = self._machine.case.bed.carried
        if bed is None:
            return
        _, center_m, radius_m = placed_spheres(bed.grains, bed.position_m, bed.orientation)
        places = self._view.of(center_m)
        size_m, turned = 2.0 * radius_m, np.zeros(len(places))
        style = {"fc": BED, "ec": "none", "alpha": 0.6, "zorder": 4}
        circles = EllipseCollection(
            size_m, size_m, turned, units="xy", offsets=places, transOffset=self._axes.transData, **style
        )
        self._axes.add_collection(circles)
        text = f"{len(bed)} particles taken over"
        self._wanted.append((text, np.median(places, axis=0), BED, 60.0))

    def particles(self) -> None:
        """Draw the single particles to scale."""
        given = self._machine.particles
        _, center_m, radius_m = placed_spheres(given.grains, given.position_m, given.orientation)
        for at, radius in zip(self._view.of(center_m), radius_m.tolist(), strict=True):
            self._axes.add_patch(Circle(_xy(at), radius, fc="#55606b", ec="black", lw=0.5, zorder=7))
            self._symbols.append((at, radius * self._points_per_m))
        if len(given):
            more = f" and {len(given) - 1} more" if len(given) > 1 else ""
            text = f"particle of {1e3 * given.grains.sieve_size_m[0]:.3g} mm{more}"
            self._wanted.append((text, self._view.of(given.position_m[0]), "#333333", 30.0))

    def dimensions(self) -> None:
        """Draw the deck's length and inclination from the side, its width and pitch from above."""
        panels = self._machine.panels
        if not panels:
            return
        ends_m = np.concatenate([row.corners_m for row in panels])
        along = ends_m @ self._machine.down
        first_m, last_m = ends_m[along.argmin()], ends_m[along.argmax()]
        if self._view.name == "side":
            slopes = [float(row.panel.rectangle.along[2]) for row in self._machine.panels]
            ends = "along the deck" if np.ptp(slopes) < 1e-4 else "from end to end"
            self._dimension(first_m, last_m, f"{np.ptp(along):.4g} m {ends}")
            self._slopes(self._view.of(last_m))
        if self._view.name == "top":
            offset, width_m = -0.05 * self._size, panels[-1].panel.rectangle.width_m
            if len(panels) > 1:
                one_m, two_m = (row.corners_m[0] for row in panels[:2])
                text = f"pitch {1e3 * np.linalg.norm(two_m - one_m):.4g} mm"
                self._between(self._view.of(one_m), self._view.of(two_m), offset, text)
            one, two = self._view.of(panels[-1].corners_m[1:3])
            self._between(one, two, offset, f"width {1e3 * width_m:.4g} mm")

    def _dimension(self, first_m: Array, last_m: Array, text: str) -> None:
        """Draw a dimension between two points of the deck, below all of the machine."""
        one, two = self._view.of(first_m), self._view.of(last_m)
        along = (two - one) / np.linalg.norm(two - one)
        normal = np.array([-along[1], along[0]])
        lowest = float(((self._view.of(self._machine.points_m) - one) @ normal).min())
        self._between(one, two, lowest - 0.04 * self._size, text)

    def _between(self, one: Array, two: Array, offset: float, text: str) -> None:
        """Draw a dimension line from one point to another, shifted to its left by ``offset``."""
        along = (two - one) / np.linalg.norm(two - one)
        normal = np.array([-along[1], along[0]])
        start, end = one + offset * normal, two + offset * normal
        over = math.copysign(0.012 * self._size, offset) * normal
        gap = math.copysign(0.01 * self._size, offset) * normal
        for point, foot in ((one, start), (two, end)):
            line = np.array([point + gap, foot + over])
            self._axes.plot(*line.T, color=DIMENSION, lw=0.5, zorder=3)
            self._lines.append(line)
        self._arrow(start, end, DIMENSION, "<|-|>", 0.8)
        angle = (math.degrees(math.atan2(along[1], along[0])) + 90) % 180 - 90
        turned = {"rotation": angle, "rotation_mode": "anchor"}
        self._write((start + end) / 2, text, 0.2, ha="center", **turned)

    def _write(self, at: Array, text: str, pad: float, **style: Any) -> None:
        """Write the text of a dimension in a white box, which is wider than the text by ``pad``."""
        box = {"boxstyle": f"round,pad={pad}", "fc": "white", "ec": "none"}
        style |= {"va": "center", "fontsize": 8.5, "color": DIMENSION, "zorder": 15, "bbox": box}
        self._texts.append(self._axes.text(*at, text, **style))

    def _slopes(self, end: Array) -> None:
        """Draw the slope of a straight deck at its lower ``end`` (2,), or write that of each segment."""
        segments: dict[float, list[Array]] = {}
        for row in self._machine.panels:
            slope_deg = math.degrees(math.asin(-float(row.panel.rectangle.along[2])))
            segments.setdefault(round(slope_deg, 2), []).append(self._view.of(row.corners_m))
        if len(segments) > 1:
            for slope_deg, parts in segments.items():
                self._wanted.append((f"{slope_deg:g}°", np.concatenate(parts).mean(axis=0), DIMENSION, 255.0))
        elif (slope_deg := next(iter(segments))) > 0:
            self._inclination(end, slope_deg)

    def _inclination(self, at: Array, inclination_deg: float) -> None:
        """Draw the angle between the deck and the horizontal at the deck's lower end."""
        radius = 0.2 * self._size
        level = np.array([at, at - [radius * 1.15, 0.0]])
        self._axes.plot(*level.T, color=DIMENSION, lw=0.6, ls=(0, (6, 3)), zorder=3)
        arc = Arc(
            _xy(at), 2 * radius, 2 * radius, theta1=180 - inclination_deg, theta2=180, color=DIMENSION, lw=0.8
        )
        self._axes.add_patch(arc)
        middle = math.radians(180 - inclination_deg / 2)
        place = at + 1.02 * radius * np.array([math.cos(middle), math.sin(middle)])
        self._write(place, f"{inclination_deg:g}°", 0.1, ha="right")
        self._lines.append(level)

    def label(self) -> None:
        """Write all labels, those of symbols first, because a symbol's label must stand near to it."""
        labels = Labels(self._axes)
        for places, radius in self._symbols:
            labels.avoid_points(places, radius)
        labels.avoid_lines(self._lines)
        for text in self._texts:
            labels.avoid_text(text)
        for text, at, color, prefer_deg in sorted(self._wanted, key=lambda row: -len(row[0])):
            labels.place(text, _xy(at), color, prefer_deg)


def _xy(at: Array) -> tuple[float, float]:
    return float(at[0]), float(at[1])


def stiffness_text(values_N_per_m: Sequence[float]) -> str:
    """Return stiffnesses with their unit: kN/m, or MN/m if the largest has 10 MN/m or more."""
    factor, unit = (1e-6, "MN/m") if float(f"{max(values_N_per_m):.4g}") >= 1e7 else (1e-3, "kN/m")
    return " / ".join(f"{factor * value:.4g}" for value in values_N_per_m) + f" {unit}"


def motions_text(motions: Mapping[str, str]) -> str:
    """Return the label of driven frames by their motions; equal motions are named once."""
    together = {1: "", 2: "both "}.get(len(motions), "all ")
    lines = [f"{name}: {motion}" for name, motion in motions.items()]
    if len({*motions.values()}) == 1:
        lines = [*motions.values()][:1]
    return "\n".join([f"{' and '.join(motions)}, {together}driven", *lines])


def convex_hull(points: Array) -> Array:
    """Return the corners (n, 2) of the convex hull of points in the plane, in order.

    Points on a line give its two ends.
    """
    from scipy.spatial import ConvexHull, QhullError

    try:
        return np.asarray(points[ConvexHull(points).vertices])
    except QhullError:
        way = np.linalg.svd(points - points.mean(axis=0))[2][0]
        along = points @ way
        return np.asarray(points[[along.argmin(), along.argmax()]])


def clipped_middle(around: Array, low: Array, high: Array) -> Array | None:
    """Return the middle (2,) of the part of a convex polygon (n, 2) in a rectangle; None without one."""
    part: Sequence[Array] = list(around)
    for axis in (0, 1):
        for limit, sign in ((low[axis], 1.0), (high[axis], -1.0)):
            kept: list[Array] = []
            for before, point in zip([part[-1], *part[:-1]], part, strict=True) if len(part) else ():
                inside, was = sign * (point[axis] - limit), sign * (before[axis] - limit)
                if (inside < 0) != (was < 0):
                    kept.append(before + was / (was - inside) * (point - before))
                if inside >= 0:
                    kept.append(point)
            part = kept
    return np.asarray(np.mean(part, axis=0)) if len(part) else None
