"""Particles and feeds at t = 0: inside the domain, clear of each other and of every surface."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from orchestrator.case.bed.sources import NoRoom, initial_particles, inlets
from orchestrator.case.deck.panels import single_panels, walls
from orchestrator.case.deck.triangle_grid import grid
from orchestrator.case.file.errors import CaseProblem, Key
from orchestrator.case.solver_plans import material_numbers
from orchestrator.case.tables.case import Case
from orchestrator.ports import Array, Indices
from orchestrator.ports.geometry import TriangleSurface, overlap_m, reach_into
from orchestrator.ports.penetration import Penetrations
from orchestrator.ports.plans import ParticleList

ALLOWED = 1e-6  # overlap over diameter that counts as touching


def particles_at_start(case: Case, folder: Path) -> Iterator[CaseProblem]:
    """Slack panels are looked at in ``at_rest``: how they hang only their solvers know."""
    try:
        particles = initial_particles(case, material_numbers(case))
    except NoRoom as full:
        yield CaseProblem(("bed", "blocks", full.block, "count"), str(full))
        return
    if len(particles) == 0:
        return
    yield from _outside(case, particles)
    yield from _overlapping(case, particles)
    for name, corners_m in _surfaces(case, folder):
        yield from in_surface(case, particles, name, corners_m)


def feeds_at_start(case: Case, folder: Path) -> Iterator[CaseProblem]:
    """Feed boxes that a surface reaches into: what appeared there would be inside it."""
    for name, corners_m in _surfaces(case, folder) if case.bed.feeds else ():
        yield from in_feed_box(case, name, corners_m)


def in_surface(case: Case, particles: ParticleList, surface: str, corners_m: Array) -> Iterator[CaseProblem]:
    """Particles whose centres are nearer to the triangles (m, 3, 3) than their radius."""
    depth_m = overlap_m(particles.position_m, particles.diameter_m / 2, corners_m)
    found = np.flatnonzero(depth_m > ALLOWED * particles.diameter_m)
    if len(found):
        deepest = found[np.argmax(depth_m[found])]
        key, name = _named(case, deepest)
        yield CaseProblem(key, f"{name} is {depth_m[deepest]:.3g} m inside {surface}{_more(found)}")


def in_feed_box(case: Case, surface: str, corners_m: Array) -> Iterator[CaseProblem]:
    """Feed boxes into which one of the triangles (m, 3, 3) reaches."""
    for feed, inlet in inlets(case, material_numbers(case)).items():
        low, high = inlet.box_m
        rim_m = ALLOWED * (high - low)  # a box may stand against a wall
        if reach_into(corners_m @ inlet.axes, np.stack([low + rim_m, high - rim_m])).any():
            yield CaseProblem(("bed", "feeds", feed, "box_m"), f"{surface} reaches into it")


def _surfaces(case: Case, folder: Path) -> Iterator[tuple[str, Array]]:
    """Panels that are not slack, straight between their clamps, and rigid surfaces: by name, their
    triangles (m, 3, 3) in the world."""
    for panel in single_panels(case):
        if panel.rectangle.span_m >= panel.rectangle.length_m:
            flat = grid(panel.rectangle, (1, 1))
            mounted_m = panel.rectangle.mounted(flat.coordinates_m)
            yield f"panel {panel.name}", mounted_m[flat.triangles]
    for wall in walls(case, folder):
        yield f"surface {wall.name}", wall.position_m[wall.triangles]


def _outside(case: Case, particles: ParticleList) -> Iterator[CaseProblem]:
    low, high = np.array(case.domain_m)
    outside = ((particles.position_m < low) | (particles.position_m > high)).any(axis=1)
    numbers = np.flatnonzero(outside)
    if len(numbers):
        key, name = _named(case, numbers[0])
        place = np.round(particles.position_m[numbers[0]], 4).tolist()
        yield CaseProblem(key, f"{name} at {place} is outside domain_m{_more(numbers)}")


def _overlapping(case: Case, particles: ParticleList) -> Iterator[CaseProblem]:
    """Pairs nearer than the sum of their radii, by a k-d tree."""
    from scipy.spatial import cKDTree

    tree = cKDTree(particles.position_m)
    pairs = tree.query_pairs(particles.diameter_m.max(), output_type="ndarray")
    one, two = pairs.T
    distance_m = np.linalg.norm(particles.position_m[one] - particles.position_m[two], axis=1)
    radii_m = (particles.diameter_m[one] + particles.diameter_m[two]) / 2
    found = np.flatnonzero(distance_m < radii_m * (1 - ALLOWED))
    if len(found):
        deepest = found[np.argmax((radii_m - distance_m)[found])]
        key, name = _named(case, one[deepest])
        overlap_m = (radii_m - distance_m)[deepest]
        other = _named(case, two[deepest])[1]
        yield CaseProblem(key, f"{name} overlaps {other} by {overlap_m:.3g} m{_more(found)}")


def _more(found: Indices) -> str:
    return f" ({len(found) - 1} more)" if len(found) > 1 else ""


def _named(case: Case, number: int) -> tuple[Key, str]:
    """The key that puts particle ``number`` (from 0) where it is, and what to call it."""
    singles = list(case.bed.particles)
    if number < len(singles):
        return ("bed", "particles", singles[number], "position_m"), f'"{singles[number]}"'
    first = len(singles)
    for name, block in case.bed.blocks.items():
        first += block.count
        if number < first:
            return ("bed", "blocks", name, "box_m"), f"particle {number + 1}"
    raise AssertionError(f"there is no particle {number + 1}")


def beyond_surfaces(
    case: Case, penetrations: Penetrations, surface: TriangleSurface
) -> Iterator[CaseProblem]:
    """A panel that hangs through a surface or another panel, where the watch would stop the run."""
    found = penetrations.deepest(surface.position_m)
    if found is None or case.monitor.penetrated_surfaces != "stop":
        return
    if found.thicknesses > case.monitor.largest_penetration:
        table = {one.name: one.table_name for one in single_panels(case)}[found.panel]
        what = (
            f"panel {found.panel} hangs {found.depth_m:.3g} m through {found.surface} before anything moves"
        )
        hint = "tighten it, move one of them, or give the panel a stop where it is to lie"
        yield CaseProblem(("screen", "panels", table), what, hint)


def in_hanging_panels(
    case: Case, surface: TriangleSurface, panel_of_triangle: Indices, particles: ParticleList
) -> Iterator[CaseProblem]:
    """Particles, and boxes of feeds, that a panel at rest reaches into."""
    corners_m = surface.position_m[surface.triangles]
    for number, panel in enumerate(single_panels(case)):
        at_rest = f"panel {panel.name} as it hangs at rest"
        own_m = corners_m[panel_of_triangle == number]
        yield from in_surface(case, particles, at_rest, own_m)
        yield from in_feed_box(case, at_rest, own_m)
