"""The solid's grid: the cells that the plan asks for, and around openings as many as these need.

Openings are rectangles without cells.  Each of their sides is a cell border all through the panel.
Cells are no longer than the plan says and, where some row of the pattern has a land, no longer
than half of it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from adapters.panel.common.grid import ElementGrid, clamped_rows_m, nodal_slopes, numbers_at_nodes
from orchestrator.ports import Array, Indices, Interpolation
from orchestrator.ports.geometry import AperturePattern, Rectangle
from orchestrator.ports.plans import LARGEST_MESHES_GIB, MeshSize, PanelPlan

CELLS_PER_LAND = 2
SAME_PLACE_M = 1e-9
LAYERS = 3  # of nodes, through the thickness
MIDDLE_LAYER = 2 / 3  # of the mass
GIB_PER_NODE = 3e-5  # with the factorised stiffness (docs/theory/perforated_panel.md)
SIMPSON = (1 / 6, 2 / 3, 1 / 6)  # integrals of the shape functions over a cell of length 1
NOWHERE = np.full((1, 2, 2), np.nan)  # a hole that nothing is in, for cells with material


def solid_grid(plan: PanelPlan) -> PiercedGrid:
    """Make the grid of ``plan``'s mid-surface, its openings as holes.

    Raises ValueError for openings with round ends.
    """
    if plan.apertures is None:
        return PiercedGrid(ElementGrid.of(plan.rectangle, plan.cells), np.empty((0, 2, 2)))
    rectangle, pattern = plan.rectangle, plan.apertures
    if pattern.shape != "rectangle":
        raise ValueError(
            f"panel {plan.name}: the solid's cells are boxes and follow no round ends; "
            'take shape = "rectangle"'
        )
    along, across = (_Way.of(pattern, rectangle, number) for number in (0, 1))
    s_m = clamped_rows_m(rectangle, along.borders_m(plan.cells[0]))
    holes_m = np.stack([along.sides_m, across.sides_m], axis=-1)
    return PiercedGrid(ElementGrid(s_m, across.borders_m(plan.cells[1])), holes_m)


def size(plan: PanelPlan) -> MeshSize:
    """Return the size of the grid that ``solid_grid`` makes of the plan.  Raises ValueError as it does."""
    grid = solid_grid(plan)
    nodes = LAYERS * len(grid.nodes_m())
    areal_kg_per_m2 = plan.material.density_kg_per_m3 * plan.thickness_m
    return MeshSize(
        cells=int((grid.hole_of_cell() < 0).sum()),
        nodes=nodes,
        memory_GiB=GIB_PER_NODE * nodes,
        lightest_kg=MIDDLE_LAYER * areal_kg_per_m2 * float(grid.node_areas_m2().min()),
    )


def bearable_grid(plan: PanelPlan) -> PiercedGrid:
    """Return ``solid_grid``, but raise ValueError also for a mesh that no machine carries."""
    needed = size(plan)
    if needed.memory_GiB > LARGEST_MESHES_GIB:
        raise ValueError(
            f"panel {plan.name}: its {needed.cells} cells need some {needed.memory_GiB:.0f} GiB; "
            f"at most {LARGEST_MESHES_GIB:g} GiB are allowed"
        )
    return solid_grid(plan)


@dataclass(frozen=True)
class _Way:
    """A pattern seen along one side of the panel: where its region and its openings are.

    ``staggered``: what is open in one row is a land in the next.
    """

    panel_m: float
    region_m: Array
    opening_m: float
    land_m: float
    centre_m: Array
    staggered: bool

    @staticmethod
    def of(pattern: AperturePattern, rectangle: Rectangle, number: int) -> _Way:
        """Return the view of a pattern along (0) or across (1) the panel."""
        panel_m = (rectangle.length_m, rectangle.width_m)[number]
        opening_m = (pattern.length_m, pattern.width_m)[number]
        pitch_m = (pattern.pitch_along_m, pattern.pitch_across_m)[number]
        return _Way(
            panel_m=panel_m,
            region_m=pattern.region_m(rectangle)[:, number],
            opening_m=opening_m,
            land_m=pitch_m - opening_m,
            centre_m=pattern.centres_m(rectangle)[:, number],
            staggered=number == 1 and pattern.stagger > 0.0,
        )

    @property
    def stops_m(self) -> Array:
        """The places where cells must end: at the openings' sides, the region's ends and the panel's ends."""
        sides_m = np.add.outer([-0.5 * self.opening_m, 0.5 * self.opening_m], self.centre_m)
        wanted = np.concatenate([[0.0, self.panel_m], self.region_m, sides_m.ravel()])
        stops = np.sort(np.clip(wanted, 0.0, self.panel_m))
        return np.asarray(stops[np.append(True, np.diff(stops) > SAME_PLACE_M)])

    @property
    def sides_m(self) -> Array:
        """The first and second side of each opening, (openings, 2), exactly at the stops."""
        sides_m = self.centre_m[:, None] + np.array([-0.5, 0.5]) * self.opening_m
        return snap(self.stops_m, sides_m, SAME_PLACE_M)

    def borders_m(self, cells: int) -> Array:
        """Return the cells' borders, at most 1 / ``cells`` of the panel and half a land apart."""
        stops_m = self.stops_m
        middle_m = 0.5 * (stops_m[:-1] + stops_m[1:])
        low_m, high_m = np.unique(self.sides_m, axis=0).T[:, :, None]
        is_open = ((low_m < middle_m) & (middle_m < high_m)).any(axis=0)
        inside = (self.region_m[0] < middle_m) & (middle_m < self.region_m[1])
        land = inside & (self.staggered | ~is_open)
        longest_m = np.full(len(middle_m), self.panel_m / cells)
        longest_m[land] = np.minimum(longest_m[land], self.land_m / CELLS_PER_LAND)
        pieces = np.ceil(np.diff(stops_m) / longest_m - 1e-6)
        last = np.append(0.0, np.cumsum(pieces))
        return np.interp(np.arange(last[-1] + 1), last, stops_m)


