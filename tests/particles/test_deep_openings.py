"""Spheres and openings with walls: what passes, what is held between two walls and when it is let go."""

from __future__ import annotations

from contextlib import closing
from dataclasses import replace

import numpy as np
import pytest

from orchestrator.case.deck.triangle_grid import perforated_grid
from orchestrator.ports import Array, HermitePath, Motion, Particles
from orchestrator.ports.adapters import ParticlesAdapter
from orchestrator.ports.clock import Interval
from orchestrator.ports.geometry import AperturePattern, Rectangle, TriangleSurface
from orchestrator.ports.plans import DeckPlan, ExitPlan, GrainMaterial, ParticlesPlan
from tests.particles.contract import LIGGGHTS_ALONE, SOLVERS, Run, particles, plan, solver_adapter, table
from tests.particles.test_openings import PANEL, SLOTS, over_the_pattern
from tests.reference.rigid_spheres import Slots, passed_share

ASKED = SOLVERS
DEPTH_M = 0.0059
SMALL = Rectangle(np.zeros(3), np.eye(3)[0], np.eye(3)[1], 0.06, 0.06, 0.03, 0.0)
FEW = AperturePattern("rectangle", 0.020, 0.003, 0.025, 0.006, depth_m=DEPTH_M)


def surface_of(pattern: AperturePattern, panel: Rectangle, cells: tuple[int, int]) -> TriangleSurface:
    """The panel, whose middle surface is in z = 0."""
    grid = perforated_grid(panel, pattern, cells)
    none = np.zeros(len(grid.triangles), dtype=np.int64)
    return TriangleSurface(panel.mounted(grid.coordinates_m), grid.triangles, none, none, side=grid.side)


def share_of_dem(depth_m: float, diameter_m: float, seeds: int) -> tuple[float, int]:
    """The share of hits that pass, and the number of hits, by LIGGGHTS: as ``passed_share`` counts them."""
    surface = surface_of(replace(SLOTS, depth_m=depth_m), PANEL, (20, 20))
    hits = passed = 0
    for seed in range(seeds):
        places = over_the_pattern(SLOTS, diameter_m, seed)
        heights = np.full(len(places), depth_m / 2 + diameter_m / 2 + 1e-5)
        wanted = plan(
            surface,
            particles(np.column_stack([places, heights]), (0.0, 0.0, -2.0), diameter_m=diameter_m),
            materials=(GrainMaterial("stiff", 1e9, 0.3),),
            restitution=table(0.34),
            sliding_friction=table(0.47),
            step_s=2e-6,
            sync_interval_s=2e-4,
        )
        over, through = np.zeros((2, len(places)), dtype=bool)
        with closing(solver_adapter("liggghts").build(wanted)) as solver:
            run = Run(solver, wanted)
            while not (over | through).all() and run.time_s < 0.2:
                run.advance()
                z = solver.snapshot().position_m[:, 2]
                through |= ~over & (z < -depth_m / 2 - diameter_m / 2)
                over |= ~through & (z - depth_m / 2 - diameter_m / 2 > 0.25 * diameter_m)
        hits, passed = hits + len(places), passed + int(through.sum())
    return passed / hits, hits


@pytest.mark.slow
@pytest.mark.parametrize("_", LIGGGHTS_ALONE)
@pytest.mark.parametrize("diameter_m", [0.0015, 0.0020, 0.00245])
def test_the_chance_of_a_hit_is_that_of_rigid_spheres(_: str, diameter_m: float) -> None:
    """Straight down at 2 m/s, restitution 0.34, friction 0.47, slots of 3 x 20 mm: within 10 % of the rigid
    spheres, apart from two standard errors of both counts.  Contacts are stiff (1 GPa): with 10 MPa, overlaps
    let 22 % more pass at 2.45 mm."""
    rigid = passed_share(Slots(0.020, 0.003, (0.025, 0.006), DEPTH_M), diameter_m, 8000, 2.0, 0.34, 0.47)
    share, hits = share_of_dem(DEPTH_M, diameter_m, 25)
    error = np.sqrt(rigid * (1 - rigid) * (1 / hits + 1 / 8000))
    assert share == pytest.approx(rigid, abs=0.1 * rigid + 2 * error)


def wedged(module: ParticlesAdapter, oversize: Array, friction: float) -> tuple[Particles, ParticlesPlan]:
    """Spheres larger than the slots' width by ``oversize`` (n,) shares of it, half way down in slots."""
    places = FEW.centres_m(SMALL)[: len(oversize)]
    given = particles(
        np.column_stack([places, np.zeros(len(places))]), diameter_m=FEW.width_m * (1 + oversize)
    )
    wanted = plan(
        surface_of(FEW, SMALL, (4, 3)),
        given,
        restitution=table(0.2),
        sliding_friction=table(friction),
        step_s=1e-5,
        sync_interval_s=5e-4,
    )
    return module.build(wanted), wanted


