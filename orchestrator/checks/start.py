"""Particles and feeds at t = 0: inside the domain, clear of each other and of every surface."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from orchestrator.bed.sources import NoRoom, initial_particles, inlets
from orchestrator.casefile.case import Case
from orchestrator.casefile.errors import Key, Mistake
from orchestrator.deck.panels import single_panels, walls
from orchestrator.mapping import grid
from orchestrator.planning import material_numbers
from orchestrator.plans import ParticleList
from orchestrator.ports import Array, Indices

ALLOWED = 1e-6  # overlap over diameter that counts as touching


def particles_at_start(case: Case, folder: Path) -> Iterator[Mistake]:
    """Panels count as flat between their clamps, where they are not yet bent by their weight."""
    try:
        particles = initial_particles(case, material_numbers(case))
    except NoRoom as full:
        yield Mistake(("bed", "blocks", full.block, "count"), str(full))
        return
    if len(particles) == 0:
        return
    yield from _outside(case, particles)
    yield from _overlapping(case, particles)
    for name, mesh in _surfaces(case, folder):
        yield from _in_surface(case, particles, name, mesh)


def feeds_at_start(case: Case, folder: Path) -> Iterator[Mistake]:
    """Feed boxes that a surface reaches into: what appeared there would be inside it."""
    if not case.bed.feeds:
        return
    surfaces = list(_surfaces(case, folder))
    for feed, inlet in inlets(case, material_numbers(case)).items():
        low, high = inlet.box_m
        rim_m = ALLOWED * (high - low)  # a box may stand against a wall
        bounds = np.stack([low + rim_m, high - rim_m], axis=1).ravel()
        for name, mesh in surfaces:
            turned = mesh.copy()
            turned.points = mesh.points @ inlet.axes
            if turned.clip_box(bounds, invert=False).n_cells:
                yield Mistake(("bed", "feeds", feed, "box_m"), f"{name} reaches into it")


def _surfaces(case: Case, folder: Path) -> Iterator[tuple[str, Any]]:
    """Panels and rigid surfaces by name, as PyVista meshes in the world."""
    import pyvista  # here because its import takes longer than all other checks together

    def mesh(position_m: Array, triangles: Indices) -> Any:
        faces = np.column_stack([np.full(len(triangles), 3), triangles])
        return pyvista.PolyData(position_m, faces)

    for panel in single_panels(case):
        flat = grid(panel.rectangle, (1, 1))
        mounted_m = panel.rectangle.mounted(flat.coordinates_m)
        yield f"panel {panel.name}", mesh(mounted_m, flat.triangles)
    for wall in walls(case, folder):
        yield f"surface {wall.name}", mesh(wall.position_m, wall.triangles)


def _outside(case: Case, particles: ParticleList) -> Iterator[Mistake]:
    low, high = np.array(case.domain_m)
    outside = ((particles.position_m < low) | (particles.position_m > high)).any(axis=1)
    numbers = np.flatnonzero(outside)
    if len(numbers):
        key, name = _named(case, numbers[0])
        place = np.round(particles.position_m[numbers[0]], 4).tolist()
        yield Mistake(key, f"{name} at {place} is outside domain_m{_more(numbers)}")


def _overlapping(case: Case, particles: ParticleList) -> Iterator[Mistake]:
    """Pairs nearer than the sum of their radii, by a k-d tree."""
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
        yield Mistake(key, f"{name} overlaps {other} by {overlap_m:.3g} m{_more(found)}")


def _in_surface(case: Case, particles: ParticleList, surface: str, mesh: Any) -> Iterator[Mistake]:
    """Particles whose centres are nearer to the mesh than their radius."""
    _, closest_m = mesh.find_closest_cell(particles.position_m, return_closest_point=True)
    distance_m = np.linalg.norm(particles.position_m - closest_m.reshape(-1, 3), axis=1)
    overlap_m = particles.diameter_m / 2 - distance_m
    found = np.flatnonzero(overlap_m > ALLOWED * particles.diameter_m)
    if len(found):
        deepest = found[np.argmax(overlap_m[found])]
        key, name = _named(case, deepest)
        what = f"{name} is {overlap_m[deepest]:.3g} m inside {surface}{_more(found)}"
        yield Mistake(key, what)


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
