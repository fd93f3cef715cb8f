"""Periodic sides: surface and particles go on across the boundary as if it were not there."""

from contextlib import closing

import numpy as np
import pytest

from orchestrator.ports.geometry import TriangleSurface
from tests.particles.liggghts_plans import make_plan, sheet, spheres, still, travel
from tests.particles.test_liggghts_balance import ranks

pytest.importorskip("adapters.particles._liggghts")
from adapters.particles import liggghts
from adapters.particles.liggghts.engine import join_across

pytestmark = pytest.mark.solver

PERIOD_M = 0.04
CELLS = 16
DOMAIN_M = np.array([[-0.1, 0.0, -0.1], [0.1, PERIOD_M, 0.1]])
X_M = np.linspace(-0.02, 0.02, 9)
Y_M = np.linspace(0.0, PERIOD_M, CELLS + 1)


def flat(x, y, ridge_m):
    return 0.0 * x


def bent_along(x, y, ridge_m):
    """A valley along y, as a panel between its clamps."""
    return 30.0 * x**2


def bent_across(x, y, ridge_m):
    """A ridge along x at ``ridge_m``; folds of 4 degrees at most, all of them along x."""
    return 1e-3 * np.cos(2 * np.pi * (y - ridge_m) / PERIOD_M)


def bent_both(x, y, ridge_m):
    return bent_along(x, y, ridge_m) + bent_across(x, y, ridge_m)


def surface(height, ridge_m: float) -> TriangleSurface:
    return sheet(lambda x, y: height(x, y, ridge_m), X_M, Y_M)


def plan_of(height, ridge_m, particles, **changes):
    return make_plan(surface(height, ridge_m), particles, domain_m=DOMAIN_M, periodic_y=True, **changes)


def force_on_a_sphere(height, ridge_m, at_m):
    """Force of the surface on a sphere of 5 mm, ``at_m`` from the ridge and some 2 % of
    its radius deep in the surface."""
    y = ridge_m + at_m
    z = np.interp(1.1e-3, X_M, height(X_M, y + 0.0 * X_M, ridge_m)) + 0.98 * 2.5e-3
    sphere = spheres([1.1e-3, y % PERIOD_M, z])
    with closing(liggghts.build(plan_of(height, ridge_m, sphere))) as solver:
        load = solver.initial().force_N
        return -load.sum(axis=0)


@pytest.mark.parametrize("height", [flat, bent_along, bent_across, bent_both])
def test_a_sphere_dragged_across_the_boundary_feels_what_it_feels_in_the_middle(height):
    middle_m, tries_m = PERIOD_M / 2, np.linspace(-3e-3, 3e-3, 25)
    wanted = np.array([force_on_a_sphere(height, middle_m, at) for at in tries_m])
    forces_N = np.array([force_on_a_sphere(height, 0.0, at) for at in tries_m])
    assert (wanted[:, 2] > 0.1).all()
    np.testing.assert_allclose(forces_N, wanted, rtol=0.0, atol=1e-9 * wanted.max())


def slid(start_m):
    """A spinning sphere, pressed on a bent sheet with friction, slides from y = ``start_m``."""
    ball = spheres([1.1e-3, start_m, 2.68e-3], (0.1, 4.0, 0.0), spin_rad_per_s=(20.0, 0.0, 30.0))
    gravity = np.array([0.0, 0.0, -500.0])
    laws = {"restitution": 0.5, "sliding_friction": 0.4, "rolling_friction": 0.05}
    plan = plan_of(bent_along, 0.0, ball, gravity_m_per_s2=gravity, **laws)
    with closing(liggghts.build(plan)) as solver:
        forces = travel(solver, lambda t: still(plan.surface), range(60))
        return np.array(forces), solver.snapshot(), solver.account()


def test_a_sphere_that_slides_across_the_boundary_keeps_its_contact():
    # 12 mm in 3 ms; one crosses the boundary after 2 mm, the other is far from it
    crossing, there, books = slid(PERIOD_M - 2e-3)
    free, here, other = slid(PERIOD_M / 4)
    assert np.count_nonzero(free[:, 2]) > 50
    np.testing.assert_allclose(crossing, free, atol=1e-9 * np.abs(free).max())
    moved_m = there.position_m[0, 1] - (PERIOD_M - 2e-3) + PERIOD_M
    assert moved_m == pytest.approx(here.position_m[0, 1] - PERIOD_M / 4, abs=1e-11)
    np.testing.assert_allclose(there.velocity_m_per_s, here.velocity_m_per_s, atol=1e-9)
    np.testing.assert_allclose(there.spin_rad_per_s, here.spin_rad_per_s, atol=1e-6)
    assert books.stored_J["gravitational"] == pytest.approx(other.stored_J["gravitational"])


def test_two_spheres_touch_across_the_boundary():
    """The spheres touch as two in the middle do, with the same momentum and energy."""

    def collide(middle_m):
        y = (middle_m + np.array([-2.6137e-3, 2.6137e-3])) % PERIOD_M
        pair = spheres([[0, y[0], 0.05], [0, y[1], 0.05]], [[0, 1.0, 0], [0, -1.0, 0]])
        plan = plan_of(flat, 0.0, pair, restitution=0.6)
        with closing(liggghts.build(plan)) as solver:
            travel(solver, lambda t: still(plan.surface), range(10))
            return solver.snapshot().velocity_m_per_s[:, 1]

    np.testing.assert_allclose(collide(0.0), collide(PERIOD_M / 2), atol=1e-9)
    np.testing.assert_allclose(collide(0.0), [-0.6, 0.6], atol=2e-3)


