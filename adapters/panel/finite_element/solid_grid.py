"""The solid's cells: those that the plan asks for, and around openings as many as these need.

Openings are rectangles without cells.  Each of their sides is a cell border all through the panel.
Cells are no longer than the plan says and, where some row of the pattern has a land, no longer
than half of it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from adapters.panel.finite_element.grid import Grid
from adapters.panel.finite_element.pierced_grid import PiercedGrid, snapped
from orchestrator.ports import Array
from orchestrator.ports.geometry import Apertures, Rectangle
from orchestrator.ports.plans import LARGEST_MESHES_GIB, MeshSize, PanelPlan

CELLS_PER_LAND = 2
SAME_PLACE_M = 1e-9
LAYERS = 3  # of nodes, through the thickness
MIDDLE_LAYER = 2 / 3  # of the mass
GIB_PER_NODE = 3e-5  # with the factorised stiffness (docs/theory/perforated_panel.md)


def solid_grid(plan: PanelPlan) -> PiercedGrid:
    """The grid of ``plan``'s mid-surface, its openings as holes.

    ValueError for openings with round ends.
    """
    if plan.apertures is None:
        return PiercedGrid(Grid.of(plan.rectangle, plan.cells), np.empty((0, 2, 2)))
    rectangle, pattern = plan.rectangle, plan.apertures
    if pattern.shape != "rectangle":
        raise ValueError(
            f"panel {plan.name}: the solid's cells are boxes and follow no round ends; "
            'take shape = "rectangle"'
        )
    along, across = (_Way.of(pattern, rectangle, number) for number in (0, 1))
    clamp_m = [rectangle.clamp_m] if rectangle.clamp_m > 0.0 else []
    s_m = [*(-c for c in clamp_m), *along.borders_m(plan.cells[0])]
    s_m += [rectangle.length_m + c for c in clamp_m]
    holes_m = np.stack([along.sides_m, across.sides_m], axis=-1)
    return PiercedGrid(Grid(np.array(s_m), across.borders_m(plan.cells[1])), holes_m)


def size(plan: PanelPlan) -> MeshSize:
    """What ``solid_grid`` makes of the plan.  ValueError as there."""
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
    """``solid_grid``; ValueError for a mesh that no machine carries, too."""
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
    def of(pattern: Apertures, rectangle: Rectangle, number: int) -> _Way:
        """Along (0) or across (1)."""
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
        """Where cells must end: at the openings' sides, the region's ends and the panel's."""
        sides_m = np.add.outer([-0.5 * self.opening_m, 0.5 * self.opening_m], self.centre_m)
        wanted = np.concatenate([[0.0, self.panel_m], self.region_m, sides_m.ravel()])
        stops = np.sort(np.clip(wanted, 0.0, self.panel_m))
        return np.asarray(stops[np.append(True, np.diff(stops) > SAME_PLACE_M)])

    @property
    def sides_m(self) -> Array:
        """(openings, 2): first and second side of each, exactly at the stops."""
        sides_m = self.centre_m[:, None] + np.array([-0.5, 0.5]) * self.opening_m
        return snapped(self.stops_m, sides_m, SAME_PLACE_M)

    def borders_m(self, cells: int) -> Array:
        """Of the cells, at most 1 / ``cells`` of the panel and half a land long."""
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
