"""Small plans for the tests of the LIGGGHTS adapter: one stiff particle material on a surface."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from orchestrator.ports import Array, HermitePath, Motion, Particles
from orchestrator.ports.clock import Interval
from orchestrator.ports.geometry import TriangleSurface
from orchestrator.ports.plans import GrainMaterial, ParticleList, ParticlesPlan
from tests import grains

INTERVAL_S = 5e-5


def spheres(
    position_m: Any,
    velocity_m_per_s: Any = (0.0, 0.0, 0.0),
    diameter_m: Any = 5e-3,
    density_kg_per_m3: float = 2500.0,
    spin_rad_per_s: Any = (0.0, 0.0, 0.0),
) -> ParticleList:
    position_m = np.atleast_2d(np.asarray(position_m, dtype=float))
    n = len(position_m)
    return ParticleList(
        position_m,
        np.array(np.broadcast_to(velocity_m_per_s, (n, 3)), dtype=float),
        np.array(np.broadcast_to(spin_rad_per_s, (n, 3)), dtype=float),
        grains.spheres(np.broadcast_to(diameter_m, n), density_kg_per_m3),
    )


def sheet(height: Any, x_m: Array, y_m: Array) -> TriangleSurface:
    """Triangles over a grid of points (x, y, height(x, y)), all of material 1."""
    x, y = np.meshgrid(x_m, y_m, indexing="ij")
    points = np.stack([x, y, np.broadcast_to(height(x, y), x.shape)], axis=-1).reshape(-1, 3)
    number = np.arange(x.size).reshape(x.shape)
    a, b, c, d = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
    corners = [np.stack(t, axis=-1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))]
    triangles = np.concatenate(corners)
    return TriangleSurface(points, triangles, np.ones(len(triangles), dtype=np.int64))


def flat(half_m: float = 0.02, cells: int = 8) -> TriangleSurface:
    line = np.linspace(-half_m, half_m, cells + 1)
    return sheet(lambda x, y: 0.0 * x, line, line)


def make_plan(surface: TriangleSurface, particles: ParticleList, **changes: Any) -> ParticlesPlan:
    """Elastic and smooth, without gravity, unless ``changes`` say otherwise; a single number for
    a law means all material pairs."""
    for law in ("restitution", "sliding_friction", "rolling_friction"):
        if law in changes:
            changes[law] = np.full((2, 2), float(changes[law]))
    plan = ParticlesPlan(
        surface=surface,
        materials=(GrainMaterial("grain", 1e8, 0.3), GrainMaterial("panel", 2e8, 0.25)),
        restitution=np.ones((2, 2)),
        sliding_friction=np.zeros((2, 2)),
        rolling_friction=np.zeros((2, 2)),
        particles=particles,
        shapes=(grains.SPHERE,),
        largest_radius_m=float(particles.grains.bounding_radius_m.max()),
        domain_m=np.array([[-0.1, -0.1, -0.1], [0.1, 0.1, 0.1]]),
        gravity_m_per_s2=np.zeros(3),
        step_s=1e-6,
        sync_interval_s=INTERVAL_S,
    )
    return replace(plan, **changes)


def still(surface: TriangleSurface) -> Motion:
    return Motion(surface.position_m.copy(), np.zeros_like(surface.position_m))


def travel(solver: Particles, motion_at: Any, intervals: range, length_s: float = INTERVAL_S) -> list[Array]:
    """Advance through ``intervals`` with the surface at ``motion_at(time_s)``; the total force on
    the surface in each."""
    forces = []
    for index in intervals:
        interval = Interval(index, length_s)
        path = HermitePath(motion_at(interval.start_s), motion_at(interval.end_s), length_s)
        forces.append(solver.advance(interval, path).force_N.sum(axis=0))
    return forces
