"""The slice: the case of a strip of the machine's width, made from the case of the whole machine.

All extensive quantities are multiplied by  share = slice width / full width: masses and inertia,
stiffness and damping of the bushings, exciters, feed rates and numbers of particles.  Panels are
cut to the slice, which gives them their share.  The frames' equations of motion are linear in all of
these quantities.  The frames of a slice therefore move exactly as the whole machine's frames if the
load does not vary across the width.  Theory: docs/theory/feed.md.
"""

from __future__ import annotations

from typing import TypeVar

import numpy as np

from orchestrator.case import solvers
from orchestrator.case.file.errors import CaseError, CaseProblem, Key
from orchestrator.case.tables.bed import Bed, Filling
from orchestrator.case.tables.case import Case
from orchestrator.case.tables.deck import Apertures, DrawnApertures
from orchestrator.case.tables.frames import Bushing, Exciter
from orchestrator.case.tables.quantities import Box
from orchestrator.case.tables.screen import PanelTable, Screen
from orchestrator.ports import Array, Indices
from orchestrator.ports.geometry import Rectangle

Filled = TypeVar("Filled", bound=Filling)
ENOUGH_DIAMETERS = 5.0  # A slice as wide as so many of the largest particles is not bridged: own choice.


def share(case: Case) -> float:
    """Return the slice's share of the whole machine's width; 1 without a slice."""
    return 1.0 if case.slice is None else case.slice.width_m / whole_width_m(case)


def whole_width_m(case: Case) -> float:
    """Return the width of all panels.  Raises CaseError if the panels do not agree."""
    low, high = full_width_m(case)
    return high - low


def full_width_m(case: Case) -> tuple[float, float]:
    """Return the lower and upper y of all panels.  Raises CaseError if the panels do not agree."""
    sides = {name: _sides_m(panel) for name, panel in case.screen.panels.items()}
    if not sides:
        raise CaseError([CaseProblem(("slice",), "there are no panels to slice", kind="missing")])
    (first, first_sides_m), *others = sides.items()
    for name, (low, high) in others:
        if abs(low - first_sides_m[0]) + abs(high - first_sides_m[1]) > 1e-6:
            there = f"panel {first} from {first_sides_m[0]:g} to {first_sides_m[1]:g}"
            what = f"goes from y = {low:g} to {high:g} m, {there}"
            hint = "a slice wants panels of the same width side by side"
            raise CaseError([CaseProblem(("screen", "panels", name, "width_m"), what, hint)])
    return first_sides_m


def bounds_m(case: Case) -> tuple[float, float]:
    """Return the lower and upper y of the slice; ``case`` is the case of the whole machine."""
    assert case.slice is not None
    middle_m = sum(full_width_m(case)) / 2.0
    return middle_m - case.slice.width_m / 2.0, middle_m + case.slice.width_m / 2.0


def is_beside(box_m: Box, y_m: tuple[float, float]) -> bool:
    """Return whether a box lies wholly beside the slice between ``y_m``."""
    return box_m[1][1] <= y_m[0] or y_m[1] <= box_m[0][1]


def period_m(case: Case) -> float:
    """Return the distance after which a slice with periodic sides repeats itself along y; 0 without them."""
    return case.slice.width_m if case.slice is not None and case.slice.sides == "periodic" else 0.0


WIDE = 2.0  # widths over lengths from which panels of a slice have joined sides (docs/measured/feed.md)
WIDTHS_OVER_LENGTHS = 0.0, 0.33, 0.67, 1.0, 1.33, 2.0, 2.67, 4.0, 8.0
# pull of sheets with free sides of these widths, over that of narrow ones: measured, as above
STIFFENING = 1.0, 1.023, 1.046, 1.072, 1.099, 1.150, 1.189, 1.236, 1.287
PURE_SHEAR = 4 / 3  # the stiffness of a sheet that cannot contract across, over that of a narrow one


def joins_sides(case: Case, length_m: float) -> bool:
    """Return whether both sides of a panel of the slice move alike, as its free length is ``length_m``.

    They do where sides are periodic and the whole panel is so wide that its middle hardly contracts across.
    """
    if not period_m(case) or case.slice is None:
        return False
    width_m = whole_width_m(case.whole_machine)
    return case.slice.width_m < width_m * (1 - 1e-9) and width_m >= WIDE * length_m


def hindered_share(case: Case, panel: Rectangle) -> float:
    """Return how much of its contraction across the clamps of a panel hinder, from 0 to 1.

    With it, a panel in which nothing varies across pulls as the whole machine's does, in a slice, too.
    """
    width_m = panel.width_m if case.slice is None else whole_width_m(case.whole_machine)
    return hindered_share_of(width_m / panel.length_m)