class OneByOne:
    """Offers a grain in each interval, where nobody is."""

    def due(self, interval):
        return spheres([-0.09 + 0.006 * interval.index, PERIOD_M / 2, 0.09], (0.0, 0.0, 1.0), 1e-3)

    def settle(self, accepted):
        assert accepted.all()


def test_pairs_that_slide_across_the_boundary_keep_the_momentum_at_a_feed():
    """Both sides of a pair take a contact that has slid for one that slides, however they are rounded.

    LIGGGHTS puts the spring of a sliding contact to the limit of friction, and evaluates forces anew when
    grains come.
    """
    turn, x_m = np.linspace(0.2, 1.2, 14), np.linspace(-0.085, 0.085, 14)
    away_m = 2.4999e-3 * np.stack([0 * turn, np.cos(turn), np.sin(turn)], axis=1)
    first_m = np.stack([x_m, 0 * x_m, 0.03 + 0 * x_m], axis=1)
    place_m = np.concatenate([first_m + away_m, first_m - away_m])
    place_m[:, 1] %= PERIOD_M
    pairs = spheres(place_m, np.repeat([[0.7, -0.9, 0.1], [-0.4, 0.8, 0.2]], 14, axis=0))
    laws = {"restitution": 0.4, "sliding_friction": 0.1}
    plan = plan_of(flat, 0.0, pairs, feed=OneByOne(), largest_radius_m=2.5e-3, **laws)
    with closing(liggghts.build(plan)) as solver:
        travel(solver, lambda t: still(plan.surface), range(20), 5e-6)
        books = solver.account()
    change = books.momentum_kg_m_per_s - books.outside_impulse_N_s
    begin = pairs.grains.mass_kg @ pairs.velocity_m_per_s
    np.testing.assert_allclose(change, begin, rtol=0.0, atol=1e-12 * books.moved_N_s)


class Late:
    """Offers one particle whose place is taken across the boundary, and one with room."""

    def __init__(self):
        self.accepted = []

    def due(self, interval):
        if interval.index == 1:
            return spheres([[0.0, PERIOD_M - 1e-3, 0.05], [0.02, PERIOD_M - 1e-3, 0.05]])
        return spheres(np.zeros((0, 3)))

    def settle(self, accepted):
        self.accepted += accepted.tolist()


def test_a_feed_sees_what_is_across_the_boundary():
    feed = Late()
    plan = plan_of(flat, 0.0, spheres([0.0, 1e-3, 0.05]), feed=feed)
    with closing(liggghts.build(plan)) as solver:
        travel(solver, lambda t: still(plan.surface), range(3))
    assert feed.accepted == [False, True]


def test_the_surface_is_joined_where_it_meets_itself():
    joined = join_across(surface(bent_both, 0.0), PERIOD_M)
    last, first = CELLS, 0  # numbers of the points at both sides of the first row
    assert first in joined
    assert last not in joined
    assert len(np.unique(joined)) == len(X_M) * CELLS


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_bodies_that_meet_in_a_groove_go_on_across_the_boundary(order):
    """A ball in the groove of two plates, whose points there are the same places, is pushed as elsewhere."""
    along, across_m = np.array([0.0, PERIOD_M, 0.0]), ([0.02, 0.0, 0.0], [0.01, 0.0, 0.01 * 3**0.5])
    corners_m = ([-0.02, 0.0, 0.0], [0.0, 0.0, 0.0])
    plates = [
        [np.array(c), np.array(c) + along, np.array(c) + along + a, np.array(c) + a]
        for c, a in zip(corners_m, across_m, strict=True)
    ]
    position_m = np.concatenate([plates[number] for number in order])
    triangles = np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]])
    groove = TriangleSurface(position_m, triangles, np.ones(4, dtype=np.int64))
    height_m = 0.95 * 2.5e-3  # of the centre above either plate: 5 % of overlap
    forces_N = []
    for y_m in (0.5 * PERIOD_M + 7e-4, 0.0, 5e-8, PERIOD_M - 5e-8):
        ball = spheres([-height_m / 3**0.5, y_m, height_m], diameter_m=5e-3)
        domain_m = np.array([[-0.1, 0.0, -0.1], [0.1, PERIOD_M, 0.1]])
        with closing(liggghts.build(make_plan(groove, ball, domain_m=domain_m, periodic_y=True))) as solver:
            forces_N.append(solver.initial().force_N.sum(axis=0))
    np.testing.assert_allclose(forces_N[1:], 3 * forces_N[:1], atol=1e-9 * np.abs(forces_N[0]).max())


def test_two_ranks_give_the_same_as_one_across_periodic_sides():
    single, double = ranks(1, "periodic"), ranks(2, "periodic")
    assert min(np.array(double["owned"]).T[0]) > 0
    assert double["ids"] == single["ids"]
    for name in ("impulse", "momentum", "stored", "work"):
        np.testing.assert_allclose(double[name], single[name], rtol=1e-9, atol=1e-12, err_msg=name)


def test_particles_touch_each_other_across_the_boundary():
    places = [[0.0, 1e-3, 3e-3], [0.0, PERIOD_M - 3.9e-3, 3e-3], [0.01, 0.02, 3e-3]]
    with closing(liggghts.build(plan_of(flat, 0.0, spheres(places)))) as solver:
        assert solver.snapshot().contacts.tolist() == [1, 1, 0]
