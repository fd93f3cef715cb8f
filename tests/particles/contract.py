"""Plans and measurements that every particle solver is tested with."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, cast

import numpy as np
import pytest

from orchestrator.case import solvers
from orchestrator.ports import Array, HermitePath, Motion, Particles
from orchestrator.ports.adapters import ParticlesAdapter
from orchestrator.ports.clock import Interval
from orchestrator.ports.geometry import TriangleSurface
from orchestrator.ports.plans import GrainMaterial, ParticleList, ParticlesPlan, SolverMissing
from tests.grains import SPHERE, spheres

G_M_PER_S2 = np.array([0.0, 0.0, -9.81])
WEIGHTLESS = np.zeros(3)
SOFT = GrainMaterial("soft", 1e7, 0.3)

LIGGGHTS_ALONE = [pytest.param("liggghts", marks=pytest.mark.solver)]
SOLVERS = ["spheres", *LIGGGHTS_ALONE]


def solver_adapter(name: str) -> ParticlesAdapter:
    """Return the adapter of a solver; the test is skipped where the solver is not installed."""
    adapter = solvers.adapter("particles", name)
    try:
        adapter.load()
    except SolverMissing as missing:
        pytest.skip(str(missing))
    return cast("ParticlesAdapter", adapter)


def table(value: float) -> Array:
    """The (1, 1) table of a single material."""
    return np.array([[value]])


def plate(half_m: float, cells: int, probes: int = 0) -> TriangleSurface:
    """A flat square in z = 0 about the origin; probes are points that no triangle uses."""
    x = np.linspace(-half_m, half_m, cells + 1)
    grid = np.stack(np.meshgrid(x, x, [0.0], indexing="ij"), axis=-1).reshape(-1, 3)
    row = np.arange((cells + 1) ** 2).reshape(cells + 1, cells + 1)
    a, b, c, d = row[:-1, :-1], row[1:, :-1], row[1:, 1:], row[:-1, 1:]
    triangles = np.concatenate(
        [np.stack([k.ravel() for k in corners], axis=1) for corners in ((a, b, c), (a, c, d))]
    )
    extra = np.tile([0.0, 0.0, -half_m], (probes, 1))
    return TriangleSurface(
        np.concatenate([grid, extra]), triangles.astype(np.int64), np.zeros(len(triangles), dtype=np.int64)
    )


def particles(
    position_m: Any,
    velocity_m_per_s: Any = (0.0, 0.0, 0.0),
    spin_rad_per_s: Any = (0.0, 0.0, 0.0),
    diameter_m: Any = 0.01,
    density_kg_per_m3: float = 1430.0,
    material: int = 0,
) -> ParticleList:
    position_m = np.atleast_2d(np.asarray(position_m, dtype=float))
    n = len(position_m)

    def rows(value: Any) -> Array:
        return np.broadcast_to(np.asarray(value, dtype=float), (n, 3)).copy()

    return ParticleList(
        position_m,
        rows(velocity_m_per_s),
        rows(spin_rad_per_s),
        spheres(np.broadcast_to(diameter_m, n), density_kg_per_m3, material),
    )


def plan(surface: TriangleSurface, given: ParticleList, **changes: Any) -> ParticlesPlan:
    """One soft material, restitution 0.5, friction 0.3, gravity; ``changes`` replace fields."""
    usual = ParticlesPlan(
        surface=surface,
        materials=(SOFT,),
        restitution=table(0.5),
        sliding_friction=table(0.3),
        rolling_friction=table(0.0),
        particles=given,
        shapes=(SPHERE,),
        largest_radius_m=float(np.max(given.grains.bounding_radius_m, initial=0.005)),
        domain_m=np.array([[-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]]),
        gravity_m_per_s2=G_M_PER_S2,
        step_s=2e-5,
        sync_interval_s=1e-3,
    )
    return replace(usual, **changes)


def at_rest(surface: TriangleSurface) -> Motion:
    return Motion(surface.position_m, np.zeros_like(surface.position_m))


@dataclass
class Run:
    """A solver with its surface, advanced interval by interval; sums up what was handed over."""

    solver: Particles
    plan: ParticlesPlan
    velocity_m_per_s: Array = field(default_factory=lambda: np.zeros(3))  # of the whole surface
    index: int = 0
    load_N: list[Array] = field(default_factory=list)

    @property
    def time_s(self) -> float:
        return self.index * self.plan.sync_interval_s

    @property
    def given_N_s(self) -> Array:
        return self.plan.sync_interval_s * np.sum([load.sum(axis=0) for load in self.load_N], axis=0)

    def motion(self) -> Motion:
        start_m = self.plan.surface.position_m
        velocity_m_per_s = np.broadcast_to(self.velocity_m_per_s, start_m.shape).copy()
        return Motion(start_m + self.time_s * self.velocity_m_per_s, velocity_m_per_s)

    def advance(self, intervals: int = 1) -> None:
        length_s = self.plan.sync_interval_s
        for _ in range(intervals):
            start = self.motion()
            interval, self.index = Interval(self.index, length_s), self.index + 1
            path = HermitePath(start, self.motion(), length_s)
            self.load_N.append(self.solver.advance(interval, path).force_N)

    def until_clear(self, particle: int = 0, most: int = 2000) -> None:
        """Advance until an impact is over: a load came, and then an interval without one."""
        touched = False
        for _ in range(most):
            self.advance()
            now = bool(np.any(self.load_N[-1] != 0.0))
            if touched and not now:
                return
            touched = touched or now
        raise AssertionError(f"no impact was over after {most} intervals")


def energy_defect_J(before: Any, after: Any) -> float:
    """d(stored) + lost - supplied - received between two accounts."""

    def change(name: str) -> float:
        return sum(getattr(after, name).values()) - sum(getattr(before, name).values())

    return change("stored_J") + change("lost_J") - change("supplied_J") - change("received_J")
