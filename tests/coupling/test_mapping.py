"""The triangles that particles touch, and what goes over to the panel's own mesh."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
from scipy.sparse import csr_array

from orchestrator.case.deck.triangle_grid import TriangleGrid, grid
from orchestrator.coupling.mapping import MappedPanel, OffsetPanel, mapped
from orchestrator.ports import BrokenRecord, Interpolation, Load, Motion
from orchestrator.ports.clock import Interval
from orchestrator.ports.geometry import Rectangle
from tests.panel.contract import StillPanel


def rectangle(clamp_m: float) -> Rectangle:
    along, across = np.array([0.8, 0.0, -0.6]), np.array([0.0, 1.0, 0.0])
    return Rectangle(np.array([0.1, 0.2, 0.3]), along, across, 0.3, 0.31, 0.2, clamp_m)


def corners(mesh: TriangleGrid) -> np.ndarray:
    """(triangles, 3, 2) material coordinates."""
    return np.asarray(mesh.coordinates_m[mesh.triangles])


@pytest.mark.parametrize("cells", [(1, 1), (4, 3), (5, 2)])
@pytest.mark.parametrize("clamp_m", [0.0, 0.02])
def test_every_triangle_faces_the_bed(cells: tuple[int, int], clamp_m: float) -> None:
    """Its corners go round with the panel's normal, on which the bed lies: a positive area in
    material coordinates, and the rectangle's normal in the world.  Together they are the panel."""
    panel = rectangle(clamp_m)
    mesh = grid(panel, cells)
    a, b, c = corners(mesh).transpose(1, 0, 2)
    along, across = b - a, c - a
    area_m2 = (along[:, 0] * across[:, 1] - along[:, 1] * across[:, 0]) / 2
    assert (area_m2 > 0).all()
    assert area_m2.sum() == pytest.approx((0.3 + 2 * clamp_m) * 0.2, rel=1e-12)
    a, b, c = panel.mounted(mesh.coordinates_m)[mesh.triangles].transpose(1, 0, 2)
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    assert normals == pytest.approx(np.tile(panel.normal, (len(normals), 1)), abs=1e-12)


def test_neighbours_share_an_edge_in_opposite_directions() -> None:
    """The directions are opposite since all triangles face the same side; an edge of one triangle alone is
    on the rim."""
    mesh = grid(rectangle(0.02), (4, 3))
    directed = Counter((int(t[k]), int(t[(k + 1) % 3])) for t in mesh.triangles for k in range(3))
    assert set(directed.values()) == {1}
    alone = [edge for edge in directed if edge[::-1] not in directed]
    assert len(alone) == 2 * (4 + 2) + 2 * 3


def test_the_centre_line_runs_along_the_middle() -> None:
    mesh = grid(rectangle(0.02), (4, 2))
    line = mesh.coordinates_m[mesh.centre_line]
    assert line[:, 1] == pytest.approx(np.full(7, 0.1))
    assert (np.diff(line[:, 0]) > 0).all()


@pytest.mark.parametrize("points", [4, 9])
def test_loads_come_down_with_their_force_and_their_work(points: int) -> None:
    """Motion goes up by H, whose rows sum to one, and loads come down by its transpose, so that force
    and virtual work are the same on both sides; also with a square H, which fits either way round."""
    rng = np.random.default_rng(points)
    dense = rng.random((points, 4))
    H = csr_array(dense / dense.sum(axis=1, keepdims=True))
    panel = StillPanel(Motion(*rng.standard_normal((2, 4, 3))))
    seen = MappedPanel(panel, H)
    force_N = rng.standard_normal((points, 3))
    surface = seen.advance(Interval(0, 1e-3), Motion(*np.zeros((2, 1, 3))), Load(force_N)).surface
    assert surface.position_m == pytest.approx(H @ panel.surface.position_m)
    assert seen.initial().surface.velocity_m_per_s == pytest.approx(surface.velocity_m_per_s)
    assert panel.load.force_N.sum(axis=0) == pytest.approx(force_N.sum(axis=0), rel=1e-13)
    power_W = (panel.load.force_N * panel.surface.velocity_m_per_s).sum()
    assert (force_N * surface.velocity_m_per_s).sum() == pytest.approx(power_W, rel=1e-12)


