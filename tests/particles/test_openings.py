"""Particles at the openings of a still, rigid panel: what passes, and where it rests if not."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.stats import binom

from orchestrator.case.deck.drawing import read_drawing
from orchestrator.case.deck.openings import straight_passing
from orchestrator.case.deck.triangle_grid import perforated_grid
from orchestrator.case.tables.deck import DrawnApertures
from orchestrator.ports import Array
from orchestrator.ports.drawn_openings import DrawnOpenings
from orchestrator.ports.geometry import AperturePattern, Rectangle, TriangleSurface
from tests.drawn import draw_pattern
from tests.particles.contract import LIGGGHTS_ALONE, Run, particles, plan, solver_adapter, table

pytestmark = pytest.mark.slow  # as a whole: thousands of steps of the NumPy spheres

PANEL = Rectangle(np.zeros(3), np.eye(3)[0], np.eye(3)[1], 0.3, 0.3, 0.3, 0.0)
SQUARES = AperturePattern("rectangle", 0.010, 0.010, 0.015, 0.015, 0.0, 0.02, 0.02)
SLOTS = AperturePattern("rectangle", 0.020, 0.003, 0.025, 0.006, 0.0, 0.02, 0.02)
STAGGERED = AperturePattern("rectangle", 0.010, 0.006, 0.015, 0.009, 0.5, 0.02, 0.02)


def build(solver: str, **given: Any) -> Any:
    return solver_adapter(solver).build(plan(**given))


every_solver = pytest.mark.parametrize("solver", LIGGGHTS_ALONE)


def still(pattern: AperturePattern, panel: Rectangle = PANEL) -> TriangleSurface:
    """The perforated panel in z = 0."""
    grid = perforated_grid(panel, pattern, (20, 20))
    material = np.zeros(len(grid.triangles), dtype=np.int64)
    return TriangleSurface(panel.mounted(grid.coordinates_m), grid.triangles, material)


def run(solver: str, surface: TriangleSurface, **given: Any) -> Run:
    wanted = plan(surface=surface, **given)
    opened = build(solver, surface=surface, **given)
    return Run(opened, wanted)


def over_the_pattern(pattern: AperturePattern, diameter_m: float, seed: int) -> Array:
    """Places (n, 2) clear of each other, each uniform over one cell of the pattern."""
    pitch = np.array([pattern.pitch_along_m, pattern.pitch_across_m])
    apart = np.ceil(1.5 * diameter_m / pitch + 1).astype(int)
    low, high = pattern.region_m(PANEL)
    cells = np.round((high - low) / pitch).astype(int)
    i, j = (n.ravel() for n in np.mgrid[: cells[0] : apart[0], : cells[1] : apart[1]])
    within = np.random.default_rng(seed).uniform(size=(len(i), 2))
    return low + (np.column_stack([i, j]) + within) * pitch


def untouched_and_passed(run: Run, time_s: float) -> tuple[int, int]:
    """Return how many fell as freely as in vacuo, and how many are below the panel."""
    start = run.solver.snapshot()
    run.advance(round(time_s / run.plan.sync_interval_s))
    now = run.solver.snapshot()
    below = now.position_m[:, 2] < -now.grains.sieve_size_m / 2
    fallen = start.velocity_m_per_s + time_s * run.plan.gravity_m_per_s2
    free = np.abs(now.velocity_m_per_s - fallen).max(axis=1) < 1e-9
    assert below[free].all()
    return int(free.sum()), int(below.sum())


@every_solver
@pytest.mark.parametrize(
    ("pattern", "diameter_m"),
    [(SQUARES, 0.004), (SQUARES, 0.007), (SLOTS, 0.0015), (STAGGERED, 0.003)],
    ids=["squares", "large", "slots", "staggered"],
)
def test_single_attempts_pass_with_the_probability_of_gaudin(
    solver: str, pattern: AperturePattern, diameter_m: float
) -> None:
    """Spheres falling straight down at random places pass without a touch with the probability
    (a - d)(b - d) / pitches of A. M. Gaudin (Principles of Mineral Dressing, 1939): their number
    lies within the binomial distribution's central 99.9 %.  Bounced ones may pass besides."""
    untouched = passed = tried = 0
    for seed in range(3 if solver == "spheres" else 8):
        places = over_the_pattern(pattern, diameter_m, seed)
        heights = np.full(len(places), 0.51 * diameter_m)
        given = particles(np.column_stack([places, heights]), (0.0, 0.0, -1.0), diameter_m=diameter_m)
        done = run(
            solver,
            still(pattern),
            given=given,
            sync_interval_s=2e-4,
            step_s=1e-5,
            sliding_friction=table(0.0),
            restitution=table(0.8),
        )
        free, below = untouched_and_passed(done, round(1.1e3 * diameter_m + 1) * 1e-3)
        untouched, passed, tried = untouched + free, passed + below, tried + len(places)
        done.solver.close()
    expected = straight_passing(pattern, diameter_m)
    low, high = binom.interval(0.999, tried, expected)
    assert low <= untouched <= high, (untouched, tried, expected)
    assert passed >= untouched


