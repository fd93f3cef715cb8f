"""A freely formed heap: grains trickle on a round plate with a low rim until they run over its edge.

The plate is of the grains' own material, as a floor that is covered with them.  Those that run over the rim
fall out of the domain, so that the slope of the heap depends on the grains and not on the floor.
"""

from __future__ import annotations

import math
from contextlib import closing
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from orchestrator.case.bed.packing import random_orientations
from orchestrator.ports import Array
from orchestrator.ports.adapters import ParticlesAdapter
from orchestrator.ports.clock import Interval
from orchestrator.ports.geometry import TriangleSurface
from orchestrator.ports.grains import Shape, ShapeTable
from orchestrator.ports.plans import GrainMaterial, ParticleList
from tests.grains import SPHERE
from tests.particles.liggghts_plans import make_plan, spheres, still, travel

DIAMETER_M, DENSITY_KG_PER_M3 = 0.01, 2650.0
SIZES = (0.9, 1.0, 1.1)  # shares of the mean diameter, so that the grains do not crystallise
MODULUS_PA, POISSON_RATIO = 1e7, 0.3
STEP_S, INTERVAL_S = 1e-4, 2e-3
CORNERS = 48  # of the round plate
STEEP, PACKED = 0.8, 0.55  # slope and share of solid of the heap for which grains are counted
FILLED = 1.4  # grains poured over those of that heap
PAUSE_S = 0.6  # for coming to rest


@dataclass
class Trickle:
    """A feed that drops grains one by one, from a little above the heap's top, within a small circle."""

    number: int
    seed: int
    shape: Shape
    every: int = 2
    above_m: float = 1.5 * DIAMETER_M
    within_m: float = 1.5 * DIAMETER_M
    top_m: float = 0.0
    given: int = 0
    random: np.random.Generator = field(init=False)

    def __post_init__(self) -> None:
        self.random = np.random.default_rng(self.seed)

    def due(self, interval: Interval) -> ParticleList:
        """Return one grain every few intervals, until all have been given."""
        if interval.index % self.every or self.given >= self.number:
            return spheres(np.zeros((0, 3)))
        self.given += 1
        angle = self.random.uniform(0.0, 2 * math.pi)
        out_m = self.within_m * math.sqrt(self.random.uniform())
        place_m = [out_m * math.cos(angle), out_m * math.sin(angle), self.top_m + self.above_m]
        diameter_m = DIAMETER_M * self.random.choice(SIZES)
        return self.grain(place_m, (0.0, 0.0, -0.3), diameter_m)

    def grain(self, place_m: list[float], velocity_m_per_s: tuple[float, ...], size_m: float) -> ParticleList:
        """Return one grain, turned by chance unless it is a sphere."""
        ball = spheres(place_m, velocity_m_per_s, size_m, DENSITY_KG_PER_M3)
        grains = replace(ball.grains, shapes=ShapeTable.of([self.shape]))
        anyhow = random_orientations(1, self.random) if len(self.shape.spheres) > 1 else ball.orientation
        return replace(ball, grains=grains, orientation=anyhow)

    def settle(self, accepted: npt.NDArray[np.bool_]) -> None:
        """Count again a grain that found no room."""
        self.given -= int(np.sum(~accepted))


def round_plate(radius_m: float, rim_m: float) -> TriangleSurface:
    """Return a round plate in z = 0 with a rim of some height, all of material 1."""
    turn = np.linspace(0.0, 2 * math.pi, CORNERS, endpoint=False)
    ring_m = radius_m * np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=1)
    points_m = np.concatenate([np.zeros((1, 3)), ring_m, ring_m + np.array([0.0, 0.0, rim_m])])
    low = 1 + np.arange(CORNERS)
    after = 1 + (np.arange(CORNERS) + 1) % CORNERS
    plate = np.stack([np.zeros(CORNERS, dtype=np.int64), low, after], axis=1)
    wall = [
        np.stack([low, after, after + CORNERS], axis=1),
        np.stack([low, after + CORNERS, low + CORNERS], axis=1),
    ]
    triangles = np.concatenate([plate, *wall]).astype(np.int64)
    return TriangleSurface(points_m, triangles, np.ones(len(triangles), dtype=np.int64))


