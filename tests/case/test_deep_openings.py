"""The triangles of openings with a depth, and the keys that ask for them."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from orchestrator.case.deck.panels import single_panels
from orchestrator.case.deck.triangle_grid import TriangleGrid, perforated_grid
from orchestrator.case.solver_plans import panel_plans
from orchestrator.ports import Array
from orchestrator.ports.geometry import LOWER, UPPER, WALL, AperturePattern, Rectangle
from tests.cases import CASE, kinds, load_case, only_complaint

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


KEY = "screen.panels.deck.apertures."
SIZES = "length_m=0.02, width_m=0.003, pitch_along_m=0.025, pitch_across_m=0.006"
SLOTTED = f"screen.panels.deck.apertures={{{SIZES}}}"
WALLED = f"{KEY}rims=deep"


def test_the_depth_is_the_panel_s_thickness_unless_it_is_given(tmp_path: Path) -> None:
    for number, (given, depth_m) in enumerate((([], 0.004), ([f"{KEY}depth_m=0.006"], 0.006))):
        case = load_case(tmp_path / str(number), CASE, [SLOTTED, WALLED, *given]).case
        (panel,) = single_panels(case)
        assert panel.apertures is not None
        assert (panel.apertures.depth_m, panel.apertures.relief_deg) == (depth_m, 0.0)
    (thin,) = single_panels(load_case(tmp_path / "thin", CASE, [SLOTTED]).case)
    assert thin.apertures is not None
    assert thin.apertures.depth_m == 0.0


def test_a_panel_has_the_mass_of_the_section_half_way_down(tmp_path: Path) -> None:
    """Openings of 20 x 3 mm in cells of 25 x 6 mm, 4 mm deep with 5 degrees, are longer and wider by
    0.35 mm."""
    (plan,) = panel_plans(load_case(tmp_path, CASE, [SLOTTED, WALLED, f"{KEY}relief_deg=5"]).case)
    assert plan.apertures is not None
    grown_m = 0.004 * np.tan(np.radians(5.0))
    assert plan.apertures.solid_share == pytest.approx(1 - (0.02 + grown_m) * (0.003 + grown_m) / 0.00015)


@pytest.mark.parametrize(
    ("changes", "wanted"),
    [
        (["rims=deep", "relief_deg=-25"], "relief_deg: out-of-range"),
        (["rims=deep", "relief_deg=25"], "relief_deg: out-of-range"),
        (["rims=deep", "relief_deg=60"], "relief_deg: out-of-range"),
        (["rims=deep", "depth_m=-0.001"], "depth_m: out-of-range"),
        (["rims=depe"], "rims: unknown-name"),
        (["depth_m=0.006"], "depth_m: conflict"),
        (["relief_deg=0.0"], "relief_deg: conflict"),
    ],
)
def test_walls_that_cannot_be(tmp_path: Path, changes: list[str], wanted: str) -> None:
    """3 mm are closed by 25 degrees over 4 mm from both sides, and lands of 3 mm are gone by as much."""
    assert kinds(tmp_path, SLOTTED, *(KEY + change for change in changes)) == [KEY + wanted]


def test_a_relief_that_closes_says_which_one_would_do(tmp_path: Path) -> None:
    """Half of 3 mm over 4 mm are 20.6 degrees."""
    complaint = only_complaint(tmp_path, SLOTTED, WALLED, f"{KEY}relief_deg=-25")
    assert "closes openings of 0.003 m" in complaint
    assert "-20.6 degrees" in complaint


@pytest.mark.parametrize(
    ("along_m", "height_m", "size_m", "said"),
    [
        (0.151, 0.0, 0.001, True),
        (0.1384, 0.0, 0.001, False),
        (0.151, 0.0124, 0.02, True),
        (0.151, 0.0126, 0.02, False),
    ],
)
def test_particles_at_the_start_are_clear_of_the_material(
    tmp_path: Path, along_m: float, height_m: float, size_m: float, is_told: bool
) -> None:
    """The depth is 5 mm: a sphere of 1 mm within a land touches no side and is refused, in an opening it is
    not; one of 20 mm overlaps the upper side from 12.5 mm over the middle surface on."""
    place = f"bed.particles.ball.position_m=[{along_m}, 0.1, {height_m}]"
    given = [place, f"bed.particles.ball.sieve_size_m={size_m}", WALLED, f"{KEY}depth_m=0.005"]
    refused = "bed.particles.ball.position_m: misplaced" in kinds(tmp_path, SLOTTED, *given)
    assert refused is is_told