@every_solver
@pytest.mark.parametrize("pattern", [SQUARES, SLOTS], ids=["squares", "slots"])
def test_what_is_larger_than_an_opening_never_passes(solver: str, pattern: AperturePattern) -> None:
    """5 % larger than the width, thrown at 0.3 m/s and left to bounce for 0.06 s.  These soft
    spheres (10 MPa) have a tenth of the energy that would squeeze them through:
    2 (8/15) E* sqrt(R) ((d - a) / 2)^(5/2), a contact on either side."""
    diameter_m = 1.05 * pattern.width_m
    places = over_the_pattern(pattern, 2 * diameter_m, 1)
    places = np.random.default_rng(1).permutation(places)[:80]
    heights = np.full(len(places), diameter_m)
    given = particles(np.column_stack([places, heights]), (0, 0, -0.3), diameter_m=diameter_m)
    done = run(solver, still(pattern), given=given, sync_interval_s=1e-3, step_s=1e-5)
    done.advance(60)
    assert (done.solver.snapshot().position_m[:, 2] > 0.0).all()
    done.solver.close()


@every_solver
def test_what_is_a_little_smaller_slips_through(solver: str) -> None:
    """98 % of a slot's width, let down in its middle: it falls as freely as in vacuo."""
    centres = SLOTS.centres_m(PANEL)[::40]
    given = particles(
        np.column_stack([centres, np.full(len(centres), 0.003)]), diameter_m=0.98 * SLOTS.width_m
    )
    done = run(solver, still(SLOTS), given=given, sync_interval_s=1e-3, step_s=2e-5)
    assert untouched_and_passed(done, 0.05) == (len(centres), len(centres))
    done.solver.close()


@every_solver
@pytest.mark.parametrize(
    ("pattern", "diameter_m"),
    [(SLOTS, 0.004), (SQUARES, 0.0125), (SQUARES, 0.02)],
    ids=["slot", "square", "square-large"],
)
def test_a_sphere_rests_on_an_opening_s_rim(solver: str, pattern: AperturePattern, diameter_m: float) -> None:
    """Its centre is sqrt(r^2 - a^2/4) over the panel, a the width between the rims that hold
    it, less what its weight presses it in (1e-3 r)."""
    radius_m, half_m = diameter_m / 2, pattern.width_m / 2
    height_m = np.sqrt(radius_m**2 - half_m**2)
    centre = pattern.centres_m(PANEL)[25]
    given = particles([*centre, height_m + 1e-3 * radius_m], diameter_m=diameter_m)
    done = run(solver, still(pattern), given=given, sync_interval_s=1e-3, step_s=2e-5, restitution=table(0.2))
    done.advance(60)
    now = done.solver.snapshot()
    assert now.position_m[0, :2] == pytest.approx(centre, abs=1e-3 * radius_m)
    assert now.position_m[0, 2] == pytest.approx(height_m, abs=3e-3 * radius_m)
    assert np.abs(now.velocity_m_per_s).max() < 1e-3
    carried_N = done.load_N[-1].sum(axis=0)
    weight_N = 1430.0 * np.pi / 6 * diameter_m**3 * 9.81
    assert carried_N == pytest.approx([0.0, 0.0, -weight_N], abs=0.02 * weight_N)
    done.solver.close()


@every_solver
def test_spheres_fall_through_a_drawing_as_through_the_pattern(solver: str, tmp_path: Path) -> None:
    """A DXF file of the slots, in m and with the panel's outline: every sphere has the same place, to the
    last bit, since the triangles are the same."""
    table_of_file = DrawnApertures(file=draw_pattern(tmp_path / "panel.dxf", SLOTS, PANEL).name)
    drawing = read_drawing(table_of_file, tmp_path)
    drawn = replace(SLOTS, shape="polygon", drawn=DrawnOpenings(drawing.outlines_m, (0.3, 0.3)))
    places = over_the_pattern(SLOTS, 0.0025, 3)
    heights = np.full(len(places), 0.0015)
    ends_m = []
    for pattern in (SLOTS, drawn):
        given = particles(np.column_stack([places, heights]), (0.0, 0.0, -1.0), diameter_m=0.0025)
        done = run(solver, still(pattern), given=given, sync_interval_s=2e-4, step_s=1e-5)
        done.advance(50)
        ends_m.append(done.solver.snapshot().position_m)
        done.solver.close()
    assert 0 < (ends_m[0][:, 2] < 0.0).sum() < len(places)
    np.testing.assert_array_equal(*ends_m)
