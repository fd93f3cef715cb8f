"""Rigid surfaces, which four points carry, against the same triangles with points of their own."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from importlib import import_module
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from orchestrator.ports import Array, HermitePath, Motion, Particles
from orchestrator.ports.clock import Interval
from orchestrator.ports.geometry import RigidVertices, TriangleSurface, shares_in, tetrahedron_m
from orchestrator.ports.plans import ParticlesPlan
from tests.particles.folds import pit
from tests.particles.liggghts_plans import INTERVAL_S, flat, make_plan, spheres

SPIN_RAD_PER_S = np.array([20.0, -35.0, 15.0])
SPEED_M_PER_S = np.array([0.1, 0.05, 0.3])
SOLVERS = [pytest.param("adapters.particles.liggghts", marks=pytest.mark.solver), "tests.reference.spheres"]


def joined(*surfaces: TriangleSurface) -> TriangleSurface:
    starts = np.cumsum([0, *(len(surface.position_m) for surface in surfaces)])
    return TriangleSurface(
        np.concatenate([surface.position_m for surface in surfaces]),
        np.concatenate([surface.triangles + start for surface, start in zip(surfaces, starts, strict=False)]),
        np.concatenate([surface.material for surface in surfaces]),
    )


def rigid(*surfaces: TriangleSurface) -> TriangleSurface:
    """Each surface on four points of its own, with the same triangles in the same order."""
    corners_m = [tetrahedron_m(surface.position_m) for surface in surfaces]
    shares = [shares_in(at_m, surface.position_m) for surface, at_m in zip(surfaces, corners_m, strict=True)]
    first = np.repeat(4 * np.arange(len(surfaces)), [len(share) for share in shares])
    plain = joined(*surfaces)
    return replace(
        plain,
        position_m=np.concatenate(corners_m),
        triangles=plain.triangles + 4 * len(surfaces),
        rigid=RigidVertices(first, np.concatenate(shares)),
    )


def moved(start_m: Array, time_s: float) -> Motion:
    """The body turns about a point beside it and rises."""
    around_m = np.array([0.03, -0.01, 0.0])
    arms_m = Rotation.from_rotvec(time_s * SPIN_RAD_PER_S).apply(start_m - around_m)
    velocity_m_per_s = np.cross(SPIN_RAD_PER_S, arms_m) + SPEED_M_PER_S
    return Motion(around_m + arms_m + time_s * SPEED_M_PER_S, velocity_m_per_s)


@dataclass
class Found:
    """Particles, and what they gave the surface: force and moment about the origin of each interval."""

    position_m: Array
    spin_rad_per_s: Array
    force_N: Array
    moment_N_m: Array
    received_J: float
    worn_m3: Array
    push_N: Array


def run(solver: str, plan: ParticlesPlan, intervals: int = 60) -> Found:
    particles: Any = import_module(solver).build(plan)
    start_m, forces, moments = plan.surface.position_m, [], []
    for index in range(intervals):
        interval = Interval(index, INTERVAL_S)
        ends = [moved(start_m, time_s) for time_s in (interval.start_s, interval.end_s)]
        load_N = particles.advance(interval, HermitePath(*ends, INTERVAL_S)).force_N
        forces.append(load_N.sum(axis=0))
        moments.append(np.cross(ends[0].position_m + ends[1].position_m, load_N).sum(axis=0) / 2)
    now, tangent = particles.snapshot(), particles.contact_tangent(INTERVAL_S)
    outcome = Found(
        now.position_m,
        now.spin_rad_per_s,
        np.array(forces),
        np.array(moments),
        particles.account().received_J["surface"],
        particles.worn_m3()[-len(plan.surface.vertices_m) + len(start_m) or None :],
        tangent.push_N.sum(axis=0),
    )
    particles.close()
    return outcome


def plan_on(surface: TriangleSurface) -> ParticlesPlan:
    """Seven spheres, with friction and resistance to rolling; some touch both surfaces."""
    x, y = np.array([[0.0, 0.004], [-0.009, 0.002], [0.012, -0.007], [0.0, -0.012], [0.006, 0.01]]).T
    places_m = np.vstack([np.column_stack([x, y, np.full(5, 0.0027)]), [[0.0, 0, 0.011], [0.005, 0, 0.012]]])
    return make_plan(
        surface,
        spheres(places_m, [0.2, 0.1, -0.6], spin_rad_per_s=[30.0, -60.0, 90.0]),
        restitution=0.5,
        sliding_friction=0.4,
        rolling_friction=0.1,
        wear_m3_per_N_m=np.full((2, 2), 1e-12),
        predicts_load=True,
        gravity_m_per_s2=np.array([0.0, 0.0, -9.81]),
    )


@pytest.mark.parametrize("solver", SOLVERS)
def test_particles_and_loads_are_those_of_plain_triangles(solver: str) -> None:
    """The surfaces turn by 7 degrees in 60 intervals. Rounding of 1e-16, some 1e4 times as much after the
    impacts; places to 1e-12 m, forces of up to 2 N to 1e-8, moments to 1e-9 N m."""
    parts = flat(0.02, 9), replace(pit(0.4, 5), material=np.ones(5, dtype=np.int64))
    plain, four = (run(solver, plan_on(of(*parts))) for of in (joined, rigid))
    assert np.abs(plain.force_N).max() > 0.1
    assert np.abs(plain.moment_N_m).max() > 1e-3
    assert abs(plain.received_J) > 1e-6
    assert plain.worn_m3.sum() > 0
    assert four.position_m == pytest.approx(plain.position_m, abs=1e-12)
    assert four.spin_rad_per_s == pytest.approx(plain.spin_rad_per_s, abs=1e-6)
    assert four.force_N == pytest.approx(plain.force_N, abs=1e-8)
    assert four.moment_N_m == pytest.approx(plain.moment_N_m, abs=1e-9)
    assert four.received_J == pytest.approx(plain.received_J, rel=1e-8)
    assert four.worn_m3 == pytest.approx(plain.worn_m3, rel=1e-7, abs=1e-22)
    assert four.push_N == pytest.approx(plain.push_N, rel=1e-6, abs=1e-9)


@pytest.mark.solver
def test_a_restored_solver_goes_on_bit_for_bit() -> None:
    plan = plan_on(rigid(flat(0.02, 9)))
    build = import_module("adapters.particles.liggghts").build
    first, second = build(plan), build(plan)

    def go_on(solver: Particles, intervals: range) -> Array:
        for index in intervals:
            now = Interval(index, INTERVAL_S)
            path = HermitePath(
                *(moved(plan.surface.position_m, t) for t in (now.start_s, now.end_s)), INTERVAL_S
            )
            load_N = solver.advance(now, path).force_N
        return load_N

    go_on(first, range(30))
    second.restore(first.save())
    assert np.array_equal(go_on(first, range(30, 50)), go_on(second, range(30, 50)))
    first.close()
    second.close()


@pytest.mark.solver
def test_however_many_triangles_cost_nothing_while_nobody_is_near() -> None:
    """A sphere far above 80 000 triangles: an interval takes no longer than over 2, within a factor of 2."""

    def processor_s(cells: int) -> float:
        plan = make_plan(rigid(flat(0.02, cells)), spheres([0.0, 0.0, 0.05]))
        solver, start_m = import_module("adapters.particles.liggghts").build(plan), plan.surface.position_m
        least_s = np.inf
        for index in range(200):
            now = Interval(index, INTERVAL_S)
            path = HermitePath(*(moved(start_m, t) for t in (now.start_s, now.end_s)), INTERVAL_S)
            begun_s = time.process_time()
            solver.advance(now, path)
            least_s = min(least_s, time.process_time() - begun_s)
        solver.close()
        return float(least_s)

    assert processor_s(200) < 2.0 * processor_s(1)
