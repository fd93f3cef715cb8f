"""Lists of neighbours: how wide they are, and when they are made anew."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from adapters.particles.liggghts.input import SKINS, skin_m
from orchestrator.ports import Array, Motion, Particles
from orchestrator.ports.plans import ParticleList, SolverFailed
from tests.particles.contract import solver_adapter
from tests.particles.liggghts_plans import INTERVAL_S, flat, make_plan, spheres, still, travel
from tests.saved_states import differences

ALONG = np.array([2.0, 0.5, -3.0])
"""The velocity in m/s with which everything moves."""
UP = np.array([0.0, 0.0, 1.0])


def clouds() -> ParticleList:
    """Return two clouds of 27 spheres each, 5 mm wide and 2 mm apart; they meet at 4 m/s."""
    line_m = 7e-3 * np.arange(3)
    grid_m = np.stack(np.meshgrid(line_m, line_m, line_m, indexing="ij"), axis=-1).reshape(-1, 3)
    other_m = grid_m + np.array([0.021, 1e-3, 5e-4])
    velocity_m_per_s = np.repeat([[2.0, 0.0, 0.0], [-2.0, 0.0, 0.0]], 27, axis=0)
    return spheres(np.concatenate([grid_m, other_m]) + 0.03 * UP, velocity_m_per_s)


def test_the_skin_widens_with_the_step_and_narrows_with_fine_grains() -> None:
    """Particles come farther in a longer step; around fine grains there are more in a wide skin."""
    plan = make_plan(flat(), spheres([0.0, 0.0, 0.01]))
    share = [skin_m(replace(plan, step_s=step_s)) / 5e-3 for step_s in (1e-8, 1e-6, 1e-5, 1e-3)]
    assert SKINS[0] == pytest.approx(share[0])
    assert share[0] < share[1] < share[2] < share[3] == pytest.approx(SKINS[1])
    fine = spheres(np.zeros((50, 3)), diameter_m=2e-3)
    mixed = replace(plan, step_s=1e-5, particles=fine)
    assert mixed.largest_radius_m == 2.5e-3
    assert skin_m(mixed) < 0.8 * share[2] * 5e-3


@pytest.mark.solver
@pytest.mark.parametrize("periodic_y", [False, True])
@pytest.mark.parametrize("most", [3, 700])
def test_everybody_who_touches_is_listed(tmp_path: Path, most: int, periodic_y: bool) -> None:
    """The sizes do not matter; a pair across a periodic side is listed, too, and though one flies far away,
    so that cells would be many for so few."""
    random = np.random.default_rng(5)
    diameter_m = np.where(random.random(most) < 0.5, 1e-2, random.uniform(0.5e-3, 1e-2, most))
    position_m = random.uniform([-0.03, -0.03, 0.02], [0.03, 0.03, 0.08], (most, 3))
    position_m[:2] = position_m[2] + [[0.0, 0.0, 2e-4], [3e-4, 0.0, 0.0]]
    position_m[:2, 1] = -0.0299, 0.0299 if periodic_y else -0.0299
    position_m[-1] = [-0.09, 0.0, -0.09]
    given = spheres(position_m, diameter_m=diameter_m)
    plan = make_plan(flat(0.03), given, folder=tmp_path)
    if periodic_y:
        plan = replace(plan, domain_m=plan.domain_m * [1.0, 0.3, 1.0], periodic_y=True)
    solver = solver_adapter("liggghts").build(plan)
    neighbours = solver.snapshot().contacts
    assert neighbours is not None
    solver.close()
    apart_m = position_m[:, None] - position_m
    if periodic_y:
        apart_m[..., 1] -= 0.06 * np.round(apart_m[..., 1] / 0.06)
    touching = np.linalg.norm(apart_m, axis=-1) < (diameter_m[:, None] + diameter_m) / 2
    np.testing.assert_array_equal(neighbours, touching.sum(axis=1) - 1)
    assert neighbours[:2].all()
    assert not neighbours[-1]


def coated_ball(grains: int, centre_m: Array) -> ParticleList:
    """Return a ball of 50 mm that grains of 1 mm touch all around."""
    turns = np.pi * (1 + np.sqrt(5)) * np.arange(grains)
    height = np.linspace(-1.0, 1.0, grains)
    across = np.sqrt(1 - height**2)
    shell = np.stack([across * np.cos(turns), across * np.sin(turns), height], axis=1)
    diameter_m = np.full(grains + 1, 1e-3)
    diameter_m[0] = 0.05
    return spheres(np.vstack([0.0 * UP, 0.0254 * shell]) + centre_m, diameter_m=diameter_m)


@pytest.mark.solver
def test_a_lump_has_more_neighbours_than_are_listed_for_one(tmp_path: Path) -> None:
    """LIGGGHTS lists three thousand for one particle, and each grain lists the ball."""
    ball = coated_ball(6000, 0.05 * UP)
    solver = solver_adapter("liggghts").build(make_plan(flat(), ball, folder=tmp_path))
    contacts = solver.snapshot().contacts
    solver.close()
    assert contacts is not None
    assert contacts[0] == 6000
    assert contacts[1:].min() >= 1


@pytest.mark.solver
def test_more_neighbours_than_can_be_listed_are_refused(tmp_path: Path) -> None:
    """A ball lists its neighbours across a periodic side, here half of nine thousand."""
    plan = make_plan(flat(), coated_ball(9000, np.array([0.0, 0.1, 0.05])), folder=tmp_path, periodic_y=True)
    plan.particles.position_m[:, 1] = (plan.particles.position_m[:, 1] + 0.1) % 0.2 - 0.1
    with pytest.raises(SolverFailed, match="neighbours"):
        solver_adapter("liggghts").build(plan)


@pytest.mark.solver
def test_a_bed_that_moves_as_one_is_seldom_listed(tmp_path: Path) -> None:
    """The bed goes 18 mm in 100 intervals of 0.05 ms at 3.64 m/s, and half the largest diameter, 2.5 mm,
    between two listings, but for half a skin, 0.3 mm at most; LIGGGHTS by itself would list it every 0.3
    mm."""
    solver = solver_adapter("liggghts").build(make_plan(flat(), spheres(grid(), ALONG), folder=tmp_path))
    away = Motion(flat().position_m - 0.09 * UP, np.zeros((81, 3)))
    listed, listings = listed_at_m(solver), 0
    for index in range(100):
        travel(solver, lambda _: away, range(index, index + 1))
        now = listed_at_m(solver)
        listings += not np.array_equal(now, listed)
        listed = now
    solver.close()
    assert 7 <= listings <= 9


@pytest.mark.solver
def test_collisions_are_the_same_in_a_bed_that_moves(tmp_path: Path) -> None:
    """Galileo's principle holds, to the rounding that 110 collisions and more amplify."""
    at_rest = places_after(clouds(), np.zeros(3), tmp_path / "rest")
    moving = places_after(clouds(), ALONG, tmp_path / "moving")
    flown = clouds().position_m + 100 * INTERVAL_S * clouds().velocity_m_per_s
    assert (np.linalg.norm(at_rest - flown, axis=1) > 1e-3).sum() > 27  # or nothing has collided
    np.testing.assert_allclose(moving - 100 * INTERVAL_S * ALONG, at_rest, atol=1e-9)


