"""Rods, twice as long as thick, at the openings of a still plate: what passes, beside integrals over all
attitudes and a Monte Carlo of its own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import binom, norm

from orchestrator.case import solvers
from orchestrator.case.bed.packing import random_orientations
from orchestrator.ports import Array
from orchestrator.ports.geometry import AperturePattern
from orchestrator.ports.grains import ShapeTable
from tests.particles.contract import LIGGGHTS_ALONE, WEIGHTLESS, particles, table
from tests.particles.elastic_bodies import Plate, bounce
from tests.particles.test_openings import PANEL, SLOTS, SQUARES, run, still
from tests.reference.spheres.bodies import rotations

ASKED = LIGGGHTS_ALONE
pytestmark = pytest.mark.slow

ROD = solvers.shape("rod")
SPEED_M_PER_S = 0.5
SIZES_M = {"squares": (SQUARES, 0.004), "slots": (SLOTS, 0.0015)}
given = pytest.mark.parametrize(("pattern", "size_m"), SIZES_M.values(), ids=SIZES_M)


def places_m(pattern: AperturePattern, apart_m: float, generator: np.random.Generator) -> Array:
    """Places (n, 2), each uniform over one cell of the pattern, of cells that are so far apart."""
    pitch_m = np.array([pattern.pitch_along_m, pattern.pitch_across_m])
    low_m, high_m = pattern.region_m(PANEL)
    cells = np.round((high_m - low_m) / pitch_m).astype(int)
    stride = np.ceil(apart_m / pitch_m + 1).astype(int)
    i, j = (n.ravel() for n in np.mgrid[: cells[0] : stride[0], : cells[1] : stride[1]])
    return np.asarray(low_m + (np.column_stack([i, j]) + generator.uniform(size=(len(i), 2))) * pitch_m)


def falls_through(pattern: AperturePattern, size_m: float) -> float:
    """The chance that a rod of a random attitude falls straight through at a random place without a touch.

    Its shadow is a bar with round ends; both widths, size (1 + |u|) with u the axis' share along them, must
    be within the opening.  The mean over the axis' directions is a sum over a fine grid of them, equal in
    cos and azimuth: Gaudin's formula for rods.
    """
    up = (np.arange(2000) + 0.5) / 2000
    azimuth = (np.arange(2000) + 0.5) / 2000 * np.pi / 2
    across = np.sqrt(1 - up**2)[:, None]
    along, beside = across * np.cos(azimuth), across * np.sin(azimuth)
    room_m2 = np.maximum(pattern.length_m - size_m * (1 + along), 0.0)
    room_m2 = room_m2 * np.maximum(pattern.width_m - size_m * (1 + beside), 0.0)
    return float(room_m2.mean() / (pattern.pitch_along_m * pattern.pitch_across_m))


@given
def test_rods_pass_as_an_integral_and_a_monte_carlo_of_its_own_say(
    pattern: AperturePattern, size_m: float
) -> None:
    """Thrown down at 0.5 m/s without gravity and friction, elastic: those that fall through untouched lie
    within the central 99.9 % of the binomial distribution of the integral; all that pass, bounced ones
    besides, agree with the Monte Carlo within 99.9 % of the difference of two such counts."""
    generator = np.random.default_rng(11)
    reach_m = ROD.bounding_radius * size_m
    seconds = round((4 * reach_m / SPEED_M_PER_S) / 2e-4) * 2e-4
    untouched = passed = tried = 0
    for _ in range(12):
        where = places_m(pattern, 8 * reach_m, generator)
        turns = random_orientations(len(where), generator)
        thrown = particles(
            np.column_stack([where, np.full(len(where), 1.01 * reach_m)]),
            (0.0, 0.0, -SPEED_M_PER_S),
            diameter_m=size_m,
        )
        grains = replace(thrown.grains, shapes=ShapeTable.of([ROD]))
        done = run(
            "liggghts",
            still(pattern),
            given=replace(thrown, grains=grains, orientation=turns),
            shapes=(ROD,),
            largest_radius_m=reach_m,
            gravity_m_per_s2=WEIGHTLESS,
            sync_interval_s=2e-4,
            step_s=4e-6,
            sliding_friction=table(0.0),
            restitution=table(1.0),
        )
        done.advance(round(seconds / 2e-4))
        now = done.solver.snapshot()
        below = now.position_m[:, 2] < 0.0
        free = below & (np.abs(now.velocity_m_per_s - thrown.velocity_m_per_s).max(axis=1) < 1e-9)
        untouched, passed = untouched + int(free.sum()), passed + int(below.sum())
        tried += len(where)
        done.solver.close()
    expected = falls_through(pattern, size_m)
    low, high = binom.interval(0.999, tried, expected)
    assert low <= untouched <= high, (untouched, tried, expected)

    count = 2000
    pitch_m = np.array([pattern.pitch_along_m, pattern.pitch_across_m])
    plate = Plate(np.array([pattern.length_m, pattern.width_m]), pitch_m)
    start_m = np.column_stack([generator.uniform(size=(count, 2)) * pitch_m, np.full(count, 1.01 * reach_m)])
    ended_m, never = bounce(
        plate,
        start_m,
        rotations(random_orientations(count, generator)),
        SPEED_M_PER_S,
        np.array(ROD.spheres) * size_m,
        np.array(ROD.inertia) / ROD.volume * size_m**2,
        seconds,
        step_s=4e-6,
        softness_m=0.01 * size_m,
    )
    through = ended_m[:, 2] < 0.0
    low, high = binom.interval(0.999, count, expected)
    assert low <= int((never & through).sum()) <= high
    share = (passed + through.sum()) / (tried + count)
    error = np.sqrt(share * (1 - share) * (1 / tried + 1 / count))
    difference = passed / tried - through.mean()
    assert abs(difference) < norm.ppf(0.9995) * error, (passed / tried, through.mean(), error)
    assert through.mean() > 1.05 * expected  # some bounce first


@pytest.mark.parametrize(("share", "passes"), [(0.98, True), (1.03, False)])
def test_a_rod_on_end_passes_what_its_sieve_size_says(share: float, passes: bool) -> None:
    """Let down on end in the middle of square openings of 10 mm; a larger one stays on the rims."""
    size_m = share * SQUARES.width_m
    centres = SQUARES.centres_m(PANEL)[::40]
    height_m = 1.01 * ROD.bounding_radius * size_m
    upright = particles(np.column_stack([centres, np.full(len(centres), height_m)]), diameter_m=size_m)
    grains = replace(upright.grains, shapes=ShapeTable.of([ROD]))
    done = run(
        "liggghts",
        still(SQUARES),
        given=replace(upright, grains=grains),
        shapes=(ROD,),
        largest_radius_m=ROD.bounding_radius * size_m,
        sync_interval_s=1e-3,
        step_s=2e-5,
    )
    done.advance(100)
    below = done.solver.snapshot().position_m[:, 2] < 0.0
    assert below.all() if passes else not below.any()
    done.solver.close()
