"""One contact per smooth patch: spheres over folds and curved, faceted surfaces."""

from contextlib import closing

import numpy as np
import pytest

from tests.particles.liggghts_plans import make_plan, sheet, spheres, still, travel

pytest.importorskip("adapters.particles._liggghts")
from adapters.particles import liggghts
from adapters.particles.liggghts.engine import effective_moduli

pytestmark = pytest.mark.solver

RADIUS_M = 2.5e-3


def test_a_deep_overlap_on_a_flat_sheet_is_one_contact(tmp_path):
    # 30 % of the radius: the neighbours' edges are seen at up to 45 degrees, none may count
    x = np.linspace(-10e-3, 10e-3, 21)
    plan = make_plan(sheet(lambda x, y: 0 * x, x, x), spheres([3e-4, 2e-4, 0.7 * RADIUS_M]))
    with closing(liggghts.build(plan)) as solver:
        force_N = solver.initial().force_N.sum(axis=0)
    e_star_Pa = effective_moduli(plan.materials)[0][0, 1]
    single_N = 4 / 3 * e_star_Pa * np.sqrt(RADIUS_M) * (0.3 * RADIUS_M) ** 1.5
    np.testing.assert_allclose(force_N, [0.0, 0.0, -single_N], atol=1e-9 * single_N)


def test_facets_of_a_plane_leave_no_trace():
    # sliding, then rolling over 40 facets or over two: the tangential spring must not notice
    def roll(cells):
        line = np.linspace(-0.02, 0.02, cells + 1)
        plane = sheet(lambda x, y: 0 * x, line, line)
        laws = {"restitution": 0.3, "sliding_friction": 0.4, "rolling_friction": 0.02}
        gravity = np.array([1.0, 0.5, -9.81])
        sphere = spheres([-0.012, -0.0013, RADIUS_M], (0.3, 0.05, 0.0))
        plan = make_plan(plane, sphere, gravity_m_per_s2=gravity, step_s=5e-6, **laws)
        with closing(liggghts.build(plan)) as solver:
            forces_N = np.array(travel(solver, lambda t: still(plane), range(1600)))
            return forces_N, solver.snapshot()

    (coarse_N, coarse), (fine_N, fine) = roll(1), roll(80)
    assert fine.position_m[0, 0] > 0.008
    scale_N = np.abs(coarse_N).max()
    np.testing.assert_allclose(fine_N, coarse_N, atol=1e-9 * scale_N)
    np.testing.assert_allclose(fine.position_m, coarse.position_m, rtol=1e-9)
    np.testing.assert_allclose(fine.spin_rad_per_s, coarse.spin_rad_per_s, rtol=1e-9, atol=1e-9)


def test_rolling_in_a_faceted_trough_keeps_its_tangential_spring():
    # a sphere that rolls in a cylinder swings with (2 pi / T)^2 = 5/7 g / (R - r)
    # (e.g. Goldstein, Classical Mechanics); facets of 1 degree, amplitude 0.15 rad.  Slower in
    # the amplitude by 0.14 % (pendulum) and by the blow of each fold: 1 % for a quarter period.
    bend_m, start = 60e-3, 0.15
    ring = bend_m - RADIUS_M
    x = bend_m * np.sin(np.radians(np.arange(-15, 16)))
    trough = sheet(lambda x, y: bend_m - np.sqrt(bend_m**2 - x**2), x, 4e-3 * np.arange(-3, 4))
    plan = make_plan(
        trough,
        spheres([ring * np.sin(start), 1e-3, bend_m - ring * np.cos(start)]),
        restitution=0.3,
        sliding_friction=0.8,
        gravity_m_per_s2=np.array([0.0, 0.0, -9.81]),
        step_s=5e-6,
    )
    quarter_s = 0.5 * np.pi * np.sqrt(7 / 5 * ring / 9.81)
    with closing(liggghts.build(plan)) as solver:
        travel(solver, lambda t: still(trough), range(round(quarter_s / 5e-5)))
        x, v = solver.arrays()["x"][0], solver.arrays()["v"][0]
        spin = solver.arrays()["omega"][0]
    speed = np.sqrt(10 / 7 * 9.81 * ring * (1 - np.cos(start)))
    assert x[0] == pytest.approx(0.0, abs=0.01 * ring * start)
    assert v[0] == pytest.approx(-speed, rel=0.01)
    assert spin[1] * RADIUS_M == pytest.approx(v[0], rel=0.01)


def largest_fold_deg(surface) -> float:
    """Largest angle between two triangles with a common edge."""
    corner = surface.position_m[surface.triangles]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    first_at: dict[tuple[int, ...], int] = {}
    cosine = 1.0
    for number, (a, b, c) in enumerate(surface.triangles.tolist()):
        for edge in ((a, b), (b, c), (c, a)):
            first = first_at.setdefault(tuple(sorted(edge)), number)
            cosine = min(cosine, float(normal[first] @ normal[number]))
    return float(np.degrees(np.arccos(cosine)))


@pytest.mark.parametrize(
    ("height_m", "wave_1_m", "fold_deg"),
    [(1.2e-3, 150.0, 9.8), (3e-3, 150.0, 24.1), (4e-3, 400.0, 114.7)],
    ids=["gentle", "folded", "sharp"],
)
def test_elastic_bounces_keep_their_energy(height_m, wave_1_m, fold_deg):
    # ridges, valleys, hollows; 16 smooth spheres, some hundred 50 us intervals with contact.  The
    # forces have a potential: what is left is the integrator's error, 2e-5 at a step of 1 us
    line = np.linspace(-0.04, 0.04, 17)
    bumps = sheet(lambda x, y: height_m * np.sin(wave_1_m * x) * np.sin(wave_1_m * y), line, line)
    assert largest_fold_deg(bumps) == pytest.approx(fold_deg, abs=0.1)
    grid = 0.02 * (np.arange(4) - 1.5)
    place = np.stack([*map(np.ravel, np.meshgrid(grid, grid)), np.full(16, 7e-3)], axis=1)
    place[:, :2] += np.random.default_rng(2).normal(0.0, 2e-3, (16, 2))
    plan = make_plan(bumps, spheres(place), gravity_m_per_s2=np.array([0.0, 0.0, -50.0]))
    with closing(liggghts.build(plan)) as solver:
        forces_N = travel(solver, lambda t: still(bumps), range(2000))
        account = solver.account()
    assert np.count_nonzero(np.array(forces_N)[:, 2]) > 50
    assert abs(account.lost_J["contact_dissipation"]) < 2e-5 * account.stored_J["kinetic"]