def poured_slopes_deg(
    module: ParticlesAdapter,
    *,
    sliding_friction: float,
    rolling_friction: float,
    restitution: float,
    radius_diameters: float = 10.0,
    rolling: str = "epsd2",
    seed: int = 1,
    heaps: int = 8,
    shape: Shape = SPHERE,
) -> list[float]:
    """Return the slopes in degrees of heaps at rest, one after another on one plate.

    Grains are poured until far more than the plate holds have run over it.  After each pause, in which the
    heap comes to rest, a tenth of its grains follows, so that avalanches make each heap another one.
    """
    radius_m = radius_diameters * DIAMETER_M
    surface = round_plate(radius_m, 0.5 * DIAMETER_M)
    full = round(2 * STEEP * PACKED * radius_diameters**3)  # grains of a cone of this slope
    feed = Trickle(round(FILLED * full), seed, shape)
    thick_m = 2 * shape.bounding_radius * DIAMETER_M  # of a sphere, its diameter
    first = feed.grain([0.0, 0.0, 0.6 * thick_m], (0.0, 0.0, 0.0), DIAMETER_M)
    reach_m = radius_m + 2 * DIAMETER_M
    plan = make_plan(
        surface,
        first,
        materials=(GrainMaterial("grain", MODULUS_PA, POISSON_RATIO),) * 2,
        restitution=restitution,
        sliding_friction=sliding_friction,
        rolling_friction=rolling_friction,
        rolling=rolling,
        gravity_m_per_s2=np.array([0.0, 0.0, -9.81]),
        domain_m=np.array([[-reach_m, -reach_m, -3 * DIAMETER_M], [reach_m, reach_m, radius_m + 0.1]]),
        shapes=(shape,),
        largest_radius_m=max(SIZES) * thick_m / 2,
        step_s=STEP_S,
        sync_interval_s=INTERVAL_S,
        feed=feed,
    )
    slopes_deg = []
    with closing(module.build(plan)) as solver:
        done = 0

        def go_on(intervals: int) -> None:
            nonlocal done
            travel(solver, lambda _: still(surface), range(done, done + intervals), INTERVAL_S)
            done += intervals
            now = solver.snapshot()
            slow = np.linalg.norm(now.velocity_m_per_s, axis=1) < 0.1
            near = np.hypot(*now.position_m[:, :2].T) < 2.5 * DIAMETER_M
            feed.top_m = float(now.position_m[near & slow, 2].max(initial=0.0)) + 0.5 * DIAMETER_M

        for _ in range(heaps):
            while feed.given < feed.number:
                go_on(20)
            go_on(round(PAUSE_S / INTERVAL_S))
            now = solver.snapshot()
            slopes_deg.append(slope_deg(now.position_m, now.grains.sieve_size_m, radius_m))
            feed.number += full // 10
    return slopes_deg


def slope_deg(position_m: Array, diameter_m: Array, radius_m: float) -> float:
    """Return the slope in degrees of a line through the mean height of a heap's surface at each radius.

    The surface of a ring of one diameter's width is the mean of the highest grains in its sectors.  The top
    and the ring at the rim are left out.
    """
    out_m = np.hypot(position_m[:, 0], position_m[:, 1])
    turn = np.arctan2(position_m[:, 1], position_m[:, 0]) / (2 * math.pi) % 1.0
    top_m = position_m[:, 2] + diameter_m / 2
    radii_m = np.arange(2.5, radius_m / DIAMETER_M - 1) * DIAMETER_M
    heights_m = []
    for ring_m in radii_m:
        inside = np.abs(out_m - ring_m) < DIAMETER_M / 2
        sectors = round(2 * math.pi * ring_m / (1.5 * DIAMETER_M))
        sector = np.floor(turn[inside] * sectors)
        heights_m.append(np.mean([top_m[inside][sector == k].max() for k in np.unique(sector)]))
    return math.degrees(math.atan(-np.polyfit(radii_m, heights_m, 1)[0]))
