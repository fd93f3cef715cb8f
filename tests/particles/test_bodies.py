"""Bodies of spheres in LIGGGHTS: what a rigid body keeps for a long time, and what a single sphere is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from orchestrator.case import solvers
from orchestrator.ports.grains import ShapeTable
from tests.particles.contract import LIGGGHTS_ALONE, WEIGHTLESS, particles, plan, plate
from tests.particles.test_clumps import DUMBBELL, Build, dumbbells

ASKED = LIGGGHTS_ALONE


def test_a_free_stone_keeps_energy_and_momentum_for_1e5_steps(build: Build) -> None:
    """Three different moments; 16 turns, a hundred times as long as the steps of 2e-5 s are."""
    stone = solvers.shape("stone")
    given = particles([0, 0, 0.3], [0.01, 0, 0], [30.0, 35.0, 20.0])
    run = build(dumbbells(stone, plan(plate(0.01, 1), given, gravity_m_per_s2=WEIGHTLESS)))
    before, largest = run.solver.account(), 0.0
    for _ in range(20):
        run.advance(100)
        now = run.solver.account()
        gained = now.stored_J["kinetic"] / before.stored_J["kinetic"] - 1
        largest = max(largest, abs(gained))
    assert largest < 1e-6
    assert before.angular is not None
    assert now.angular is not None
    own = before.angular.momentum_kg_m2_per_s
    np.testing.assert_allclose(
        now.angular.momentum_kg_m2_per_s, own, atol=1e-12 * np.linalg.norm(own), rtol=0
    )
    np.testing.assert_allclose(now.momentum_kg_m_per_s, before.momentum_kg_m_per_s, rtol=1e-14)


def test_bodies_of_one_sphere_are_spheres(build: Build) -> None:
    """Two balls that hit a plate and each other go the same way as bodies and as LIGGGHTS's own spheres."""
    place_m = [[0, 0, 0.0052], [0.002, 0.001, 0.016], [-0.012, 0, 0.0051]]
    given = particles(place_m, [0.3, 0.1, -0.5], [5.0, -90.0, 3.0], diameter_m=[0.01, 0.01, 0.008])
    alone = plan(plate(0.05, 3), given)
    shapes = (*alone.shapes, DUMBBELL)
    grains = replace(given.grains, shapes=ShapeTable.of(shapes))
    among = replace(alone, shapes=shapes, particles=replace(given, grains=grains), largest_radius_m=0.01)
    spheres, bodies = build(alone), build(among)
    for run in (spheres, bodies):
        run.advance(60)
    wanted, got = spheres.solver.snapshot(), bodies.solver.snapshot()
    for name in ("position_m", "velocity_m_per_s", "spin_rad_per_s"):
        want = getattr(wanted, name)
        np.testing.assert_allclose(getattr(got, name), want, atol=1e-12 * np.abs(want).max(), rtol=0)
    energy_J = [run.solver.account().stored_J["kinetic"] for run in (spheres, bodies)]
    assert energy_J[1] == pytest.approx(energy_J[0], rel=1e-11)
