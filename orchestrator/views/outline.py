"""The machine of a case as points and lines in the world, which all views draw."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from types import MappingProxyType

import numpy as np

from orchestrator.case.bed.sources import single_particles
from orchestrator.case.deck.panels import SinglePanel, axes, single_panels, to_world, walls
from orchestrator.case.tables.bed import Block, Feed
from orchestrator.case.tables.case import Case
from orchestrator.case.tables.frames import Bushing, Exciter
from orchestrator.case.tables.screen import Exit
from orchestrator.ports import Array, Indices
from orchestrator.ports.geometry import area_vectors_m2, distinct_edges
from orchestrator.ports.plans import ParticleList

FLAT_DEG = 20.0  # Neighbouring triangles that bend less make one face.
MOST_DRAWN = 2000  # triangles of a rigid surface: each is a patch of a drawing


@dataclass(frozen=True)
class PanelOutline:
    """A panel with the corners of its whole rectangle (4, 3) and of its free part (4, 3)."""

    panel: SinglePanel
    corners_m: Array
    free_m: Array

    @property
    def openings_m(self) -> list[Array]:
        """The corners (n, 3) of each drawn opening, or else (4, 3) of the rectangle around each opening."""
        pattern, at = self.panel.apertures, self.panel.rectangle
        if pattern is None:
            return []
        if pattern.drawn:
            return [at.mounted(corners) for corners in pattern.drawn.corners_m]
        half_m = np.array([pattern.length_m, pattern.width_m]) / 2
        corners_m = pattern.centres_m(at)[:, None] + half_m * [[-1, -1], [1, -1], [1, 1], [-1, 1]]
        return [*at.mounted(corners_m.reshape(-1, 2)).reshape(-1, 4, 3)]


@dataclass(frozen=True)
class WallOutline:
    """A rigid surface: its triangles (m, 3, 3), fewer than particles touch where these are very many, and the
    edges (n, 2, 3) that bound its faces."""

    name: str
    frame: str
    triangles_m: Array
    edges_m: Array


@dataclass(frozen=True)
class BoxOutline:
    """A box by its corners (8, 3), with a name and a description."""

    name: str
    text: str
    corners_m: Array
    velocity_m_per_s: Array

    @property
    def middle_m(self) -> Array:
        """The middle of the box (3,)."""
        return np.asarray(self.corners_m.mean(axis=0))


@dataclass(frozen=True)
class BushingOutline:
    """A group of equal bushings with their places (n, 3)."""

    name: str
    table: Bushing
    places_m: Array


@dataclass(frozen=True)
class ExciterOutline:
    """An exciter with its place (3,) and the axis (3,) about which it turns in the positive sense."""

    name: str
    table: Exciter
    place_m: Array
    axis: Array


@dataclass(frozen=True)
class MachineOutline:
    """All that the views draw, in world axes; ``down`` (3,) points down the deck."""

    case: Case
    panels: tuple[PanelOutline, ...]
    walls: tuple[WallOutline, ...]
    centers_m: dict[str, Array]
    bushings: tuple[BushingOutline, ...]
    exciters: tuple[ExciterOutline, ...]
    feeds: tuple[BoxOutline, ...]
    blocks: tuple[BoxOutline, ...]
    exits: tuple[BoxOutline, ...]
    particles: ParticleList
    down: Array

    @property
    def frames(self) -> tuple[str, ...]:
        """The names of the frames, in the order of the case."""
        return tuple(self.case.screen.frames)

    @property
    def points_m(self) -> Array:
        """All points (n, 3) of the machine and of its feeds, without the exits."""
        parts = [panel.corners_m for panel in self.panels]
        parts += [wall.triangles_m.reshape(-1, 3) for wall in self.walls]
        parts += [row.places_m for row in self.bushings] + [row.place_m[None] for row in self.exciters]
        parts += [box.corners_m for box in (*self.feeds, *self.blocks)]
        parts += [center_m[None] for center_m in self.centers_m.values()]
        parts += [self.particles.position_m] if len(self.particles) else []
        return np.concatenate(parts) if parts else np.array(self.case.domain_m)


def outline(
    case: Case, folder: Path, rates_kg_per_s: Mapping[str, float] = MappingProxyType({})
) -> MachineOutline:
    """Return the outline of a case without problems.  Raises stl.UnreadableSurface.

    ``rates_kg_per_s`` are those of the machine's feeds of which the case, at its level, has a part.
    """
    screen = case.screen
    return MachineOutline(
        case=case,
        panels=tuple(
            PanelOutline(panel, r.corners_m(r.clamp_m), r.corners_m())
            for panel in single_panels(case)
            for r in [panel.rectangle]
        ),
        walls=tuple(
            WallOutline(wall.name, wall.frame, at_m[triangles], face_edges_m(at_m, triangles))
            for wall in walls(case, folder)
            for at_m, triangles in [simplified(wall.position_m, wall.triangles)]
        ),
        centers_m={
            name: to_world(case, row.center_of_mass_m)
            for name, row in screen.frames.items()
            if row.center_of_mass_m is not None and row.mass_kg is not None
        },
        bushings=tuple(
            BushingOutline(name, row, to_world(case, np.array(row.positions_m)))
            for name, row in screen.bushings.items()
        ),
        exciters=tuple(
            ExciterOutline(name, row, to_world(case, row.position_m), to_world(case, row.axis))
            for name, row in screen.exciters.items()
        ),
        feeds=tuple(
            _box(case, name, _feed_in_words(row, rates_kg_per_s.get(name)), row)
            for name, row in case.bed.feeds.items()
        ),
        blocks=tuple(
            _box(case, name, f"{row.count} particles of {row.material}", row)
            for name, row in case.bed.blocks.items()
        ),
        exits=tuple(_box(case, name, row.product, row) for name, row in screen.exits.items()),
        particles=single_particles(case),
        down=axes(case)[:, 0],
    )


def _feed_in_words(row: Feed, whole_kg_per_s: float | None) -> str:
    if whole_kg_per_s is None:
        return f"{row.rate_kg_per_s:.4g} kg/s of {row.material}"
    return f"{whole_kg_per_s:.4g} kg/s of {row.material} (this level feeds {row.rate_kg_per_s:.4g})"


def _box(case: Case, name: str, text: str, row: Feed | Block | Exit) -> BoxOutline:
    corners_m = np.array(list(product(*zip(*row.box_m, strict=True))))
    velocity = np.zeros(3) if isinstance(row, Exit) else np.array(row.velocity_m_per_s)
    if isinstance(row, Exit) or row.axes == "deck":
        corners_m, velocity = to_world(case, corners_m), to_world(case, velocity)
    return BoxOutline(name, text, corners_m, velocity)


def simplified(position_m: Array, triangles: Indices) -> tuple[Array, Indices]:
    """Return the points (n, 3) and triangles (m, 3) of a surface, or those of one with nearly the same shape
    and no more than ``MOST_DRAWN`` triangles, where it has more."""
    if len(triangles) <= MOST_DRAWN:
        return position_m, triangles
    import pyvista

    faces = np.column_stack([np.full(len(triangles), 3), triangles])
    coarse = pyvista.PolyData(position_m, faces.ravel()).decimate_pro(1.0 - MOST_DRAWN / len(triangles))
    return np.asarray(coarse.points, dtype=np.float64), coarse.faces.reshape(-1, 4)[:, 1:].astype(np.int64)


def face_edges_m(position_m: Array, triangles: Indices) -> Array:
    """Return the edges (n, 2, 3) of a surface that belong to one triangle only or to a bend."""
    normal = area_vectors_m2(position_m[triangles])
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    distinct, which, sharing = distinct_edges(triangles)
    owners = np.repeat(np.arange(len(triangles)), 3)[np.argsort(which, kind="stable")]
    first = np.cumsum(sharing) - sharing
    one, other = normal[owners[first]], normal[owners[first + sharing - 1]]
    flat = np.abs(np.einsum("nk,nk->n", one, other)) > np.cos(np.radians(FLAT_DEG))
    return np.asarray(position_m[distinct[~((sharing == 2) & flat)]])


def carried_points_m(machine: MachineOutline, frame: str) -> Array:
    """Return points (n, 3) of a frame: the edges that it clamps, its bushings, exciters and its centre."""
    parts = [machine.centers_m[frame][None]] if frame in machine.centers_m else []
    for row in machine.panels:
        for end, corners in ((0, [0, 3]), (1, [1, 2])):
            if row.panel.frames[end] == frame:
                parts.append(row.corners_m[corners])
    parts += [row.places_m for row in machine.bushings if frame in row.table.between]
    parts += [row.place_m[None] for row in machine.exciters if row.table.frame == frame]
    return np.concatenate(parts) if parts else np.empty((0, 3))