def hindered_share_of(width_over_length: float) -> float:
    """Return the share of its contraction across that the clamps of a panel with free sides hinder."""
    return float(np.interp(width_over_length, WIDTHS_OVER_LENGTHS, STIFFENING) - 1) / (PURE_SHEAR - 1)


def stretched_stiffness_error(case: Case, length_m: float, joined: bool) -> float:
    """Return how much stiffer the slice's part of a sheet is in stretch than that of the whole sheet.

    The sheet has a free length of ``length_m``; negative is softer.  Openings make it less.
    """
    assert case.slice is not None
    widths_m = np.array([case.slice.width_m, whole_width_m(case.whole_machine)])
    part, whole = np.interp(widths_m / length_m, WIDTHS_OVER_LENGTHS, STIFFENING)
    return float((PURE_SHEAR if joined else part) / whole - 1)


def cut_surface(case: Case, position_m: Array, triangles: Indices) -> tuple[Array, Indices]:
    """Cut a rigid surface, points (n, 3) and triangles (m, 3), to the slice of a case.

    Returns the surface unchanged without a slice.  Walls beside a slice with walls are moved to its sides.
    """
    if case.slice is None or case.whole_machine is case:
        return position_m, triangles
    beside_m = whole_width_m(case.whole_machine) - case.slice.width_m
    move_in_m = beside_m / 2.0 if case.slice.sides == "walls" else None
    return cut_triangles(position_m, triangles, bounds_m(case.whole_machine), move_in_m)


def cut_to_slice(case: Case) -> Case:
    """Return the case of the slice; a case without a slice is returned unchanged.

    Raises CaseError with every reason why the slice makes no sense.
    """
    if case.slice is None:
        return case
    if problems := _problems(case):
        raise CaseError(problems)
    y_m, part = bounds_m(case), share(case)
    periodic = case.slice.sides == "periodic"
    return case.cut_to(
        {
            "screen": _cut_screen(case.screen, part, y_m),
            "bed": _cut_bed(case.bed, part, y_m),
            "domain_m": _box_between(case.domain_m, y_m) if periodic else case.domain_m,
        }
    )


def _problems(case: Case) -> list[CaseProblem]:
    """Return every reason why the slice of a case makes no sense."""
    assert case.slice is not None
    problems = []
    for name, panel in case.screen.panels.items():
        if abs(panel.across[0]) + abs(panel.across[2]) > 1e-9:
            key: Key = ("screen", "panels", name, "across")
            problems.append(CaseProblem(key, "a slice wants panels that run across along y"))
    if problems:
        return problems
    if case.slice.width_m > (whole_m := whole_width_m(case)) * (1 + 1e-9):
        what = f"{case.slice.width_m:g} m is wider than the machine's {whole_m:g} m"
        problems.append(CaseProblem(("slice", "width_m"), what, kind="out-of-range"))
        return problems
    y_m = bounds_m(case)
    for kind, rows in (("blocks", case.bed.blocks), ("feeds", case.bed.feeds)):
        for name, row in rows.items():
            if is_beside(row.box_m, y_m):
                what = f"does not reach into the slice from y = {y_m[0]:g} to {y_m[1]:g} m"
                problems.append(CaseProblem(("bed", kind, name, "box_m"), what, kind="misplaced"))
    for name, particle in case.bed.particles.items():
        if not y_m[0] <= particle.position_m[1] < y_m[1]:
            key = ("bed", "particles", name, "position_m")
            problems.append(
                CaseProblem(key, f"is not in the slice from y = {y_m[0]:g} to {y_m[1]:g} m", kind="misplaced")
            )
    return problems + _through_openings(case) + _in_periodic(case)


def _through_openings(case: Case) -> list[CaseProblem]:
    """Return a problem if the slice would cut openings, or lie partly in the strips without openings."""
    assert case.slice is not None
    width_m = case.slice.width_m
    for name, panel in case.screen.panels.items():
        openings = panel.apertures
        if openings is None:
            continue
        if isinstance(openings, DrawnApertures):
            what = f"the openings of panel {name} come from a drawing, which is not cut"
            return [CaseProblem(("slice",), what, "leave the slice out, or give a pattern of openings")]
        pitch_m, most = openings.pitch_across_m, _openings_across(panel, openings)
        pitches = width_m / pitch_m
        if abs(pitches - round(pitches)) > 1e-6 or pitches > most + 1e-6:
            what = f"{width_m:g} m is {pitches:.6g} pitches of the openings of panel {name}"
            fitting = max(min(round(pitches), most), 1)
            hint = f"take a whole number of at most {most}: {fitting * pitch_m:g} m is {fitting}"
            return [CaseProblem(("slice", "width_m"), what, hint)]
    return []


