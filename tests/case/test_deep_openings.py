"""The triangles of openings with a depth, and the keys that ask for them."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from orchestrator.case.deck.triangle_grid import TriangleGrid, perforated_grid
from orchestrator.ports import Array
from orchestrator.ports.geometry import LOWER, UPPER, WALL, AperturePattern, Rectangle

PANEL = Rectangle(np.zeros(3), np.eye(3)[0], np.eye(3)[1], 0.3, 0.3, 0.2, 0.02)
SLOTS = AperturePattern("rectangle", 0.020, 0.003, 0.025, 0.006, 0.0, 0.02, 0.02)
STAGGERED = AperturePattern("slot", 0.012, 0.004, 0.018, 0.008, 0.5, 0.02, 0.02)
DEPTH_M = 0.0059


def made(pattern: AperturePattern) -> tuple[TriangleGrid, Array]:
    """The grid, and the corners (m, 3, 3) of its triangles on the straight panel."""
    grid = perforated_grid(PANEL, pattern, (20, 20))
    return grid, PANEL.mounted(grid.coordinates_m)[grid.triangles]


def area_m2(polygon: Array) -> float:
    x, y = polygon.T
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2


@pytest.mark.parametrize("thin", [SLOTS, STAGGERED], ids=["rectangles", "slots"])
@pytest.mark.parametrize("relief_deg", [0.0, 4.0, -4.0])
def test_the_surface_is_closed_and_encloses_the_material(thin: AperturePattern, relief_deg: float) -> None:
    """Each edge has two triangles, which run through it to and fro, so that no gap is left. The volume
    inside, by the divergence theorem, is the panel's less that of the openings, whose walls are planes: a
    frustum of the outline and of the same outline grown by the relief (Simpson's rule is exact for it)."""
    pattern = replace(thin, depth_m=DEPTH_M, relief_deg=relief_deg)
    grid, corners_m = made(pattern)
    edges = Counter((int(t[k]), int(t[(k + 1) % 3])) for t in grid.triangles for k in range(3))
    assert set(edges.values()) == {1}
    assert all((b, a) in edges for a, b in edges)
    upper = thin.outline_m()
    sections = []
    for below_m in (0.0, DEPTH_M / 2, DEPTH_M):
        grown_m = below_m * np.tan(np.radians(relief_deg))
        if thin.shape == "rectangle":
            sections.append(area_m2(upper + np.sign(upper) * grown_m))
        else:
            core = np.clip(upper[:, 0], -0.004, 0.004)[:, None] * [1.0, 0.0]
            sections.append(area_m2(core + (upper - core) * (1 + grown_m / 0.002)))
    open_m3 = DEPTH_M * (sections[0] + 4 * sections[1] + sections[2]) / 6 * len(thin.centres_m(PANEL))
    volume_m3 = np.linalg.det(corners_m).sum() / 6
    assert volume_m3 == pytest.approx(0.34 * 0.2 * DEPTH_M - open_m3, rel=1e-12)


def test_the_upper_side_is_that_of_thin_rims_and_walls_stand_between() -> None:
    """Upper triangles are bit for bit those of thin rims, half a depth up; lower ones are turned over."""
    thin, _ = made(SLOTS)
    deep, corners_m = made(replace(SLOTS, depth_m=DEPTH_M))
    assert thin.side is None
    assert thin.coordinates_m.shape[1] == 2
    assert deep.side is not None
    count = len(thin.triangles)
    upper, lower = deep.side == UPPER, deep.side == LOWER
    assert np.array_equal(deep.triangles[upper], thin.triangles)
    assert np.array_equal(deep.coordinates_m[thin.triangles, :2], thin.coordinates_m[thin.triangles])
    assert upper.sum() == lower.sum() == count
    assert (corners_m[upper][..., 2] == DEPTH_M / 2).all()
    assert (corners_m[lower][..., 2] == -DEPTH_M / 2).all()
    normal = np.cross(corners_m[:, 1] - corners_m[:, 0], corners_m[:, 2] - corners_m[:, 0])
    assert (normal[upper, 2] > 0).all()
    assert (normal[lower, 2] < 0).all()
    assert normal[deep.side == WALL, 2] == pytest.approx(0.0, abs=1e-18)


def test_points_that_are_only_observed_stay_in_the_middle_surface() -> None:
    grid, _ = made(replace(SLOTS, depth_m=DEPTH_M))
    assert (grid.coordinates_m[grid.centre_line, 2] == 0.0).all()
    assert not np.isin(grid.centre_line, grid.triangles).any()
    assert len(np.unique(grid.triangles)) + len(grid.centre_line) == len(grid.coordinates_m)


def test_walls_lean_by_the_relief() -> None:
    """Each wall of an opening leaves the normal by 4 degrees, outwards below."""
    pattern = replace(SLOTS, depth_m=DEPTH_M, relief_deg=4.0)
    grid, corners_m = made(pattern)
    assert grid.side is not None
    walls_m = corners_m[grid.side == WALL]
    normal = np.cross(walls_m[:, 1] - walls_m[:, 0], walls_m[:, 2] - walls_m[:, 0])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    inside = (walls_m[..., 0] > 0.001).all(axis=1) & (walls_m[..., 0] < 0.299).all(axis=1)
    inside &= (walls_m[..., 1] > 0.001).all(axis=1) & (walls_m[..., 1] < 0.199).all(axis=1)
    assert inside.sum() > 1000
    assert np.degrees(np.arcsin(-normal[inside, 2])) == pytest.approx(4.0, abs=1e-6)


def test_sections() -> None:
    pattern = replace(SLOTS, depth_m=0.006, relief_deg=5.0)
    grown_m = 0.006 * np.tan(np.radians(5.0))
    assert pattern.section(0.006).width_m == pytest.approx(0.003 + 2 * grown_m)
    assert pattern.mean_section.length_m == pytest.approx(0.020 + grown_m)
    assert pattern.narrowest_section.width_m == 0.003
    assert replace(pattern, relief_deg=-5.0).narrowest_section.width_m == pytest.approx(0.003 - 2 * grown_m)
    assert SLOTS.mean_section is SLOTS
