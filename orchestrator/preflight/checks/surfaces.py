"""The checks of places at t = 0: parts in the domain and apart from each other, particles clear of all."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from itertools import product
from pathlib import Path
from types import MappingProxyType
from typing import Literal

import numpy as np
import numpy.typing as npt

from orchestrator.case.bed.push_out import SETTLED, overlapping_pairs
from orchestrator.case.bed.sources import NoRoom, initial_particles, inlets
from orchestrator.case.deck.openings import half_depths_m
from orchestrator.case.deck.panels import axes, plate_corners_m, single_panels, to_world, walls
from orchestrator.case.deck.stl import UnreadableSurface
from orchestrator.case.deck.surface_file import read_surface
from orchestrator.case.deck.triangle_grid import TriangleGrid, grid, surface_grids
from orchestrator.case.file.errors import CaseProblem, Key
from orchestrator.case.file.slice import bounds_m, period_m
from orchestrator.case.tables.case import Case
from orchestrator.ports import Array, Indices
from orchestrator.ports.geometry import Rectangle, TriangleSurface, distinct_edges, overlap_m, reach_into
from orchestrator.ports.grains import placed_spheres
from orchestrator.ports.penetration import IN_PLANE, Penetrations
from orchestrator.ports.plans import ParticleList
from orchestrator.preflight.checks.names import rows
from orchestrator.preflight.scene.flight import intersect

ENLARGE = "enlarge domain_m"
LEAVE_OUT = 'bed.outside = "leave-out" leaves them out'
THINNEST = 1e-6  # area of a plate over its longest edge squared: thinner ones have no normal to rounding


def surface_files(case: Case, folder: Path) -> Iterator[CaseProblem]:
    """Check that files of ``[screen.surfaces]`` can be read and are in the domain."""
    for row, surface in rows(case, "screen.surfaces"):
        file = surface.file if surface.file is not None else surface.stl
        if file is None:
            continue
        key = (*row, "file" if surface.file is not None else "stl")
        try:
            healed = read_surface(surface, folder)
        except UnreadableSurface as error:
            yield CaseProblem(key, f'"{file}": {error}', kind="file")
            continue
        position_m = to_world(case, healed.position_m)
        if outside := _outside(case, position_m):
            millimetres = np.ptp(position_m, axis=0).max() > 50
            hint = 'is it in mm? give unit = "mm"' if millimetres else ENLARGE
            yield CaseProblem(key, f'"{file}": {outside}', hint, kind="misplaced")


def plates(case: Case) -> Iterator[CaseProblem]:
    """Check that each surface is either one file or a plate, and that plates have an area."""
    for key, surface in rows(case, "screen.surfaces"):
        given = [surface.corner_m is not None, surface.edges_m is not None]
        files = [name for name in (surface.file, surface.stl) if name is not None]
        of_files = ("unit", "scale", "rotation_deg", "move_m", "tolerance_m")
        if len(files) == 2:
            yield CaseProblem(key, "names two files", "give file or stl, not both")
        elif files and any(given):
            yield CaseProblem(key, "is given as a file and as a plate", "give file, or corner_m and edges_m")
        elif not files and not all(given):
            yield CaseProblem(key, "has no geometry", "give file, or corner_m and edges_m", kind="missing")
        elif not files and (told := [name for name in of_files if getattr(surface, name) is not None]):
            yield CaseProblem((*key, told[0]), "is for files, and this is a plate", "leave it out")
        elif surface.edges_m is not None:
            longest_m = max(math.hypot(*edge) for edge in surface.edges_m)
            one, two = np.array(surface.edges_m) / (longest_m or 1.0)
            if not np.linalg.norm(np.cross(one, two)) > THINNEST:
                yield CaseProblem(
                    (*key, "edges_m"),
                    "are parallel or zero",
                    "give two edges at an angle",
                    kind="out-of-range",
                )


def panels_inside(case: Case) -> Iterator[CaseProblem]:
    """Check that panels and plates have their corners inside the domain."""
    for key, surface in rows(case, "screen.surfaces"):
        if surface.edges_m is None:
            continue
        if outside := _outside(case, to_world(case, plate_corners_m(surface))):
            yield CaseProblem((*key, "corner_m"), f"surface {key[-1]}: {outside}", ENLARGE, kind="misplaced")
    for panel in single_panels(case):
        if outside := _outside(case, panel.rectangle.corners_m(panel.rectangle.clamp_m)):
            panel_key: Key = ("screen", "panels", panel.table_name, "corner_m")
            yield CaseProblem(panel_key, f"panel {panel.name}: {outside}", ENLARGE, kind="misplaced")


HALVES = np.array([[0, 1, 2], [0, 2, 3]])  # triangles of the four corners of a rectangle
ROUNDED_M = 1e-4  # Parts may overlap by this much, since places are often given in tenths of a mm.


def parts_in_one_place(case: Case) -> Iterator[CaseProblem]:
    """Check that no panel lies in the place of another one or crosses it, and that no plate lies in the plane
    of a panel, on its free length.

    A plate through a panel is taken as meant; in a panel's plane, nothing tells on which side the panel is.
    """
    panels = single_panels(case)
    outlines_m = np.array([r.corners_m(r.clamp_m)[HALVES] for r in (panel.rectangle for panel in panels)])
    outlines_m = outlines_m.reshape(-1, 3, 3)
    for number, one in enumerate(panels):
        clamp_m, half_m = one.rectangle.clamp_m, one.table.thickness_m / 2
        met = _reach_into_panel(one.rectangle, outlines_m[2 * number + 2 :], clamp_m, half_m)
        for two in (panels[number + 1 + other] for other in np.unique(np.flatnonzero(met) // 2)):
            panel_key: Key = ("screen", "panels", two.table_name, "corner_m")
            what = f"panel {two.name} lies in the place of panel {one.name}, or crosses it"
            yield CaseProblem(panel_key, what, "take one of them away, or move it", kind="misplaced")
    surfaces = [row for row in rows(case, "screen.surfaces") if row[1].edges_m is not None]
    for (key, surface), panel in product(surfaces, panels):
        corners_m, at = to_world(case, plate_corners_m(surface)), panel.rectangle
        height_m = IN_PLANE * panel.table.thickness_m
        in_plane = (np.abs((corners_m - at.corner_m) @ at.normal) <= height_m).all()
        if in_plane and _reach_into_panel(at, corners_m[HALVES], 0.0, height_m).any():
            what = f"surface {key[-1]} lies in the plane of panel {panel.name} and overlaps it"
            yield CaseProblem((*key, "corner_m"), what, "move it above or below the panel", kind="misplaced")


def _reach_into_panel(
    r: Rectangle, corners_m: Array, clamp_m: float, height_m: float
) -> npt.NDArray[np.bool_]:
    """Tell which (m,) of the triangles (m, 3, 3) reach nearer than ``height_m`` to a panel's free length, and
    to a ``clamp_m`` beyond its ends."""
    low_m = np.array([ROUNDED_M - clamp_m, ROUNDED_M, -height_m])
    high_m = np.array([r.span_m + clamp_m - ROUNDED_M, r.width_m - ROUNDED_M, height_m])
    in_panel_m = (corners_m - r.corner_m) @ np.column_stack([r.along, r.across, r.normal])
    return reach_into(in_panel_m, np.stack([low_m, high_m]))


def _outside(case: Case, position_m: Array) -> str:
    """Return a text about how far points reach out of the domain; empty if all are inside."""
    low, high = np.array(case.domain_m)
    beyond = np.maximum(low - position_m, position_m - high).max(axis=0)
    if beyond.max() <= 0:
        return ""
    axis = int(beyond.argmax())
    return f"reaches {beyond[axis]:.4g} m out of domain_m along {'xyz'[axis]}"


ALLOWED = 1e-6  # overlap over diameter that counts as touching


def particles_at_start(case: Case, folder: Path) -> Iterator[CaseProblem]:
    """Check that particles are inside the domain and outside of closed bodies, apart from each other, and
    clear of surfaces.

    ``hanging_panels`` checks slack panels, because only their solvers know how they hang.
    """
    try:
        particles = initial_particles(case)
    except NoRoom as full:
        yield CaseProblem(("bed", "blocks", full.block, "count"), str(full), kind="misplaced")
        return
    if len(particles) == 0:
        return
    low, high = np.array(case.whole_machine.domain_m)
    beyond = ((particles.position_m < low) | (particles.position_m > high)).any(axis=1)
    outside = np.flatnonzero(beyond)
    if len(outside):
        key, name = _describe_particle(case, outside[0])
        place = np.round(particles.position_m[outside[0]], 4).tolist()
        hint = LEAVE_OUT if case.bed.carried is not None else ""
        yield CaseProblem(
            key, f"{name} at {place} is outside domain_m{_count_of_others(outside)}", hint, kind="misplaced"
        )
    placed = ~beyond & _in_slice(case, particles)
    if beside := len(particles) - len(outside) - int(placed.sum()):
        assert case.bed.carried is not None  # others are placed in the slice
        first_m, last_m = bounds_m(case.whole_machine)
        what = f"{beside} particles of {case.bed.carried.source} are not in the slice"
        key = _describe_particle(case, int(np.argmin(placed)))[0]
        yield CaseProblem(key, f"{what} from y = {first_m:g} to {last_m:g} m", LEAVE_OUT, kind="misplaced")
    yield from closed_bodies(case, particles, folder)
    if case.bed.carried is not None and case.bed.push_out:  # pushed before the start, and checked then
        return
    yield from _overlapping(case, particles, placed)
    half_m = max(half_depths_m(case), default=0.0)
    if any(
        any(_in_surface(case, particles, *surface, placed, half_m)) for surface in _surfaces(case, folder)
    ):
        # particles may sit in openings, the meshing of which takes a while
        grids = surface_grids(case)
        for surface in _surfaces(case, folder, grids):
            yield from _in_surface(case, particles, *surface, placed)
        yield from _in_material(case, particles, grids, placed)


def _in_material(
    case: Case, particles: ParticleList, grids: Mapping[str, TriangleGrid], placed: npt.NDArray[np.bool_]
) -> Iterator[CaseProblem]:
    """Check that no ``placed`` particle's centre is between the sides of a taut panel with a depth."""
    for panel, half_m in zip(single_panels(case), half_depths_m(case), strict=True):
        at, made = panel.rectangle, grids[panel.name]
        if made.side is None or at.span_m < at.length_m:
            continue
        near = np.flatnonzero((np.abs((particles.position_m - at.corner_m) @ at.normal) < half_m) & placed)
        corners_m = at.mounted(made.coordinates_m)[made.triangles]
        inside = [row for row in near if _times_met(particles.position_m[row], corners_m) % 2]
        if inside:
            key, name = _describe_particle(case, inside[0])
            what = f"{name} is inside the material of panel {panel.name}{_count_of_others(np.array(inside))}"
            yield CaseProblem(key, what, _how_to_make_room(case), kind="misplaced")