def between_openings_m(case: Case, width_m: float) -> float:
    """Return the width nearest to ``width_m`` of a slice that cuts no opening of the panels' first kind.

    ``case`` is that of the whole machine.
    """
    for panel in case.screen.panels.values():
        if isinstance(openings := panel.apertures, Apertures):
            pitch_m, most = openings.pitch_across_m, _openings_across(panel, openings)
            return max(min(round(width_m / pitch_m), most), 1) * pitch_m
    return width_m


def _openings_across(panel: PanelTable, openings: Apertures) -> int:
    """Return how many openings lie side by side between a panel's margins."""
    return int((panel.width_m - 2 * openings.margin_across_m) / openings.pitch_across_m + 1e-6)


def _in_periodic(case: Case) -> list[CaseProblem]:
    """Return the problems of periodic sides: a solver that does not have them, and gravity along y."""
    assert case.slice is not None
    if case.slice.sides == "walls":
        return []
    problems = []
    particles = case.particles.adapter
    if particles is not None and not particles.periodic and (case.bed.particles or case.bed.sources):
        others = solvers.names_able_to("particles", lambda able: able.periodic)
        what = f"particles.solver {case.particles.solver} has no periodic sides"
        hint = f'take "walls", or particles.solver = {others}'
        problems.append(CaseProblem(("slice", "sides"), what, hint, kind="solver"))
    if case.gravity_m_per_s2[1] != 0:
        what, hint = "acts along y, across the periodic sides", 'set its y to 0, or slice.sides = "walls"'
        problems.append(CaseProblem(("gravity_m_per_s2",), what, hint))
    return problems


def _sides_m(panel: PanelTable) -> tuple[float, float]:
    near_m = panel.corner_m[1]
    far_m = near_m + (panel.width_m if panel.across[1] > 0 else -panel.width_m)
    return min(near_m, far_m), max(near_m, far_m)


def _cut_screen(screen: Screen, part: float, y_m: tuple[float, float]) -> Screen:
    """Return the screen with cut panels, and with ``part`` of its frames, bushings and exciters."""
    inertia = ("mass_kg", "inertia_kg_m2", "products_of_inertia_kg_m2")
    return screen.model_copy(
        update={
            "frames": {name: row.times(part, *inertia) for name, row in screen.frames.items()},
            "bushings": {name: _bushing(row, part) for name, row in screen.bushings.items()},
            "exciters": {name: _exciter(row, part) for name, row in screen.exciters.items()},
            "panels": {name: _panel(row, y_m) for name, row in screen.panels.items()},
        }
    )


def _bushing(row: Bushing, part: float) -> Bushing:
    """Return a bushing with ``part`` of its stiffness and damping, and of the forces in its curves and
    characteristics."""
    spring = ("stiffness_N_per_m", "damping_N_s_per_m")
    curves = [
        curve.times(part, "elastic_N_per_m").model_copy(
            update={
                "points": tuple(point.times(part, *spring) for point in curve.points),
                "friction": tuple(element.times(part, spring[0]) for element in curve.friction),
                "maxwell": tuple(element.times(part, spring[0]) for element in curve.maxwell),
            }
        )
        for curve in row.curves
    ]
    update = {
        "curves": tuple(curves),
        "characteristics": tuple(each.times(part, "force_N") for each in row.characteristics),
    }
    return row.times(part, *spring).model_copy(update=update)


def _exciter(row: Exciter, part: float) -> Exciter:
    """Return an exciter with ``part`` of its unbalance, of its motor and of its bearings' rating."""
    motor, bearings = row.motor, row.bearings
    if motor is not None:
        motor = motor.times(part, "rated_power_W", "moment_of_inertia_kg_m2", "bearing_loss_N_m_s")
    if bearings is not None:
        bearings = bearings.times(part, "dynamic_rating_N")
    return row.times(part, "mass_moment_kg_m").model_copy(update={"motor": motor, "bearings": bearings})


