"""Rebounds of clumps with dampers: restitution is that of the contact, wherever and with how many spheres."""

from __future__ import annotations

from contextlib import closing
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from orchestrator.case import solvers
from orchestrator.ports import Array
from orchestrator.ports.clumps import clump
from orchestrator.ports.grains import Shape, ShapeTable, turned
from orchestrator.ports.plans import Rebound
from tests.particles.contract import (
    LIGGGHTS_ALONE,
    WEIGHTLESS,
    Run,
    particles,
    plan,
    plate,
    solver_adapter,
    table,
)
from tests.particles.test_clumps import DUMBBELL, Build, dumbbells, made_of

ASKED = LIGGGHTS_ALONE

SPEED_M_PER_S, RESTITUTION = 0.5, 0.5
SMOOTH: dict[str, Any] = {
    "gravity_m_per_s2": WEIGHTLESS,
    "sliding_friction": table(0.0),
    "restitution": table(RESTITUTION),
    "step_s": 2.5e-6,
}
LONG = clump("long", "", [(x, 0, 0, 1) for x in (-1.9, 0.0, 1.9)])
"""Three spheres in a row that hardly overlap: an end is twice as far from the centre as a dumbbell's."""
RING = clump("ring", "", [(2 * np.cos(a), 2 * np.sin(a), 0, 1) for a in 2 * np.pi * np.arange(6) / 6])


def turn(about: Any, angle_rad: float) -> Array:
    """A quaternion (1, 4)."""
    about = np.asarray(about, dtype=float) / np.linalg.norm(about)
    return np.array([[np.cos(angle_rad / 2), *(np.sin(angle_rad / 2) * about)]])


def lowest(shape: Shape, orientation: Array, size_m: float = 0.01) -> tuple[Array, int]:
    """Heights (n,) of the spheres' lowest points below the centre, and the lowest of them."""
    own = np.array(shape.spheres) * size_m
    place_m = turned(np.repeat(orientation, len(own), axis=0), own[:, :3])
    down_m = place_m[:, 2] - own[:, 3]
    return place_m, int(np.argmin(down_m))


def dropped(build: Build, shape: Shape, orientation: Array, **changes: Any) -> tuple[Run, Array]:
    """A grain just above the plate, and the arm from its centre to its lowest sphere."""
    place_m, low = lowest(shape, orientation)
    radius_m = shape.spheres[low][3] * 0.01
    above_m = 1e-6 - (place_m[low, 2] - radius_m)
    given = replace(particles([0.001, 0.002, above_m], [0, 0, -SPEED_M_PER_S]), orientation=orientation)
    run = build(dumbbells(shape, plan(plate(0.05, 3), given, **{**SMOOTH, **changes})))
    return run, place_m[low]


def closing_m_per_s(run: Run, arm_m: Array) -> float:
    now = run.solver.snapshot()
    return float(now.velocity_m_per_s[0, 2] + np.cross(now.spin_rad_per_s[0], arm_m)[2])


@pytest.mark.parametrize("angle_deg", [10.0, 30.0, 45.0, 70.0, 80.0])
@pytest.mark.parametrize("shape", [DUMBBELL, LONG, solvers.shape("stone")], ids=lambda shape: shape.name)
def test_a_clump_that_hits_at_one_place_rebounds_there_with_e(
    build: Build, shape: Shape, angle_deg: float
) -> None:
    """The place that touches leaves with e times its speed, and the centre with the impulse
    (1 + e) v / (1/m + (r x n) . I^-1 (r x n)): Stronge, W. J., Impact Mechanics, 2000, chapter 3.

    It turns a little while it touches, and touches above the lowest point of its sphere: 2 % of the speed.
    """
    orientation = turn([0.3, 1.0, 0.2], np.radians(angle_deg))
    run, arm_m = dropped(build, shape, orientation, sync_interval_s=1e-4)
    run.until_clear()
    left_m_per_s = closing_m_per_s(run, arm_m)
    assert left_m_per_s == pytest.approx(RESTITUTION * SPEED_M_PER_S, abs=0.02 * SPEED_M_PER_S)
    grains = made_of(shape, particles([0, 0, 0])).grains
    mass_kg, inertia_kg_m2 = grains.mass_kg[0], grains.inertia_kg_m2[0]
    back = orientation * np.array([[1.0, -1.0, -1.0, -1.0]])
    moment_m = turned(back, np.cross(arm_m, [0.0, 0.0, 1.0])[None])[0]
    light_1_kg = 1.0 / mass_kg + np.sum(moment_m**2 / inertia_kg_m2)
    jump_m_per_s = (1.0 + RESTITUTION) * SPEED_M_PER_S / light_1_kg / mass_kg
    up_m_per_s = run.solver.snapshot().velocity_m_per_s[0, 2]
    assert up_m_per_s == pytest.approx(jump_m_per_s - SPEED_M_PER_S, abs=0.02 * SPEED_M_PER_S)