def _in_slice(case: Case, particles: ParticleList) -> npt.NDArray[np.bool_]:
    """Return for each particle whether its centre is between the sides of the slice; true without one."""
    if case.slice is None:
        return np.ones(len(particles), dtype=bool)
    first_m, last_m = bounds_m(case.whole_machine)
    y_m = particles.position_m[:, 1]
    return np.asarray((y_m >= first_m) & (y_m <= last_m))


def feeds_at_start(case: Case, folder: Path) -> Iterator[CaseProblem]:
    """Check that no surface reaches into the box of a feed, where particles would appear inside it."""
    for name, corners_m in _surfaces(case, folder) if case.bed.feeds else ():
        yield from _in_feed_box(case, name, corners_m)


def surface_penetrations(
    case: Case, penetrations: Penetrations, surface: TriangleSurface
) -> Iterator[CaseProblem]:
    """Check that no panel hangs through another surface so far that the monitor would stop the run."""
    deepest = penetrations.deepest(surface.position_m)
    if deepest is None or case.monitor.penetrated_surfaces != "stop":
        return
    if deepest.thicknesses > case.monitor.largest_penetration:
        tables = {panel.name: panel.table_name for panel in single_panels(case)}
        through = f"{deepest.depth_m:.3g} m through {deepest.surface}"
        what = f"panel {deepest.panel} hangs {through} before anything moves"
        hint = "tighten it, move one of them, or give the panel a stop where it is to lie"
        yield CaseProblem(("screen", "panels", tables[deepest.panel]), what, hint, kind="misplaced")


