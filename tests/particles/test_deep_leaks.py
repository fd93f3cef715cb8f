"""Random impacts on a mat with deep openings that bends and stretches: nobody gets into its material."""

from __future__ import annotations

from contextlib import closing

import numpy as np
import pytest

from orchestrator.case.deck.triangle_grid import perforated_grid
from orchestrator.ports import Array, HermitePath, Motion
from orchestrator.ports.clock import Interval
from orchestrator.ports.geometry import AperturePattern, Rectangle, TriangleSurface
from tests.particles.contract import LIGGGHTS_ALONE, WEIGHTLESS, particles, plan, solver_adapter, table

PANEL = Rectangle(np.zeros(3), np.eye(3)[0], np.eye(3)[1], 0.06, 0.06, 0.03, 0.0)
SLOTS = AperturePattern("rectangle", 0.020, 0.003, 0.025, 0.006, depth_m=0.0059, relief_deg=3.0)
LOW_M, HIGH_M = np.array([-0.007, -0.007, -0.0085]), np.array([0.067, 0.037, 0.0085])
SPEED_M_PER_S, LENGTH_S = 3.0, 2e-4
CURVATURE_1_PER_M, STRAIN, TURN_RAD_PER_S = 4.0, 0.03, 150.0


def bent_m(coordinates_m: Array, time_s: float) -> Array:
    """Places (n, 3) of the mat, which is bent to a circle about its middle, to and fro, and stretched across;
    offsets stand on its normal."""
    bend = CURVATURE_1_PER_M * np.sin(TURN_RAD_PER_S * time_s) or 1e-12
    along_m, offset_m = coordinates_m[:, 0] - 0.03, coordinates_m[:, 2]
    stretch = 1 + STRAIN * np.sin(0.7 * TURN_RAD_PER_S * time_s)
    x = (1 / bend - offset_m) * np.sin(bend * along_m)
    z = 1 / bend - (1 / bend - offset_m) * np.cos(bend * along_m)
    return np.stack([0.03 + x, 0.015 + stretch * (coordinates_m[:, 1] - 0.015), z], axis=1)


def own_m(place_m: Array, time_s: float) -> Array:
    """The coordinates (n, 3) of places, which ``bent_m`` takes to them."""
    bend = CURVATURE_1_PER_M * np.sin(TURN_RAD_PER_S * time_s) or 1e-12
    stretch = 1 + STRAIN * np.sin(0.7 * TURN_RAD_PER_S * time_s)
    x, up = (place_m[:, 0] - 0.03) * np.sign(bend), (1 / bend - place_m[:, 2]) * np.sign(bend)
    offset_m = 1 / bend - np.sign(bend) * np.hypot(x, up)
    along_m = np.arctan2(x, up) / bend
    return np.stack([0.03 + along_m, 0.015 + (place_m[:, 1] - 0.015) / stretch, offset_m], axis=1)


def in_material(coordinates_m: Array) -> Array:
    """Tell which places (n, 3) are inside the mat's material."""
    half_m = SLOTS.depth_m / 2
    below_m = half_m - coordinates_m[:, 2]
    inside = (np.abs(coordinates_m[:, 2]) < half_m) & (np.abs(coordinates_m[:, 0] - 0.03) < 0.03)
    inside &= np.abs(coordinates_m[:, 1] - 0.015) < 0.015
    grown_m = np.tan(np.radians(SLOTS.relief_deg)) * below_m
    for centre in SLOTS.centres_m(PANEL):
        away_m = np.abs(coordinates_m[:, :2] - centre)
        inside &= ~((away_m[:, 0] < 0.010 + grown_m) & (away_m[:, 1] < 0.0015 + grown_m))
    return inside


def closed_box() -> tuple[Array, Array]:
    corners = np.array(np.meshgrid([0, 1], [0, 1], [0, 1], indexing="ij")).reshape(3, -1).T
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [corner for a, b, c, d in faces for corner in ((a, b, c), (a, c, d))]
    return LOW_M + corners * (HIGH_M - LOW_M), np.array(triangles)


