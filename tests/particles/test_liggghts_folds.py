"""One contact per smooth patch: spheres over folds and curved, faceted surfaces."""

from contextlib import closing

import numpy as np
import pytest
from mpi4py import MPI

from orchestrator.ports import Array
from tests.particles.liggghts_plans import make_plan, sheet, spheres, still, travel

liggghts = pytest.importorskip("adapters.particles.liggghts")
from adapters.particles.liggghts_input import FIRST_EVALUATION  # noqa: E402
from adapters.particles.liggghts_ledger import effective_moduli  # noqa: E402

pytestmark = pytest.mark.solver

RADIUS_M = 2.5e-3
DISTANCE_M = 0.98 * RADIUS_M  # pressed 2 % of the radius onto the nearest place
REACH_M = 1.4e-3
RIDGE, VALLEY = 1, -1


def fold(angle_deg: float, kind: int):
    """Facets of 5 x 8 mm on two half planes that meet in x = 0."""
    slope = kind * np.tan(np.radians(angle_deg) / 2)
    x_m, y_m = 5e-3 * np.arange(-4, 5), 8e-3 * np.arange(-3, 4)
    return sheet(lambda x, y: -slope * np.abs(x), x_m, y_m)


def track(angle_deg: float, kind: int) -> Array:
    """Places of the centre at constant distance from the nearest feature of the fold."""
    half = np.radians(angle_deg) / 2
    x = np.linspace(-REACH_M, REACH_M, 141)
    z = DISTANCE_M / np.cos(half) - kind * np.tan(half) * np.abs(x)
    if kind == RIDGE:
        over_edge = np.abs(x) <= DISTANCE_M * np.sin(half)
        z[over_edge] = np.sqrt(DISTANCE_M**2 - x[over_edge] ** 2)
    return np.stack([x, np.full_like(x, 1e-3), z], axis=1)


def drag(angle_deg: float, kind: int, folder) -> Array:
    """Force on the sphere at every place of the track over the force of a single contact."""
    plan = make_plan(fold(angle_deg, kind), spheres([0.0, 0.0, 0.05]))
    engine = liggghts.start(plan, MPI.COMM_SELF, folder)
    liggghts.create(engine, plan.particles, 1)
    engine.command(FIRST_EVALUATION)
    forces = []
    for place in track(angle_deg, kind):
        engine.particles()["x"][0] = place
        engine.prepare()
        forces.append(engine.particles()["f"][0].copy())
    e_star_Pa = effective_moduli(plan.materials)[0][1]
    single_N = 4 / 3 * e_star_Pa * np.sqrt(RADIUS_M) * (RADIUS_M - DISTANCE_M) ** 1.5
    return np.array(forces) / single_N


@pytest.mark.parametrize("kind", [RIDGE, VALLEY], ids=["ridge", "valley"])
@pytest.mark.parametrize("angle_deg", [0.0, 0.5, 2.0, 5.0, 10.0, 15.0])
def test_a_gentle_fold_is_one_contact(angle_deg, kind, tmp_path):
    # the distance to the nearest place never changes, so neither may the force: rounding only
    force = drag(angle_deg, kind, tmp_path)
    np.testing.assert_allclose(np.linalg.norm(force, axis=1), 1.0, rtol=1e-9)


@pytest.mark.parametrize("angle_deg", [30.0, 45.0, 90.0])
def test_a_sharp_ridge_is_one_contact(angle_deg, tmp_path):
    force = drag(angle_deg, RIDGE, tmp_path)
    np.testing.assert_allclose(np.linalg.norm(force, axis=1), 1.0, rtol=1e-9)


@pytest.mark.parametrize("angle_deg", [45.0, 60.0, 90.0])
def test_a_sharp_valley_is_two_contacts(angle_deg, tmp_path):
    # in the middle both walls push fully: 2 cos(angle / 2) upwards
    force = drag(angle_deg, VALLEY, tmp_path)
    middle = len(force) // 2
    expected = [0.0, 0.0, 2 * np.cos(np.radians(angle_deg) / 2)]
    np.testing.assert_allclose(force[middle], expected, atol=1e-9)


def test_a_valley_in_between_fades_in(tmp_path):
    force = np.linalg.norm(drag(30.0, VALLEY, tmp_path), axis=1)
    assert force.min() == pytest.approx(1.0, rel=1e-9)
    assert 1.0 < force.max() < 2 * np.cos(np.radians(15.0))


def test_a_deep_overlap_on_a_flat_sheet_is_one_contact(tmp_path):
    # 30 % of the radius: the neighbours' edges are seen at up to 45 degrees, none may count
    x = np.linspace(-10e-3, 10e-3, 21)
    plan = make_plan(sheet(lambda x, y: 0 * x, x, x), spheres([3e-4, 2e-4, 0.7 * RADIUS_M]))
    with closing(liggghts.build(plan)) as solver:
        force_N = solver.initial().force_N.sum(axis=0)
    e_star_Pa = effective_moduli(plan.materials)[0][1]
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
        plan = make_plan(plane, sphere, gravity_m_s2=gravity, step_s=5e-6, **laws)
        with closing(liggghts.build(plan)) as solver:
            forces_N = np.array(travel(solver, lambda t: still(plane), range(1600)))
            return forces_N, solver.snapshot()

    (coarse_N, coarse), (fine_N, fine) = roll(1), roll(80)
    assert fine.position_m[0, 0] > 0.008
    scale_N = np.abs(coarse_N).max()
    np.testing.assert_allclose(fine_N, coarse_N, atol=1e-9 * scale_N)
    np.testing.assert_allclose(fine.position_m, coarse.position_m, rtol=1e-9)
    np.testing.assert_allclose(fine.spin_rad_s, coarse.spin_rad_s, rtol=1e-9, atol=1e-9)


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
        gravity_m_s2=np.array([0.0, 0.0, -9.81]),
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
    ("height_m", "wave_1_m", "fold_deg", "tolerance"),
    [
        # one contact per patch has a potential: what is left is the integrator's error
        (1.2e-3, 150.0, 9.8, 2e-5),
        (3e-3, 150.0, 24.1, 2e-5),
        # a contact that only fades in, or ends where two minima meet, has none
        (4e-3, 400.0, 114.7, 2e-3),
    ],
    ids=["gentle", "folded", "sharp"],
)
def test_elastic_bounces_keep_their_energy(height_m, wave_1_m, fold_deg, tolerance):
    # ridges and valleys; 16 smooth spheres, some hundred 50 us intervals with contact
    line = np.linspace(-0.04, 0.04, 17)
    bumps = sheet(lambda x, y: height_m * np.sin(wave_1_m * x) * np.sin(wave_1_m * y), line, line)
    assert largest_fold_deg(bumps) == pytest.approx(fold_deg, abs=0.1)
    grid = 0.02 * (np.arange(4) - 1.5)
    place = np.stack([*map(np.ravel, np.meshgrid(grid, grid)), np.full(16, 7e-3)], axis=1)
    plan = make_plan(bumps, spheres(place), gravity_m_s2=np.array([0.0, 0.0, -50.0]))
    with closing(liggghts.build(plan)) as solver:
        forces_N = travel(solver, lambda t: still(bumps), range(2000))
        account = solver.account()
    assert np.count_nonzero(np.array(forces_N)[:, 2]) > 50
    assert abs(account.lost_J["contact_dissipation"]) < tolerance * account.stored_J["kinetic"]