def test_a_grain_between_two_walls_is_held_and_loads_them_alike(module: ParticlesAdapter) -> None:
    """Each wall gets half of the weight, and Hertz's force of half the oversize (4/3 E* sqrt(r) delta^1.5),
    to opposite sides; what they get together is the weight (1 %, while the sphere comes to rest)."""
    solver, wanted = wedged(module, np.array([0.02]), 0.5)
    with closing(solver):
        run = Run(solver, wanted)
        run.advance(120)
        now, load_N = solver.snapshot(), run.load_N[-1]
    assert np.abs(now.velocity_m_per_s).max() < 1e-4
    assert np.abs(now.position_m[0, 2]) < 1e-4
    middle_m = wanted.surface.position_m[:, 1] - now.position_m[0, 1]
    left_N, right_N = load_N[middle_m < 0].sum(axis=0), load_N[middle_m > 0].sum(axis=0)
    radius_m, e_star_Pa = 1.02 * 0.0015, 1e7 / (2 * (1 - 0.3**2))
    hertz_N = 4 / 3 * e_star_Pa * np.sqrt(radius_m) * 3.0e-5**1.5
    weight_N = 1430.0 * 4 / 3 * np.pi * radius_m**3 * 9.81
    assert right_N[1] == pytest.approx(hertz_N, rel=0.01)
    assert left_N[1] == pytest.approx(-right_N[1], rel=1e-6)
    assert [left_N[2], right_N[2]] == pytest.approx([-weight_N / 2] * 2, rel=0.01)


def stretched(surface: TriangleSurface, strain: float, rate_1_per_s: float) -> Motion:
    """The panel stretched across about its middle."""
    across = np.zeros_like(surface.position_m)
    across[:, 1] = surface.position_m[:, 1] - SMALL.width_m / 2
    return Motion(surface.position_m + strain * across, rate_1_per_s * across)


def released(oversize: Array, strains: Array) -> Array:
    """The share of wedged spheres that have fallen out at each of the rising ``strains`` (k,), each of which
    is reached at 1 1/s and held for 50 ms."""
    solver, wanted = wedged(solver_adapter("liggghts"), oversize, 0.5)
    length_s, held_s = wanted.sync_interval_s, 0.05
    until_s = [[eps + k * held_s, eps + (k + 1) * held_s] for k, eps in enumerate(strains)]
    times_s = np.concatenate([[0.0], *until_s])
    at = np.concatenate([[0.0], np.repeat(strains, 2)])
    shares = []
    with closing(solver):
        for index in range(round(times_s[-1] / length_s)):
            here, then = np.interp([index * length_s, (index + 1) * length_s], times_s, at)
            ends = [stretched(wanted.surface, each, (then - here) / length_s) for each in (here, then)]
            solver.advance(Interval(index, length_s), HermitePath(*ends, length_s))
            if len(shares) < len(strains) and (index + 1.5) * length_s > times_s[2 * len(shares) + 2]:
                shares.append(np.mean(solver.snapshot().position_m[:, 2] < -DEPTH_M / 2))
    return np.array(shares)


@pytest.mark.parametrize("_", LIGGGHTS_ALONE)
def test_a_stretch_throws_out_what_is_smaller_than_the_stretched_opening(_: str) -> None:
    """Spheres larger by 1 to 4 % of the width: at a strain eps all that are smaller than the opening, whose
    width has grown by eps, have fallen out, and the others are held, as long as they are larger by 0.25 %."""
    oversize = np.array([0.01, 0.02, 0.03, 0.04])
    strains = np.array([0.0025, 0.0125, 0.0225, 0.0275, 0.0425])
    below = [(oversize < strain).mean() for strain in strains]
    assert released(oversize, strains) == pytest.approx(below)


def test_who_is_in_an_opening_is_on_the_deck(module: ParticlesAdapter) -> None:
    """One sphere is held between the walls, in an exit that reaches up to the upper side, and stays; another
    one falls through a slot beside it, has one contact however often it strikes the walls, and leaves."""
    at_m = FEW.centres_m(SMALL)
    places_m = np.array([[*at_m[0], 0.0], [*at_m[1], DEPTH_M / 2 + 0.0011]])
    speeds_m_per_s = np.array([[0.0, 0.0, 0.0], [0.0, 0.2, -0.5]])
    surface = surface_of(FEW, SMALL, (4, 3))
    line_m = np.array([[0.0, 0.015, 0.0], [0.06, 0.015, 0.0]])
    (from_m, left_m), (to_m, right_m) = FEW.region_m(SMALL)
    deck = DeckPlan(
        *np.eye(3)[:2],
        points=len(surface.position_m) + np.arange(2),
        panel=np.zeros(2, dtype=np.int64),
        station_m=np.array([0.0, 0.06]),
        open_m=np.array([[from_m, to_m, left_m, right_m]]),
        reach_m=0.003,
        half_depth_m=np.array([DEPTH_M / 2]),
    )
    box_m = np.array([0.03, 0.015, -0.05])
    wanted = plan(
        replace(surface, position_m=np.vstack([surface.position_m, line_m])),
        particles(places_m, speeds_m_per_s, diameter_m=np.array([0.00306, 0.002])),
        deck=deck,
        exits=(ExitPlan("below", "undersize", box_m, np.eye(3), np.array([0.1, 0.1, 0.05 + 0.001])),),
        sliding_friction=table(0.5),
        sync_interval_s=5e-4,
        step_s=1e-5,
    )
    with closing(module.build(wanted)) as solver:
        Run(solver, wanted).advance(120)
        gone, there = solver.removed(), solver.snapshot()
    assert there.id.tolist() == [1]
    assert gone.id.tolist() == [2]
    assert gone.contacts.tolist() == [[1]]
    assert gone.position_m[0, 2] < -DEPTH_M / 2