def shot(grains: int, seconds: float, seed: int = 1) -> tuple[int, Array, int]:
    """Return how many impacts the mat had at the least, who (grains,) is in its material at the end, and how
    many centres went through a triangle.

    The grains fly in a closed box, without losses.  On average impacts from all sides give two thirds
    of twice the mean momentum (Maxwell); the impulse of all is counted as if they gave all of it.
    """
    grid = perforated_grid(PANEL, SLOTS, (6, 3))
    box_m, box = closed_box()
    count = len(grid.coordinates_m)
    triangles = np.vstack([grid.triangles, box + count])
    surface = TriangleSurface(
        np.vstack([bent_m(grid.coordinates_m, 0.0), box_m]),
        triangles,
        np.zeros(len(triangles), dtype=np.int64),
    )
    random = np.random.default_rng(seed)
    axes = [np.arange(a + 0.0015, b - 0.0015, 0.0028) for a, b in zip(LOW_M, HIGH_M, strict=True)]
    spots = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    beside = np.abs(spots[:, 2]) > 0.0048
    spots = random.permutation(spots[beside])[:grains]
    assert len(spots) == grains
    way = random.normal(size=(grains, 3))
    diameter_m = random.uniform(0.0015, 0.0025, grains)
    given = particles(
        spots, SPEED_M_PER_S * way / np.linalg.norm(way, axis=1)[:, None], diameter_m=diameter_m
    )
    wanted = plan(
        surface,
        given,
        restitution=table(1.0),
        sliding_friction=table(0.0),
        gravity_m_per_s2=WEIGHTLESS,
        step_s=1e-5,
        sync_interval_s=LENGTH_S,
        domain_m=np.array([LOW_M - 0.01, HIGH_M + 0.01]),
    )

    def motion(time_s: float) -> Motion:
        rows = [bent_m(grid.coordinates_m, time_s + late_s) for late_s in (-1e-6, 0.0, 1e-6)]
        still = np.zeros_like(box_m)
        return Motion(np.vstack([rows[1], box_m]), np.vstack([(rows[2] - rows[0]) / 2e-6, still]))

    given_N_s, impacts = 0.0, 0.0
    with closing(solver_adapter("liggghts").build(wanted)) as solver:
        for index in range(round(seconds / LENGTH_S)):
            path = HermitePath(motion(index * LENGTH_S), motion((index + 1) * LENGTH_S), LENGTH_S)
            load = solver.advance(Interval(index, LENGTH_S), path)
            given_N_s += LENGTH_S * float(np.linalg.norm(load.force_N[:count], axis=1).sum())
            if index % 50 == 49:
                now = solver.snapshot()
                momentum = given.grains.mass_kg * np.linalg.norm(now.velocity_m_per_s, axis=1)
                impacts, given_N_s = impacts + given_N_s / (2 * momentum.mean()), 0.0
        now, through = solver.snapshot(), solver.crossings().number
    assert len(now.id) == grains
    return int(impacts), in_material(own_m(now.position_m, seconds)), through


@pytest.mark.parametrize("_", LIGGGHTS_ALONE)
@pytest.mark.parametrize(
    ("seeds", "seconds", "impacts"), [(1, 0.1, 8_000), pytest.param(6, 0.5, 300_000, marks=pytest.mark.slow)]
)
def test_nobody_gets_into_the_material(_: str, seeds: int, seconds: float, impacts: int) -> None:
    """700 grains of 1.5 to 2.5 mm fly at 3 m/s about a mat with slots of 3 x 20 mm.

    The mat is bent by 7 degrees to either side and stretched by 3 %.  They strike sides, walls, edges and
    corners, and none goes through.
    """
    assert in_material(np.array([[0.001, 0.001, 0.0], [0.0175, 0.003, 0.0]])).tolist() == [True, False]
    counted = 0
    for seed in range(1, seeds + 1):
        more, inside, through = shot(700, seconds, seed)
        counted += more
        assert not inside.any()
        assert through == 0
    assert counted >= impacts
