"""The published JKR self-test, and what the tests of adhesion measure on every solver.

Two spheres of 1 mm radius, E = 1e7 Pa, nu = 0.3, w = 0.05 J/m2, rho = 2500 kg/m3: pull-off
distance -5.566e-7 m, critical sticking speed 4.84e-3 m/s, area of the hysteresis loop
7.09 (w^5 R*^4 / E*^2)^(1/3).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from orchestrator.ports import Array, HermitePath, Motion, Particles
from orchestrator.ports.clock import Interval
from orchestrator.ports.geometry import TriangleSurface
from orchestrator.ports.plans import GrainMaterial, Jkr, ParticlesPlan
from tests.particles.liggghts_plans import flat, make_plan, spheres

RADIUS_M, WORK_J_PER_M2, DENSITY_KG_PER_M3 = 1e-3, 0.05, 2500.0
STICKY = GrainMaterial("sticky", 1e7, 0.3)
HEAVY_KG_PER_M3 = 1e16  # so heavy that no contact moves it within a test


@dataclass(frozen=True)
class Known:
    """Answers of the theory: Johnson, Kendall and Roberts 1971, doi 10.1098/rspa.1971.0141;
    Thornton, C. and Ning, Z., Powder Technol. 99, 1998, 154-162, for work and sticking speed."""

    radius_m: float  # reduced
    work_J_per_m2: float = WORK_J_PER_M2
    e_star_Pa: float = 1e7 / 2 / (1 - 0.3**2)

    @property
    def pull_off_N(self) -> float:
        return 1.5 * math.pi * self.work_J_per_m2 * self.radius_m

    @property
    def separation_m(self) -> float:
        """Overlap, below zero."""
        length_m3 = math.pi**2 * self.work_J_per_m2**2 * self.radius_m / self.e_star_Pa**2
        return -0.75 * math.pow(length_m3, 1 / 3)

    @property
    def _unit_J(self) -> float:
        return math.pow(self.work_J_per_m2**5 * self.radius_m**4 / self.e_star_Pa**2, 1 / 3)

    @property
    def loop_J(self) -> float:
        return 7.09 * self._unit_J

    def sticking_m_per_s(self, reduced_kg: float) -> float:
        return math.sqrt(14.18 / reduced_kg * self._unit_J)


PAIR = Known(RADIUS_M / 2)
PLANE = Known(RADIUS_M)


def plan_of(position_m: Any, velocity_m_per_s: Any = (0.0, 0.0, 0.0), **changes: Any) -> ParticlesPlan:
    """Sticky spheres, elastic and smooth, over a flat sheet of the same."""
    density = changes.pop("density_kg_per_m3", DENSITY_KG_PER_M3)
    grains = spheres(position_m, velocity_m_per_s, 2 * RADIUS_M, density)
    plan = make_plan(
        changes.pop("surface", flat()),
        grains,
        materials=(STICKY, STICKY),
        adhesion=Jkr(np.full((2, 2), WORK_J_PER_M2), 1e-3),
        step_s=5e-6,
        sync_interval_s=1e-4,
    )
    for law in ("restitution", "sliding_friction", "rolling_friction"):
        if law in changes:
            changes[law] = np.full((2, 2), float(changes[law]))
    return replace(plan, **changes)


@dataclass
class Puller:
    """Moves the surface as it is told, interval by interval."""

    solver: Particles
    plan: ParticlesPlan
    shift_m: Array  # of the whole surface, since t = 0
    index: int = 0

    def pull(self, velocity_m_per_s: Any, intervals: int) -> tuple[Array, Array]:
        """Mean force on the surface, and its shift in the middle of each interval, (n, 3)."""
        length_s = self.plan.sync_interval_s
        start_m = self.plan.surface.position_m
        velocity_m_per_s = np.broadcast_to(velocity_m_per_s, start_m.shape).astype(float)
        forces, shifts = [], []
        for _ in range(intervals):
            end_m = self.shift_m + length_s * velocity_m_per_s[0]
            path = HermitePath(
                Motion(start_m + self.shift_m, velocity_m_per_s),
                Motion(start_m + end_m, velocity_m_per_s),
                length_s,
            )
            load = self.solver.advance(Interval(self.index, length_s), path)
            self.index += 1
            forces.append(load.force_N.sum(axis=0))
            shifts.append(0.5 * (self.shift_m + end_m))
            self.shift_m = end_m
        return np.array(forces), np.array(shifts)


def on_surface(module: Any, surface: TriangleSurface, **changes: Any) -> Puller:
    """A heavy sphere that just does not touch the surface below the origin."""
    plan = plan_of(
        [0.0003, 0.0002, RADIUS_M + 1e-8], surface=surface, density_kg_per_m3=HEAVY_KG_PER_M3, **changes
    )
    return Puller(module.build(plan), plan, np.zeros(3))
