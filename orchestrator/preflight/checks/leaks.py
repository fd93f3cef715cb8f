"""The warnings about places where material leaves the deck that nobody meant as an exit.

The checks follow straight rays and free flights among flat panels and rigid surfaces at t = 0, in deck
axes (scene/flight.py).  They consider the material of blocks and feeds, and a bed that is taken over: single
particles are trials, which may fall where they like.  The sides of a periodic slice are closed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product
from pathlib import Path

import numpy as np

from orchestrator.case.bed.grains import sieve_sizes_m
from orchestrator.case.deck.panels import TRANSPORT_M_PER_S, axes
from orchestrator.case.tables.case import Case, has_particles
from orchestrator.ports import Array
from orchestrator.preflight.scene.flight import Flights, Landing, Solids, solids
from orchestrator.preflight.scene.panel_rows import Joint, PanelRows, PlacedPanel, panel_rows

COVERS_M = 0.05  # A surface this close above or below a gap covers it.
WALL_WITHIN_M = 0.5  # A wall farther from a panel's edge than this does not belong to it.
ON_PANEL_M = 0.03  # A wall may stand so far inside a panel's edge, for example at the end of its clamp.
LEAVING_M_PER_S = (0.05, TRANSPORT_M_PER_S, 1.0)  # Speeds at which material may leave the lower end.
ACROSS = (0.03, 0.26, 0.5, 0.74, 0.97)  # Lines along the deck, as shares of the width.
ALONG = (0.1, 0.5, 0.9)  # Places at a panel's side, as shares of the length.
TOUCHING_M = 1e-5  # Edges that are closer than this touch.
SAMPLES_IN_DIAMETER, MOST_SAMPLES = 4, 400


def leaks(case: Case, folder: Path) -> Iterator[str]:
    """Yield a warning for each kind of way by which material leaves the deck unintentionally.

    The ways are gaps between panels, gaps beside them, open sides, an open upper end, ends and openings
    below which no exit is, and feeds and blocks that miss the deck.
    """
    if not has_particles(case) or not case.bed.has_material or not case.screen.panels:
        return
    scene = _Deck(case, folder)
    yield from scene.gaps_between_panels()
    if case.slice is None or case.slice.sides == "walls":
        yield from scene.sides()
    yield from scene.upper_ends()
    yield from scene.lower_ends()
    yield from scene.below_openings()
    yield from scene.sources()


class _Deck:
    """The deck of a case with its material, for the questions of this module."""

    def __init__(self, case: Case, folder: Path) -> None:
        self.case = case
        self.rows: PanelRows = panel_rows(case)
        self.parts: Solids = solids(case, folder)
        self.flights = Flights(case, self.parts)
        self.smallest_m, self.largest_m = sieve_sizes_m(case)
        self.boxes_m = _source_boxes_m(case)

    def gaps_between_panels(self) -> Iterator[str]:
        """Yield a warning if particles fall between panels one behind the other."""
        widths_m = {joint.name: self._gap_at(joint) for joint in self.rows.joints}
        open_m = {name: width_m for name, width_m in widths_m.items() if width_m > self.smallest_m}
        if open_m:
            yield (
                f"a gap of {_mm(max(open_m.values()))} between panels {_names(open_m)}: "
                f"{self._what_falls(max(open_m.values()))}; close it with cross beams or a surface"
            )

    def sides(self) -> Iterator[str]:
        """Yield warnings about sides without a wall, and about gaps between panels and walls."""
        for way, side in ((-1.0, "left"), (1.0, "right")):
            is_open: list[str] = []
            gaps_m: dict[str, float] = {}
            for panel in self.rows.panels:
                outwards = way * np.sign(panel.across[1] or 1.0) * panel.across
                edge = 1.0 if outwards @ panel.across > 0 else 0.0
                if self._is_far_from_side(panel, edge):
                    continue
                for along in ALONG:
                    width_m = self._gap_beside(panel.point_m(along, edge), outwards, panel)
                    if np.isinf(width_m):
                        is_open.append(panel.name)
                    elif width_m > self.smallest_m:
                        gaps_m[panel.name] = max(width_m, gaps_m.get(panel.name, 0.0))
            if is_open:
                yield (
                    f"no wall along the {side} side of {_count(is_open)}, seen down the deck: material "
                    "falls off; add side plates or a surface"
                )
            if gaps_m:
                widest_m = max(gaps_m.values())
                yield (
                    f"a gap of {_mm(widest_m)} between {_count(gaps_m)} and the wall along the {side} side: "
                    f"{self._what_falls(widest_m)}"
                )

    def upper_ends(self) -> Iterator[str]:
        """Yield a warning for each upper end on which material lands and where no wall holds it back."""
        for panel in self.rows.first:
            if all(box_m[0, 0] >= panel.lower_m[0] for box_m in self.boxes_m):
                continue
            widths_m = [
                self._gap_beside(panel.point_m(0.0, across), -panel.along, panel) for across in ACROSS
            ]
            if np.isinf(max(widths_m)):
                yield (
                    f"no back wall at the upper end, behind panel {panel.name}, on which material lands: "
                    "grains that bounce back are lost; add a surface across the deck or a feed chute"
                )
            elif max(widths_m) > self.smallest_m:
                yield (
                    f"a gap of {_mm(max(widths_m))} between the upper end of panel {panel.name} and the "
                    f"wall behind it: {self._what_falls(max(widths_m))}"
                )

    def lower_ends(self) -> Iterator[str]:
        """Yield a warning for each lower end from which material falls into no exit."""
        for panel in self.rows.last:
            way_m = min(panel.lower_m[0] - box_m[1, 0] for box_m in self.boxes_m)
            if way_m >= TRANSPORT_M_PER_S * self.case.duration_s:
                continue  # no material comes there within the run
            edge_m = panel.point_m(1.0, 0.5) + self.largest_m / 2 * panel.normal
            if np.isfinite(self._wall_beyond(edge_m, panel.along)):
                continue  # A wall closes this end.
            fates = [
                self.flights.land(edge_m + TOUCHING_M * panel.along, speed * panel.along)
                for speed in LEAVING_M_PER_S
            ]
            if all(fate.what in ("outside", "nothing") for fate in fates):
                yield (
                    f"no exit behind the lower end, panel {panel.name}: what leaves the deck there counts as "
                    'lost; add [screen.exits] with product = "oversize"'
                )

    def below_openings(self) -> Iterator[str]:
        """Yield a warning for panels below whose passing openings no exit is."""
        lost = []
        for panel in self.rows.panels:
            openings = panel.panel.apertures
            if openings is None or openings.spheres_m[1] <= self.smallest_m:
                continue
            below_m = panel.point_m(0.5, 0.5) - self.largest_m * panel.normal
            if self.flights.land(below_m, np.zeros(3)).what in ("outside", "nothing"):
                lost.append(panel.name)
        if lost:
            yield (
                f"no exit below the openings of {_count(lost)}: what passes them counts as lost; add "
                '[screen.exits] with product = "undersize"'
            )

    def sources(self) -> Iterator[str]:
        """Yield a warning for each feed and block of which a part falls on no panel or surface."""
        for (kind, name), (corners_m, velocity_m_per_s) in _source_flights(self.case).items():
            fates = [self.flights.land(place_m, velocity_m_per_s) for place_m in corners_m]
            missing = [fate for fate in fates if fate.what not in ("panel", "wall")]
            if missing:
                where = " or ".join(dict.fromkeys(map(_describe_fate, missing)))
                how_many = "all" if len(missing) == len(fates) else f"{len(missing)} of {len(fates)}"
                yield (
                    f'{kind} "{name}" misses the deck: {how_many} trial flights from its box hit no panel or '
                    f"surface and end {where}; move box_m or change velocity_m_per_s"
                )

    def _gap_at(self, joint: Joint) -> float:
        """Return the width of the widest open gap at a joint, over some lines along the deck.

        An upper panel that reaches over the lower one leaves none.
        """
        gap_m = joint.gap_m - (joint.gap_m @ joint.upper.across) * joint.upper.across
        if np.linalg.norm(gap_m) <= self.smallest_m or gap_m @ joint.upper.along <= 0.0:
            return 0.0
        return max(
            self._open_width_m(joint.upper.point_m(1.0, across), gap_m, joint.upper.normal)
            for across in ACROSS
        )

    def _gap_beside(self, edge_m: Array, outwards: Array, panel: PlacedPanel) -> float:
        """Return the open width between a panel's edge (3,) and the wall that stands beside it.

        The result is infinite if no wall stands there as high as half of the largest particle.
        """
        if self._continues(edge_m + self.smallest_m / 2 * outwards, panel.normal):
            return 0.0
        heights_m = np.array([self.smallest_m, self.largest_m]) / 2
        distances_m = [self._wall_beyond(edge_m + height * panel.normal, outwards) for height in heights_m]
        if np.isinf(max(distances_m)):
            return float("inf")
        return self._open_width_m(edge_m, max(distances_m[0], 0.0) * outwards, panel.normal)

    def _continues(self, beside_m: Array, normal: Array) -> bool:
        """Return whether a panel lies at a place (3,) beside another panel's edge."""
        start_m, step_m = beside_m + COVERS_M / 2 * normal, -COVERS_M * normal
        _, triangle = self.parts.first_hits(start_m[None], step_m[None])
        return bool(triangle[0] >= 0 and self.parts.panel[triangle[0]] >= 0)

    def _wall_beyond(self, edge_m: Array, outwards: Array) -> float:
        """Return the distance from an edge (3,) to the wall beside it, infinite if none is near.

        The distance is negative for a wall that stands on the panel itself.
        """
        start_m, step_m = edge_m - ON_PANEL_M * outwards, (ON_PANEL_M + WALL_WITHIN_M) * outwards
        share, _ = self.parts.rigid.first_hits(start_m[None], step_m[None])
        return float(share[0] * (ON_PANEL_M + WALL_WITHIN_M) - ON_PANEL_M)

    def _open_width_m(self, edge_m: Array, gap_m: Array, normal: Array) -> float:
        """Return the longest part of a gap (3,) from an edge (3,) that no surface covers."""
        width_m = float(np.linalg.norm(gap_m))
        if width_m <= TOUCHING_M:
            return 0.0
        count = min(MOST_SAMPLES, int(np.ceil(SAMPLES_IN_DIAMETER * width_m / self.smallest_m)) + 1)
        places_m = edge_m + (np.arange(count)[:, None] + 0.5) / count * gap_m
        is_open = np.ones(count, dtype=bool)
        for way in (1.0, -1.0):
            steps_m = np.tile(way * COVERS_M * normal, (count, 1))
            share, _ = self.parts.rigid.first_hits(places_m, steps_m)
            is_open &= np.isinf(share)
        ends = np.flatnonzero(np.diff(np.concatenate([[0], is_open, [0]])))
        runs = np.diff(ends)[::2]
        return float(runs.max(initial=0)) * width_m / count

    def _what_falls(self, width_m: float) -> str:
        if width_m >= self.largest_m:
            return f"all particles ({_mm(self.smallest_m)} to {_mm(self.largest_m)}) fall through"
        return f"particles from {_mm(self.smallest_m)} up to that size fall through"

    def _is_far_from_side(self, panel: PlacedPanel, edge: float) -> bool:
        """Return whether no material is near a panel's side: a block heaps no wider than it is high."""
        if self.case.bed.feeds:
            return False
        side_m = panel.point_m(0.5, edge)[1]
        return all(
            min(abs(box_m[0, 1] - side_m), abs(box_m[1, 1] - side_m))
            > box_m[1, 2] - box_m[0, 2] + self.largest_m
            for box_m in self.boxes_m
        )