FLAT = {
    "rod": (solvers.shape("rod"), turn([1, 0, 0], np.pi / 2)),
    "long": (LONG, turn([1, 0, 0], np.pi / 2)),
    "flake": (solvers.shape("flake"), turn([0, 1, 0], np.pi / 2)),
    "ring": (RING, turn([0, 1, 0], np.pi / 2)),
}


@pytest.mark.parametrize(("shape", "orientation"), FLAT.values(), ids=FLAT)
def test_a_clump_that_hits_flat_rebounds_with_e(build: Build, shape: Shape, orientation: Array) -> None:
    """Two to seven spheres touch at once, with as many springs and dampers; as one contact of their sum they
    have the restitution e.  With a damper each for the whole mass it would be 0.29 for three."""
    run, _ = dropped(build, shape, orientation, sync_interval_s=1e-4)
    run.until_clear()
    now = run.solver.snapshot()
    assert now.velocity_m_per_s[0, 2] == pytest.approx(RESTITUTION * SPEED_M_PER_S, rel=0.01)
    np.testing.assert_allclose(now.spin_rad_per_s[0], 0.0, atol=1e-9)


@pytest.mark.parametrize("tilt_deg", [0.05, 0.5, 1.0, 2.0, 5.0])
@pytest.mark.parametrize(("shape", "orientation"), FLAT.values(), ids=FLAT)
def test_a_clump_that_hits_nearly_flat_keeps_its_share_of_speed(
    build: Build, shape: Shape, orientation: Array, tilt_deg: float
) -> None:
    """It rocks from end to end in hits that overlap, for which there is no closed form.  A flat hit leaves e
    of the root of the energy, these 0.43 to 0.54; a damper for the whole mass at each sphere left 0.11 to
    0.44."""
    w, x, y, z = orientation[0]
    c, s = np.cos(np.radians(tilt_deg) / 2), np.sin(np.radians(tilt_deg) / 2)
    tilted = np.array([[c * w - s * x, c * x + s * w, c * y - s * z, c * z + s * y]])
    run, _ = dropped(build, shape, tilted, sync_interval_s=1e-3)
    before_J = run.solver.account().stored_J["kinetic"]
    run.advance(20)
    after_J = run.solver.account().stored_J["kinetic"]
    assert np.sqrt(after_J / before_J) == pytest.approx(RESTITUTION, abs=0.08)


def test_restitution_over_speed_goes_by_the_place_that_touches(build: Build) -> None:
    """A dumbbell that spins meets the plate with 0.5 m/s at its end, twice as fast as its centre falls."""
    speeds = np.array([0.1, 0.4, 1.0])
    rebounds = (Rebound((0, 0), speeds, np.array([0.9, 0.6, 0.4])),)
    changes = {"rebounds": rebounds, "restitution": table(0.9), "sync_interval_s": 1e-4}
    run, arm_m = dropped(build, DUMBBELL, turn([0, 1, 0], np.radians(70.0)), **changes)
    spin_rad_per_s = np.cross(arm_m, [0.0, 0.0, -0.25]) / (arm_m[0] ** 2 + arm_m[1] ** 2)
    given = replace(
        run.plan.particles,
        velocity_m_per_s=np.array([[0.0, 0.0, -0.25]]),
        spin_rad_per_s=spin_rad_per_s[None],
    )
    run = build(replace(run.plan, particles=given))
    assert closing_m_per_s(run, arm_m) == pytest.approx(-0.5, rel=1e-12)
    run.until_clear()
    expected_m_per_s = np.interp(0.5, speeds, [0.9, 0.6, 0.4]) * 0.5
    assert closing_m_per_s(run, arm_m) == pytest.approx(expected_m_per_s, abs=0.02 * 0.5)