def hanging_panels(
    case: Case, surface: TriangleSurface, panel_of_triangle: Indices, particles: ParticleList
) -> Iterator[CaseProblem]:
    """Check that no panel at rest reaches into particles or into boxes of feeds, and no slack one into exits.

    Check as well that particles that were pushed out have found room.
    """
    corners_m = surface.corners_m
    for number, panel in enumerate(single_panels(case)):
        at_rest = f"panel {panel.name} as it hangs at rest"
        own_m = corners_m[panel_of_triangle == number]
        yield from _in_surface(case, particles, at_rest, own_m)
        yield from _in_feed_box(case, at_rest, own_m)
        if panel.rectangle.span_m < panel.rectangle.length_m:
            yield from _in_exit_box(case, at_rest, own_m)
    if case.bed.carried is not None and case.bed.push_out:
        yield from _overlapping(case, particles)
        yield from _in_surface(case, particles, "a rigid surface", corners_m[panel_of_triangle < 0])


def _in_surface(
    case: Case,
    particles: ParticleList,
    surface: str,
    corners_m: Array,
    placed: npt.NDArray[np.bool_] | Literal[True] = True,
    beside_m: float = 0.0,
) -> Iterator[CaseProblem]:
    """Check that no sphere of a ``placed`` particle reaches into the triangles (m, 3, 3), or nearer to them
    than ``beside_m``."""
    of, center_m, radius_m = placed_spheres(particles.grains, particles.position_m, particles.orientation)
    depth_m = overlap_m(center_m, radius_m + beside_m, corners_m)
    there = True if placed is True else placed[of]
    inside = np.flatnonzero((depth_m > allowed_overlap(case) * 2 * radius_m) & there)
    if len(inside):
        deepest = inside[np.argmax(depth_m[inside])]
        key, name = _describe_particle(case, int(of[deepest]))
        yield CaseProblem(
            key,
            f"{name} is {depth_m[deepest]:.3g} m inside {surface}{_count_of_others(np.unique(of[inside]))}",
            _how_to_make_room(case),
            kind="misplaced",
        )