def _source_boxes_m(case: Case) -> list[Array]:
    """Return bounds (2, 3) in deck axes of all blocks and feeds, and of the particles that are taken over."""
    boxes = [corners_m for corners_m, _ in _source_flights(case).values()]
    if (carried := case.bed.carried) is not None and len(carried):
        places_m, radius_m = carried.position_m @ axes(case), carried.grains.bounding_radius_m[:, None]
        boxes.append(np.vstack([places_m - radius_m, places_m + radius_m]))
    return [np.array([corners_m.min(axis=0), corners_m.max(axis=0)]) for corners_m in boxes]


def _source_flights(case: Case) -> dict[tuple[str, str], tuple[Array, Array]]:
    """Return starting places (27, 3) and the velocity (3,), in deck axes, of each block and feed."""
    turn = axes(case)
    flights = {}
    for kind, rows in (("block", case.bed.blocks), ("feed", case.bed.feeds)):
        for name, row in rows.items():
            low_m, high_m = np.array(row.box_m)
            shares = np.array(list(product((0.05, 0.5, 0.95), repeat=3)))
            places_m, velocity = low_m + shares * (high_m - low_m), np.array(row.velocity_m_per_s)
            if row.axes == "world":
                places_m, velocity = places_m @ turn, velocity @ turn
            flights[kind, name] = (places_m, velocity)
    return flights


def _describe_fate(fate: Landing) -> str:
    return {"exit": f'in exit "{fate.name}"', "outside": "outside domain_m"}.get(fate.what, "nowhere")


def _mm(length_m: float) -> str:
    return f"{1e3 * length_m:.3g} mm"


def _names(names: Sequence[str] | dict[str, float]) -> str:
    first, *others = dict.fromkeys(names)
    return f"{first} (and at {len(others)} more joints)" if others else first


def _count(names: Sequence[str] | dict[str, float]) -> str:
    """Return the name of a panel, or of the first of several with their number."""
    first, *others = dict.fromkeys(names)
    return f"panel {first} and {len(others)} more" if others else f"panel {first}"