def above_a_line(offset_m: float) -> Interpolation:
    """A point above the middle of the line from the first to the second of three points, whose third makes
    the line a plane."""
    middle, along, across = ([[0.5, 0.5, 0.0]], [[-1.0, 1.0, 0.0]], [[-1.0, 0.0, 1.0]])
    return Interpolation(csr_array(middle), csr_array(along), csr_array(across), np.array([offset_m]))


CORNERS_M = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])


def test_a_point_over_a_turning_plane_goes_round_with_it() -> None:
    """The point is 0.2 m over a plane that turns at 3 rad/s about y: there, and with the velocity that a
    rigid body has; a push of 5 N along x turns the plane's corners about y with 1 N m."""
    turn = np.array([0.0, 3.0, 0.0])
    panel = StillPanel(Motion(CORNERS_M, np.cross(turn, CORNERS_M)))
    surface = mapped(panel, above_a_line(0.2)).initial().surface
    assert surface.position_m.tolist() == [[0.5, 0.0, 0.2]]
    assert surface.velocity_m_per_s == pytest.approx(np.cross(turn, [[0.5, 0.0, 0.2]]), abs=1e-15)
    still = StillPanel(Motion(CORNERS_M, np.zeros((3, 3))))
    seen = mapped(still, above_a_line(0.2))
    seen.advance(Interval(0, 1e-3), Motion(*np.zeros((2, 1, 3))), Load(np.array([[5.0, 0.0, 0.0]])))
    found_N = still.load.force_N
    assert found_N.sum(axis=0) == pytest.approx([5.0, 0.0, 0.0], abs=1e-15)
    assert np.cross(CORNERS_M, found_N).sum(axis=0) == pytest.approx([0.0, 1.0, 0.0], abs=1e-15)


def test_a_load_acts_where_its_points_are_in_the_middle_of_the_interval() -> None:
    """The plane turns by 0.2 rad in an interval of 0.1 s, as its velocity says: the moment about the first
    corner is that of the force at the point after half of it."""
    turn = np.array([0.0, 2.0, 0.0])
    panel = StillPanel(Motion(CORNERS_M, np.cross(turn, CORNERS_M)))
    seen = mapped(panel, above_a_line(0.2))
    force_N = np.array([[1.0, 2.0, 5.0]])
    seen.advance(Interval(0, 0.1), Motion(*np.zeros((2, 1, 3))), Load(force_N))
    middle_m = CORNERS_M + 0.05 * np.cross(turn, CORNERS_M)
    normal = np.cross(middle_m[1] - middle_m[0], middle_m[2] - middle_m[0])
    place_m = (middle_m[0] + middle_m[1]) / 2 + 0.2 * normal / np.linalg.norm(normal)
    moment_N_m = np.cross(middle_m, panel.load.force_N).sum(axis=0)
    assert moment_N_m == pytest.approx(np.cross(place_m, force_N[0]), abs=1e-14)


def test_points_without_an_offset_cost_no_more_than_a_matrix() -> None:
    """The view of a panel without offsets is the plain matrix, and saves nothing of its own."""
    panel = StillPanel(Motion(CORNERS_M, np.zeros((3, 3))))
    plain, beside = mapped(panel, above_a_line(0.0)), mapped(panel, above_a_line(1e-3))
    assert type(plain) is MappedPanel
    assert plain.save() == {}
    assert type(beside) is OffsetPanel
    assert beside.save().keys() == {"panel", "own", "seen", "work_beyond_own_J"}


def test_a_surface_without_a_normal_is_refused() -> None:
    """Its three corners lie on one line."""
    folded_m = CORNERS_M * [1.0, 0.0, 0.0]
    seen = mapped(StillPanel(Motion(folded_m, np.zeros((3, 3)))), above_a_line(0.2))
    with pytest.raises(BrokenRecord, match=r"^Motion\.position_m:"):
        seen.initial()