def _in_feed_box(case: Case, surface: str, corners_m: Array) -> Iterator[CaseProblem]:
    """Check that none of the triangles (m, 3, 3) reaches into the box of a feed."""
    for feed, inlet in inlets(case).items():
        low, high = inlet.box_m
        rim_m = ALLOWED * (high - low)  # a box may stand against a wall
        if reach_into(corners_m @ inlet.axes, np.stack([low + rim_m, high - rim_m])).any():
            yield CaseProblem(("bed", "feeds", feed, "box_m"), f"{surface} reaches into it", kind="misplaced")


def _in_exit_box(case: Case, name: str, corners_m: Array) -> Iterator[CaseProblem]:
    """Check that none of the triangles (m, 3, 3) reaches into the box of an exit."""
    for exit_, row in case.screen.exits.items():
        low, high = np.array(row.box_m)
        rim_m = ALLOWED * (high - low)
        if reach_into(corners_m @ axes(case), np.stack([low + rim_m, high - rim_m])).any():
            hint = "move the box away from it: particles on the panel would be taken for what has left it"
            yield CaseProblem(
                ("screen", "exits", exit_, "box_m"), f"{name} reaches into it", hint, kind="misplaced"
            )


def closed_bodies(case: Case, particles: ParticleList, folder: Path) -> Iterator[CaseProblem]:
    """Check that no particle's centre is inside a rigid surface, or a part of one, that is a closed body.

    A ray from inside goes through closed bodies an odd number of times.
    """
    for wall in walls(case, folder):
        corners_m = wall.position_m[wall.triangles[_in_closed_parts(wall.triangles)]]
        if len(corners_m) == 0:
            continue
        low, high = corners_m.min(axis=(0, 1)), corners_m.max(axis=(0, 1))
        near = np.flatnonzero(((particles.position_m > low) & (particles.position_m < high)).all(axis=1))
        inside = [row for row in near if _times_met(particles.position_m[row], corners_m) % 2]
        if inside:
            key, name = _describe_particle(case, inside[0])
            place = np.round(particles.position_m[inside[0]], 4).tolist()
            what = f"{name} at {place} is inside surface {wall.name}, a closed body"
            hint = "move it out; a housing around particles needs an open side"
            yield CaseProblem(key, f"{what}{_count_of_others(np.array(inside))}", hint, kind="misplaced")


RAY = np.array([0.5347, 0.2718, 0.8001])  # along no edge or face that a machine is likely to have