def snap(breaks_m: Array, value_m: Array, slack_m: float) -> Array:
    """Move values within ``slack_m`` of a cell border onto it: shape functions are then exactly 0 or 1."""
    after = np.clip(np.searchsorted(breaks_m, value_m), 1, len(breaks_m) - 1)
    low, high = breaks_m[after - 1], breaks_m[after]
    nearest = np.where(value_m - low < high - value_m, low, high)
    return np.where(np.abs(value_m - nearest) <= slack_m, nearest, value_m)


def _cell(breaks_m: Array, value_m: Array) -> Indices:
    after = np.searchsorted(breaks_m, value_m, side="right")
    return np.asarray(np.clip(after - 1, 0, len(breaks_m) - 2))


@dataclass(frozen=True)
class PiercedGrid:
    """A grid ``whole``, of which rectangular holes are left out: in a hole there are neither cells nor
    nodes, and what is seen in it lies on the straight line between its two longer sides.

    ``holes_m`` (holes, 2, 2): lowest and highest (s, y) of each in m, on borders of cells."""

    whole: ElementGrid
    holes_m: Array

    def hole_of_cell(self) -> Indices:
        """Return the number of the hole that each cell is in, (along, across), -1 where there is material."""
        hole = np.full(self.whole.shape, -1, dtype=np.int64)
        middle = 0.5 * (self.whole.s_m[:-1] + self.whole.s_m[1:])
        rows = np.searchsorted(middle, self.holes_m[:, :, 0])
        middle = 0.5 * (self.whole.y_m[:-1] + self.whole.y_m[1:])
        columns = np.searchsorted(middle, self.holes_m[:, :, 1])
        for number, (row, column) in enumerate(zip(rows, columns, strict=True)):
            hole[slice(*row), slice(*column)] = number
        return hole

    def nodes_m(self) -> Array:
        """Return the material coordinates (nodes, 2)."""
        return self.whole.nodes_m()[self._there()]

    def node_areas_m2(self) -> Array:
        """Return (nodes,): the integral of each shape function, which is positive."""
        return self._areas_m2()[self._there()]

    def _there(self) -> Indices:
        """Return the nodes of the whole grid that belong to cells with material."""
        return np.flatnonzero(self._areas_m2())

    def _areas_m2(self) -> Array:
        """Return the integral of each shape function, (nodes of the whole grid,), 0 where there is no
        material."""
        along, across = self.whole.shape
        cells_m2 = np.outer(np.diff(self.whole.s_m), np.diff(self.whole.y_m))
        cells_m2 *= self.hole_of_cell() < 0
        areas_m2 = np.zeros((2 * along + 1, 2 * across + 1))
        for i, first in enumerate(SIMPSON):
            for j, second in enumerate(SIMPSON):
                areas_m2[i : i + 2 * along : 2, j : j + 2 * across : 2] += first * second * cells_m2
        return areas_m2.ravel()

    def interpolation(self, coordinates_m: Array) -> Interpolation:
        """Return the interpolation at ``coordinates_m`` (n, 2), or (n, 3) with offsets.  Raises ValueError
        outside the grid."""
        return Interpolation.of(coordinates_m, self.values, self.slopes)

    def slopes(self, coordinates_m: Array) -> tuple[csr_array, csr_array]:
        """Return the slopes along and across (n, nodes) in 1/m at ``coordinates_m`` (n, 2), as
        ``ElementGrid.slopes`` does, of cells with material alone."""
        H, there = self.values(coordinates_m), self._there()
        along, across = nodal_slopes(self.whole, self.hole_of_cell() < 0)
        return H @ along[there][:, there], H @ across[there][:, there]

    def values(self, coordinates_m: Array) -> csr_array:
        """Return shape functions (n, nodes) at ``coordinates_m`` (n, 2).

        In holes they are those of two places on their sides, by distance.  Raises ValueError outside the
        grid.
        """
        low_m, high_m, share = self._sides(coordinates_m)
        low = self.whole.values(low_m).multiply(1.0 - share[:, None])
        high = self.whole.values(high_m).multiply(share[:, None])
        return csr_array((low + high).tocsc()[:, self._there()])

    def _sides(self, coordinates_m: Array) -> tuple[Array, Array, Array]:
        """Return two places (n, 2) on material for each point, and how far (n,) it is from the first to the
        second.

        Both are its own place unless it is in a hole.
        """
        breaks_m = (self.whole.s_m, self.whole.y_m)
        slack_m = 1e-9 * float(np.ptp(self.whole.s_m))
        at = [snap(x, v, slack_m) for x, v in zip(breaks_m, coordinates_m.T, strict=True)]
        cell = tuple(_cell(x, v) for x, v in zip(breaks_m, at, strict=True))
        hole_m = np.concatenate([self.holes_m, NOWHERE])[self.hole_of_cell()[cell]]
        point, low, high = np.column_stack(at), hole_m[:, 0], hole_m[:, 1]
        inside = ((point > low) & (point < high)).all(axis=1)
        shorter = np.argmin(high - low, axis=1)
        across = inside[:, None] & (np.arange(2) == shorter[:, None])
        first, second = np.where(across, low, point), np.where(across, high, point)
        gap_m = np.where(inside, (second - first).sum(axis=1), 1.0)
        return first, second, (point - first).sum(axis=1) / gap_m

    def numbers_of(self, coordinates_m: Array) -> Indices:
        """Return for each node the number of the point that stands there, as ``ElementGrid.numbers_of``
        does."""
        return numbers_at_nodes(self.values(coordinates_m[:, :2]))