LYING = turn([1, 0, 0], np.pi / 2)
"""Rods that lie along y."""


@pytest.mark.parametrize(("aside_m", "touching_m"), [(0.0, 0.0), (0.01, 0.005)])
def test_two_rods_that_meet_rebound_with_e(build: Build, aside_m: float, touching_m: float) -> None:
    """One above the other, they touch with three pairs of spheres, end above end with one: there they part
    with e times the speed with which they met, and their momentum stays nothing."""
    given = particles([[0.0, 0.0, 0.3], [0.0, aside_m, 0.31001]], [[0, 0, 0.25], [0, 0, -0.25]])
    given = replace(given, orientation=np.repeat(LYING, 2, axis=0))
    changes = {**SMOOTH, "sync_interval_s": 1e-3}
    run = build(dumbbells(solvers.shape("rod"), plan(plate(0.01, 1), given, **changes)))
    run.advance(10)
    now, account = run.solver.snapshot(), run.solver.account()
    arm_m = np.array([[0.0, touching_m, 0.0], [0.0, -touching_m, 0.0]])
    lower, upper = now.velocity_m_per_s + np.cross(now.spin_rad_per_s, arm_m)
    assert upper[2] - lower[2] == pytest.approx(RESTITUTION * SPEED_M_PER_S, abs=0.02 * SPEED_M_PER_S)
    np.testing.assert_allclose(account.momentum_kg_m_per_s, 0.0, atol=1e-15)


def test_a_sphere_that_hits_an_end_rebounds_there_with_e(build: Build) -> None:
    """The dumbbell is free: its end gives way by 1/m + a^2/I, and a ball of mass m meets it at 0.5 m/s."""
    ball = plan(plate(0.01, 1), particles([0, 0, 0])).shapes[0]
    given = particles([[0.0, 0.0, 0.3], [0.0, 0.005, 0.31001]], [[0, 0, 0], [0, 0, -SPEED_M_PER_S]])
    grains = replace(given.grains, shapes=ShapeTable.of((DUMBBELL, ball)), shape=np.array([0, 1]))
    given = replace(given, grains=grains, orientation=np.concatenate([LYING, turn([1, 0, 0], 0.0)]))
    alone = plan(plate(0.01, 1), given, **SMOOTH, sync_interval_s=1e-4)
    run = build(replace(alone, shapes=(DUMBBELL, ball), largest_radius_m=0.01))
    run.advance(60)
    now = run.solver.snapshot()
    end_m_per_s = now.velocity_m_per_s[0] + np.cross(now.spin_rad_per_s[0], [0.0, 0.005, 0.0])
    parting_m_per_s = float(now.velocity_m_per_s[1, 2] - end_m_per_s[2])
    assert parting_m_per_s == pytest.approx(RESTITUTION * SPEED_M_PER_S, abs=0.02 * SPEED_M_PER_S)


def test_the_reference_damps_alike() -> None:
    """A rod falls on one that lies, shifted by a fifth of its size: plate and rods touch at many places."""
    given = particles([[0.0, 0.0, 0.00499], [0.0011, 0.002, 0.0151]], [[0, 0, 0], [0.1, 0.05, -0.5]])
    given = replace(given, orientation=np.repeat(LYING, 2, axis=0))
    wanted = dumbbells(solvers.shape("rod"), plan(plate(0.03, 1), given))
    seen = []
    for name in ("liggghts", "spheres"):
        with closing(solver_adapter(name).build(wanted)) as solver:
            Run(solver, wanted).advance(8)
            seen.append(solver.snapshot())
    for name in ("velocity_m_per_s", "spin_rad_per_s"):
        ours, reference = (getattr(each, name) for each in seen)
        np.testing.assert_allclose(ours, reference, atol=1e-6 * np.abs(reference).max(), rtol=0)
