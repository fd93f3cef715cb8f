"""Worn volumes as depths: at points, and in patches of a panel."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator.case.deck.triangle_grid import grid
from orchestrator.coupling.machine import PanelPoints
from orchestrator.output.records.wear_record import PATCHES, WearRecord, vertex_area_m2
from orchestrator.ports.geometry import Rectangle, TriangleSurface

AT = Rectangle(
    corner_m=np.array([0.1, 0.2, 0.3]),
    along=np.array([0.6, 0.0, -0.8]),
    across=np.array([0.0, 1.0, 0.0]),
    length_m=0.3,
    span_m=0.3,
    width_m=0.2,
    clamp_m=0.02,
)
NONE = np.empty(0, dtype=np.int64)


def record(cells: tuple[int, int] = (16, 8)) -> tuple[WearRecord, TriangleSurface]:
    """A panel behind two points of something else."""
    made = grid(AT, cells)
    position_m = np.vstack([np.full((2, 3), 9.0), AT.mounted(made.coordinates_m)])
    triangles = made.triangles + 2
    surface = TriangleSurface(position_m, triangles, np.zeros(len(triangles), dtype=np.int64))
    panel = PanelPoints(
        "deck",
        surface=slice(2, len(position_m)),
        clamps=slice(0),
        centre_line=NONE,
        shape=NONE,
        first_clamp=NONE,
        second_clamp=NONE,
        stops=NONE,
        edges=NONE,
        edge_length_m=np.empty(0),
    )
    return WearRecord(surface, [panel], [AT]), surface


def test_areas_add_up() -> None:
    area_m2 = vertex_area_m2(record()[1])
    assert area_m2.sum() == pytest.approx(0.34 * 0.2, rel=1e-12)  # with both clamps
    assert (area_m2[:2] == 0.0).all()


def test_even_wear_is_even_everywhere() -> None:
    wear, surface = record()
    worn_m3 = 1e-5 * vertex_area_m2(surface)
    depth_m = wear.vertex_depth_m(worn_m3)
    np.testing.assert_allclose(depth_m[2:], 1e-5, rtol=1e-12)
    assert (depth_m[:2] == 0.0).all()
    group = wear.groups(worn_m3)["wear/deck"]
    np.testing.assert_allclose(group["depth_m"], np.full(PATCHES, 1e-5), rtol=1e-12)
    assert group["worn_m3"] == pytest.approx(1e-5 * 0.34 * 0.2, rel=1e-12)
    assert group["mean_m"] == pytest.approx(1e-5, rel=1e-12)


def test_a_spot_is_in_its_patch() -> None:
    """The spot is at 0.7 of the length and 3/8 of the width: patch 5 of 8 along, 1 of 4 across."""
    wear, surface = record()
    spot_m = AT.corner_m + 0.7 * 0.3 * AT.along + 0.375 * 0.2 * AT.across
    worn_m3 = np.zeros(len(surface.position_m))
    worn_m3[np.argmin(np.linalg.norm(surface.position_m - spot_m, axis=1))] = 1e-9
    depth_m = np.asarray(wear.groups(worn_m3)["wear/deck"]["depth_m"])
    assert np.unravel_index(depth_m.argmax(), PATCHES) == (5, 1)
    assert (depth_m > 0).sum() <= 4  # a cell around the spot reaches into patches beside it


@pytest.mark.parametrize("cells", [(16, 2), (7, 3), (20, 5)])
def test_patches_divide_a_panel_evenly_whatever_its_cells(cells: tuple[int, int]) -> None:
    """A depth that grows from side to side is in each patch that of its middle."""
    wear, surface = record(cells)
    across_m = (surface.position_m - AT.corner_m) @ AT.across
    worn_m3 = across_m * vertex_area_m2(surface)
    depth_m = np.asarray(wear.groups(worn_m3)["wear/deck"]["depth_m"])
    middles_m = 0.2 * (np.arange(4) + 0.5) / 4
    np.testing.assert_allclose(depth_m, np.tile(middles_m, (8, 1)), rtol=0.02)
    mirrored = (0.2 - across_m) * vertex_area_m2(surface)
    other_m = np.asarray(wear.groups(mirrored)["wear/deck"]["depth_m"])
    np.testing.assert_allclose(other_m[:, ::-1], depth_m, rtol=0.02)
