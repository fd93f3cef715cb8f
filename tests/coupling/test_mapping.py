"""The triangles that particles touch, and what goes over to the panel's own mesh."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
from scipy.sparse import csr_array

from orchestrator.case.deck.triangle_grid import TriangleGrid, grid
from orchestrator.coupling.mapping import MappedPanel
from orchestrator.ports import Account, Load, Motion, Mount, PanelState, Saved
from orchestrator.ports.clock import Interval
from orchestrator.ports.geometry import Rectangle


def rectangle(clamp_m: float) -> Rectangle:
    along, across = np.array([0.8, 0.0, -0.6]), np.array([0.0, 1.0, 0.0])
    return Rectangle(np.array([0.1, 0.2, 0.3]), along, across, 0.3, 0.31, 0.2, clamp_m)


def corners(found: TriangleGrid) -> np.ndarray:
    """(triangles, 3, 2) material coordinates."""
    return np.asarray(found.coordinates_m[found.triangles])


@pytest.mark.parametrize("cells", [(1, 1), (4, 3), (5, 2)])
@pytest.mark.parametrize("clamp_m", [0.0, 0.02])
def test_every_triangle_faces_the_bed(cells: tuple[int, int], clamp_m: float) -> None:
    """Its corners go round with the panel's normal, on which the bed lies: a positive area in
    material coordinates, and the rectangle's normal in the world.  Together they are the panel."""
    panel = rectangle(clamp_m)
    found = grid(panel, cells)
    a, b, c = corners(found).transpose(1, 0, 2)
    one, two = b - a, c - a
    area_m2 = (one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0]) / 2
    assert (area_m2 > 0).all()
    assert area_m2.sum() == pytest.approx((0.3 + 2 * clamp_m) * 0.2, rel=1e-12)
    a, b, c = panel.mounted(found.coordinates_m)[found.triangles].transpose(1, 0, 2)
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    assert normals == pytest.approx(np.tile(panel.normal, (len(normals), 1)), abs=1e-12)


def test_neighbours_share_an_edge_in_opposite_directions() -> None:
    """As they must where all face the same side; an edge of one triangle alone is on the rim."""
    found = grid(rectangle(0.02), (4, 3))
    directed = Counter((int(t[k]), int(t[(k + 1) % 3])) for t in found.triangles for k in range(3))
    assert set(directed.values()) == {1}
    alone = [edge for edge in directed if edge[::-1] not in directed]
    assert len(alone) == 2 * (4 + 2) + 2 * 3


def test_the_centre_line_runs_along_the_middle() -> None:
    found = grid(rectangle(0.02), (4, 2))
    line = found.coordinates_m[found.centre_line]
    assert line[:, 1] == pytest.approx(np.full(7, 0.1))
    assert (np.diff(line[:, 0]) > 0).all()


class Recorder:
    """A panel of four points at rest that keeps the load it was given."""

    def __init__(self, rng: np.random.Generator) -> None:
        self.motion = Motion(*rng.standard_normal((2, 4, 3)))
        self.mount = Mount(np.zeros((1, 3)), ("frame",))
        self.load = Load.zero(4)

    def initial(self) -> PanelState:
        return PanelState(self.motion, Load.zero(1))

    def advance(self, interval: Interval, clamps: Motion, load: Load) -> PanelState:
        self.load = load
        return PanelState(self.motion, Load.zero(1))

    def account(self) -> Account:
        raise NotImplementedError

    def save(self) -> Saved:
        return {}

    def restore(self, saved: Saved) -> None:
        pass

    def close(self) -> None:
        pass


@pytest.mark.parametrize("points", [4, 9])
def test_loads_come_down_with_their_force_and_their_work(points: int) -> None:
    """Motion goes up by H, whose rows sum to one, and loads come down by its transpose, so that force
    and virtual work are the same on both sides; also with a square H, which fits either way round."""
    rng = np.random.default_rng(points)
    dense = rng.random((points, 4))
    H = csr_array(dense / dense.sum(axis=1, keepdims=True))
    panel = Recorder(rng)
    seen = MappedPanel(panel, H)
    force_N = rng.standard_normal((points, 3))
    surface = seen.advance(Interval(0, 1e-3), Motion(*np.zeros((2, 1, 3))), Load(force_N)).surface
    assert surface.position_m == pytest.approx(H @ panel.motion.position_m)
    assert seen.initial().surface.velocity_m_per_s == pytest.approx(surface.velocity_m_per_s)
    assert panel.load.force_N.sum(axis=0) == pytest.approx(force_N.sum(axis=0), rel=1e-13)
    power_W = (panel.load.force_N * panel.motion.velocity_m_per_s).sum()
    assert (force_N * surface.velocity_m_per_s).sum() == pytest.approx(power_W, rel=1e-12)