def _in_closed_parts(triangles: Indices) -> npt.NDArray[np.bool_]:
    """Tell which (m,) of the triangles (m, 3) belong to connected parts whose edges have two of them each."""
    # these imports take long, and few scenes have closed bodies
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    edges, number, sharing = distinct_edges(triangles)
    size = int(triangles.max()) + 1
    graph = coo_array((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), shape=(size, size))
    parts, part_of_corner = connected_components(graph, directed=False)
    part = part_of_corner[triangles[:, 0]]
    is_closed = np.ones(parts, dtype=np.bool_)
    is_closed[part[np.flatnonzero(sharing[number] != 2) // 3]] = False
    return np.asarray(is_closed[part])


def _times_met(place_m: Array, corners_m: Array) -> int:
    """Return how many triangles (m, 3, 3) a ray from a place (3,) between them goes through."""
    beyond_m = np.ptp(corners_m, axis=(0, 1)).max() / RAY.min() * RAY
    return int(np.isfinite(intersect(place_m[None], beyond_m[None], corners_m)).sum())


def _surfaces(
    case: Case, folder: Path, grids: Mapping[str, TriangleGrid] = MappingProxyType({})
) -> Iterator[tuple[str, Array]]:
    """Yield the names and the triangles (m, 3, 3), in world axes, of taut panels and rigid surfaces.

    Taut panels are straight between their clamps, and have no openings unless ``grids`` has theirs.
    """
    for panel in single_panels(case):
        if panel.rectangle.span_m >= panel.rectangle.length_m:
            flat = grids.get(panel.name) or grid(panel.rectangle, (1, 1))
            yield f"panel {panel.name}", panel.rectangle.mounted(flat.coordinates_m)[flat.triangles]
    for wall in walls(case, folder):
        yield f"surface {wall.name}", wall.position_m[wall.triangles]


def _overlapping(
    case: Case, particles: ParticleList, placed: npt.NDArray[np.bool_] | None = None
) -> Iterator[CaseProblem]:
    """Check that no two particles, both of them ``placed``, overlap by more than ``allowed_overlap``."""
    of, center_m, radius_m = placed_spheres(particles.grains, particles.position_m, particles.orientation)
    first, second, depth_m = overlapping_pairs(center_m, radius_m, period_m(case))
    deep = depth_m > allowed_overlap(case) * 2 * np.minimum(radius_m[first], radius_m[second])
    one, two = of[first], of[second]
    deep &= one != two
    pairs = np.flatnonzero(deep if placed is None else deep & placed[one] & placed[two])
    if len(pairs):
        deepest = pairs[np.argmax(depth_m[pairs])]
        key, name = _describe_particle(case, one[deepest])
        other = _describe_particle(case, two[deepest])[1]
        what = f"{name} overlaps {other} by {depth_m[deepest]:.3g} m{_count_of_others(pairs)}"
        yield CaseProblem(key, what, _how_to_make_room(case), kind="misplaced")


def allowed_overlap(case: Case) -> float:
    """Return the overlap over a diameter that particles may have at t = 0; settled ones touch each other."""
    return SETTLED if case.bed.carried is not None else ALLOWED


def _how_to_make_room(case: Case) -> str:
    """Return a hint for carried particles that do not fit; empty for others."""
    if case.bed.carried is None:
        return ""
    if case.bed.push_out:
        return f"there is no room to push it out to {SETTLED:g} of its diameter"
    return f"up to {SETTLED:g} of the diameter is allowed; bed.push_out = true makes room"


def _count_of_others(numbers: Indices) -> str:
    return f" ({len(numbers) - 1} more)" if len(numbers) > 1 else ""


def _describe_particle(case: Case, number: int) -> tuple[Key, str]:
    """Return the key that places particle ``number`` (from 0), and the particle's name for messages."""
    singles = list(case.bed.particles)
    if number < len(singles):
        return ("bed", "particles", singles[number], "position_m"), f'"{singles[number]}"'
    first = len(singles)
    for name, block in case.bed.blocks.items():
        first += block.count
        if number < first:
            return ("bed", "blocks", name, "box_m"), f"particle {number + 1}"
    if case.bed.carried is not None:
        key = "from_run" if case.bed.from_run is not None else "table"
        return ("bed", key), f"particle {number + 1}"
    raise AssertionError(f"there is no particle {number + 1}")