def _panel(row: PanelTable, y_m: tuple[float, float]) -> PanelTable:
    """Return the part of a panel between ``y_m``, perforated from side to side.

    It counts as solid across in the same share of its width as the whole panel, so that it is as stiff and
    as heavy as its part of that.
    """
    x, _, z = row.corner_m
    corner_m = (x, y_m[0] if row.across[1] > 0 else y_m[1], z)
    update: dict[str, object] = {"corner_m": corner_m, "width_m": y_m[1] - y_m[0]}
    if isinstance(row.apertures, Apertures):
        perforated_m = _openings_across(row, row.apertures) * row.apertures.pitch_across_m
        perforated = (1.0 - row.apertures.margin_share) * perforated_m / row.width_m
        openings = {"margin_across_m": 0.0, "margin_share": max(1.0 - perforated, 0.0)}
        update["apertures"] = row.apertures.model_copy(update=openings)
    return row.model_copy(update=update)


def _cut_bed(bed: Bed, part: float, y_m: tuple[float, float]) -> Bed:
    """Return the bed with cut boxes and ``part`` of its feeds and particles; a block keeps at least one."""
    blocks = {
        name: _cut_box(row, y_m).model_copy(update={"count": max(1, round(part * row.count))})
        for name, row in bed.blocks.items()
    }
    feeds = {name: _cut_box(row, y_m).times(part, "rate_kg_per_s") for name, row in bed.feeds.items()}
    return bed.model_copy(update={"blocks": blocks, "feeds": feeds})


def _cut_box(row: Filled, y_m: tuple[float, float]) -> Filled:
    """Return a block or feed with its box cut to the part between ``y_m``."""
    return row.model_copy(update={"box_m": _box_between(row.box_m, y_m)})


def _box_between(box_m: Box, y_m: tuple[float, float]) -> Box:
    """Return the part of a box between ``y_m``."""
    (x0, y0, z0), (x1, y1, z1) = box_m
    return (x0, max(y0, y_m[0]), z0), (x1, min(y1, y_m[1]), z1)


SAME_PLACE_M = 1e-9  # Corners that are closer than this are one corner.


def cut_triangles(
    position_m: Array, triangles: Indices, y_m: tuple[float, float], move_in_m: float | None
) -> tuple[Array, Indices]:
    """Return points (n, 3) and triangles (m, 3) of the part of a surface between ``y_m``.

    Triangles that lie completely outside, or in the plane of a side, are moved in by ``move_in_m``;
    None leaves them out.  The points may be in deck axes or in world axes, because y is the same.
    """
    low, high = y_m
    parts: list[Array] = []
    for corners_m in position_m[triangles]:
        first, last = corners_m[:, 1].min(), corners_m[:, 1].max()
        if last <= low + SAME_PLACE_M or first >= high - SAME_PLACE_M:
            if move_in_m is not None:
                inwards_m = move_in_m if last <= low + SAME_PLACE_M else -move_in_m
                parts.append(corners_m + np.array([0.0, inwards_m, 0.0]))
            continue
        polygon = _clip(_clip(corners_m, low, 1.0), high, -1.0)
        parts += [polygon[[0, k, k + 1]] for k in range(1, len(polygon) - 1)]
    return _weld(np.array(parts).reshape(-1, 3, 3))


def _clip(polygon_m: Array, limit_m: float, sign: float) -> Array:
    """Return the part of a convex polygon (n, 3) on one side of the plane y = limit.

    ``sign`` is 1 for the side of larger y, and -1 for the other side.  Sutherland, I. E. and
    Hodgman, G. W., Communications of the ACM 17, 1974, 32-42, doi 10.1145/360767.360802.
    """
    inside_m = sign * (polygon_m[:, 1] - limit_m)
    corners_m = []
    for k in range(len(polygon_m)):
        before = k - 1
        if (inside_m[before] < 0) != (inside_m[k] < 0):
            along = inside_m[before] / (inside_m[before] - inside_m[k])
            crossing_m = polygon_m[before] + along * (polygon_m[k] - polygon_m[before])
            crossing_m[1] = limit_m
            corners_m.append(crossing_m)
        if inside_m[k] >= 0:
            corners_m.append(polygon_m[k])
    return np.array(corners_m)


def _weld(corners_m: Array) -> tuple[Array, Indices]:
    """Return points (n, 3) and triangles (m, 3) of triangles' corners (m, 3, 3).

    Equal corners become one point; triangles that shrank to a line are left out.
    """
    flat_m = corners_m.reshape(-1, 3)
    _, first, number = np.unique(
        np.round(flat_m / SAME_PLACE_M), axis=0, return_index=True, return_inverse=True
    )
    triangles = number.reshape(-1, 3).astype(np.int64)
    a, b, c = triangles.T
    return flat_m[first], triangles[(a != b) & (b != c) & (c != a)]