@pytest.mark.solver
def test_a_bed_that_falls_as_one_meets_the_surface(tmp_path: Path) -> None:
    """The surface is searched again as the bed comes near, though its own neighbours stay the same: they fall
    1.5 mm, three skins, and bounce as on a surface that comes up to them."""
    here = flat()
    bed = spheres(grid()[:9] - 6e-3 * UP)

    def rising(time_s: float) -> Motion:
        return Motion(here.position_m + 3.0 * time_s * UP, np.tile(3.0 * UP, (81, 1)))

    solver = solver_adapter("liggghts").build(make_plan(here, bed, folder=tmp_path / "rising"))
    risen_N = travel(solver, rising, range(40))
    solver.close()
    falling = replace(bed, velocity_m_per_s=bed.velocity_m_per_s - 3.0 * UP)
    solver = solver_adapter("liggghts").build(make_plan(here, falling, folder=tmp_path / "falling"))
    fallen_N = travel(solver, lambda _: still(here), range(40))
    solver.close()
    assert min(force[2] for force in risen_N) < -10.0
    np.testing.assert_allclose(fallen_N, risen_N, atol=1e-6)


@pytest.mark.solver
def test_a_restored_bed_knows_where_it_was_searched(tmp_path: Path) -> None:
    """The bed might otherwise meet the surface unseen; after 0.6 ms at 3 m/s, searches are 0.3 mm of its
    way apart."""
    falling = make_plan(flat(), spheres(grid(), -3.0 * UP), folder=tmp_path)
    solver, other = (solver_adapter("liggghts").build(falling) for _ in range(2))
    travel(solver, lambda _: still(flat()), range(12))
    saved = solver.save()
    other.restore(saved)
    assert saved["engine"]["bed_at_search_m"][2] < -1e-3
    assert differences(saved, other.save(), "restored") == []
    solver.close()
    other.close()


def grid() -> Array:
    """Return places of 3 x 3 x 3 spheres, 6 mm apart, the lowest ones 10 mm above the surface, (27, 3)."""
    line_m = 6e-3 * np.arange(3)
    layers = np.stack(np.meshgrid(line_m, line_m, line_m, indexing="ij"), axis=-1).reshape(-1, 3)
    ordered: Array = layers[np.argsort(layers[:, 2], kind="stable")] + np.array([-6e-3, -6e-3, 1e-2])
    return ordered


def places_after(bed: ParticleList, along_m_per_s: Array, folder: Path) -> Array:
    """Return where the particles (n, 3) are after 100 intervals, in order; the surface is far below."""
    moving = replace(bed, velocity_m_per_s=bed.velocity_m_per_s + along_m_per_s)
    solver = solver_adapter("liggghts").build(make_plan(flat(), moving, folder=folder))
    away = Motion(flat().position_m - 0.09 * UP, np.zeros((81, 3)))
    travel(solver, lambda _: away, range(100))
    places_m = solver.snapshot().position_m
    solver.close()
    return places_m


def listed_at_m(solver: Particles) -> Array:
    places_m: Array = np.array(solver.save()["engine"]["listed_at_m"])
    return places_m
