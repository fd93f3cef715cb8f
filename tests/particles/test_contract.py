"""One contract for all particle solvers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from orchestrator.ports import BrokenRecord, HermitePath, Motion
from orchestrator.ports.clock import Interval
from orchestrator.ports.plans import ExitPlan, GrainMaterial, ParticleList, ParticlesPlan
from tests.particles.contract import (
    G_M_PER_S2,
    WEIGHTLESS,
    Run,
    at_rest,
    energy_defect_J,
    particles,
    plan,
    plate,
    table,
)

Build = Callable[[ParticlesPlan], Run]

EMPTY = particles(np.empty((0, 3)))
UP = np.array([0.0, 0.0, 1.0])
MASS_KG = 1430.0 * np.pi / 6.0 * 0.01**3  # of the usual particle


def test_a_sphere_at_rest_loads_the_surface_with_its_weight(build: Build) -> None:
    surface = plate(0.02, 3)
    run = build(plan(surface, particles([0.001, 0.002, 0.00499]), restitution=table(0.2)))
    run.advance(120)
    force_N = run.load_N[-1].sum(axis=0)
    np.testing.assert_allclose(force_N, MASS_KG * G_M_PER_S2, atol=1e-6 * MASS_KG * 9.81)
    centre_m = np.einsum("i,ij->j", run.load_N[-1][:, 2], surface.position_m) / force_N[2]
    np.testing.assert_allclose(centre_m[:2], [0.001, 0.002], atol=1e-9)  # no torque is added


def test_overlaps_are_the_deepest_of_now(build: Build) -> None:
    """Spheres of 10 mm at t = 0 are 0.1 mm deep in each other, one 0.2 mm in the plate."""
    apart = particles(np.array([[0.0, 0.0, 0.0048], [0.0, 0.0, 0.0147], [0.03, 0.0, 0.05]]))
    overlaps = build(plan(plate(0.05, 3), apart)).solver.overlaps()
    assert overlaps.between_m == pytest.approx(1e-4, rel=1e-9)
    assert overlaps.between_per_diameter == pytest.approx(0.01, rel=1e-9)
    assert overlaps.surface_m == pytest.approx(2e-4, rel=1e-9)
    assert overlaps.surface_per_diameter == pytest.approx(0.02, rel=1e-9)
    lonely = build(plan(plate(0.05, 3), particles([0.0, 0.0, 0.05]))).solver.overlaps()
    assert (lonely.between_m, lonely.surface_per_diameter) == (0.0, 0.0)


@pytest.mark.smoke
def test_momentum_is_handed_over_to_rounding(build: Build) -> None:
    place_m = 0.011 * np.stack(np.meshgrid([-1, 0, 1], [-1, 0, 1], [1, 2], indexing="ij"), -1)
    place_m = place_m.reshape(-1, 3) - np.array([0.0, 0.0, 0.0055])
    velocity_m_per_s = np.random.default_rng(1).normal(0.0, 0.3, (18, 3))
    run = build(plan(plate(0.03, 5), particles(place_m, velocity_m_per_s, [5.0, -9.0, 3.0])))
    before = run.solver.account()
    run.advance(60)
    after = run.solver.account()
    gained = after.momentum_kg_m_per_s - before.momentum_kg_m_per_s - after.outside_impulse_N_s
    assert abs(run.given_N_s[2]) > 1e-2 * MASS_KG  # there were impacts
    np.testing.assert_allclose(gained + run.given_N_s, 0.0, atol=1e-12 * MASS_KG)


@pytest.mark.smoke
def test_free_flight_is_exact(build: Build) -> None:
    start_m, start_m_per_s, t = np.array([0.1, 0.2, 0.5]), np.array([0.3, -0.1, 1.0]), 0.05
    run = build(plan(plate(0.01, 1), particles(start_m, start_m_per_s, [1.0, 2.0, 3.0])))
    run.advance(50)
    now = run.solver.snapshot()
    flown_m = start_m + t * start_m_per_s + t**2 / 2.0 * G_M_PER_S2
    np.testing.assert_allclose(now.position_m[0], flown_m, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(now.velocity_m_per_s[0], start_m_per_s + t * G_M_PER_S2, rtol=0.0, atol=1e-12)
    np.testing.assert_array_equal(now.spin_rad_per_s[0], [1.0, 2.0, 3.0])


@pytest.mark.parametrize("restitution", [0.2, 0.5, 0.9])
def test_restitution_is_as_set(build: Build, restitution: float) -> None:
    """Chung, Y. C. and Ooi, J. Y., Granular Matter 13, 2011, 643-656, test 3: aluminium oxide,
    r = 2.5 mm, 3.9 m/s on a plane of the same E.  In 6 us there are some 600 steps, and the
    first and the last of them are only in part in contact: 0.2 %."""
    alumina = GrainMaterial("alumina", 380e9, 0.23)
    given = particles([0, 0, 0.00251], [0, 0, -3.9], diameter_m=0.005, density_kg_per_m3=4000.0)
    run = build(
        plan(
            plate(0.01, 1),
            given,
            materials=(alumina,),
            restitution=table(restitution),
            gravity_m_per_s2=WEIGHTLESS,
            step_s=1e-8,
            sync_interval_s=1e-6,
        )
    )
    run.until_clear()
    rebound_m_per_s = run.solver.snapshot().velocity_m_per_s[0, 2]
    assert rebound_m_per_s / 3.9 == pytest.approx(restitution, rel=2e-3)


@pytest.mark.parametrize(
    ("youngs_modulus_Pa", "poisson_ratio", "density_kg_per_m3", "peak_N", "duration_s"),
    [(70e9, 0.30, 2699.0, 11370.0, 731.7e-6), (40e9, 0.35, 1800.0, 7232.7, 767.1e-6)],
    ids=["aluminium", "magnesium"],
)
def test_elastic_impact_on_a_rigid_plane(
    build: Build,
    youngs_modulus_Pa: float,
    poisson_ratio: float,
    density_kg_per_m3: float,
    peak_N: float,
    duration_s: float,
) -> None:
    """Chung and Ooi 2011, test 2: r = 0.1 m at 0.2 m/s; the closed form of Hertz's impact."""
    ball = GrainMaterial("ball", youngs_modulus_Pa, poisson_ratio)
    rigid = GrainMaterial("rigid", 1e6 * youngs_modulus_Pa, 0.3)
    surface = plate(0.5, 1)
    surface.material[:] = 1
    given = particles([0, 0, 0.100001], [0, 0, -0.2], diameter_m=0.2, density_kg_per_m3=density_kg_per_m3)
    run = build(
        plan(
            surface,
            given,
            materials=(ball, rigid),
            restitution=np.ones((2, 2)),
            sliding_friction=np.zeros((2, 2)),
            rolling_friction=np.zeros((2, 2)),
            gravity_m_per_s2=WEIGHTLESS,
            step_s=1e-6,
            sync_interval_s=2e-6,
        )
    )
    run.until_clear()
    force_N = -np.array([load[:, 2].sum() for load in run.load_N])
    pushed = np.flatnonzero(force_N)
    assert force_N.max() == pytest.approx(peak_N, rel=1e-3)
    # the first and the last loaded interval may be loaded in part
    assert 2e-6 * len(pushed) == pytest.approx(duration_s, abs=4.1e-6)
    assert run.solver.snapshot().velocity_m_per_s[0, 2] == pytest.approx(0.2, rel=1e-4)


def test_elastic_impact_of_two_spheres(build: Build) -> None:
    """Chung and Ooi 2011, test 1: glass and limestone, r = 10 mm at +-10 m/s, closed form."""
    for material, density_kg_per_m3, overlap_m in (
        (GrainMaterial("glass", 48e9, 0.2), 2800.0, 274.11e-6),
        (GrainMaterial("limestone", 20e9, 0.25), 2500.0, 368.30e-6),
    ):
        given = particles(
            [[-0.010001, 0, 0.5], [0.010001, 0, 0.5]],
            [[10.0, 0, 0], [-10.0, 0, 0]],
            diameter_m=0.02,
            density_kg_per_m3=density_kg_per_m3,
        )
        run = build(
            plan(
                plate(0.01, 1),
                given,
                materials=(material,),
                restitution=table(1.0),
                gravity_m_per_s2=WEIGHTLESS,
                step_s=2e-8,
                sync_interval_s=2e-7,
            )
        )
        closest_m = 1.0
        for _ in range(400):
            run.advance()
            left, right = run.solver.snapshot().position_m
            closest_m = min(closest_m, right[0] - left[0])
        assert 0.02 - closest_m == pytest.approx(overlap_m, rel=1e-4)
        velocity_m_per_s = run.solver.snapshot().velocity_m_per_s[:, 0]
        np.testing.assert_allclose(velocity_m_per_s, [-10.0, 10.0], rtol=1e-4)


def test_a_moving_surface_is_seen_from_its_own_frame(build: Build) -> None:
    """Galilean: surface and sphere moved along alike give the same loads and the same path."""
    along_m_per_s = np.array([0.7, -0.2, 0.4])
    loads, ends = [], []
    for frame_m_per_s in (np.zeros(3), along_m_per_s):
        given = particles([0.001, 0.0, 0.0052], frame_m_per_s + np.array([0.1, 0.0, -0.5]), [0, 9.0, 0])
        run = build(plan(plate(0.02, 3), given))
        run.velocity_m_per_s = frame_m_per_s
        run.advance(30)
        loads.append(np.array(run.load_N))
        ends.append(run.solver.snapshot().position_m[0] - run.time_s * frame_m_per_s)
    np.testing.assert_allclose(loads[1], loads[0], atol=1e-9 * np.abs(loads[0]).max())
    np.testing.assert_allclose(ends[1], ends[0], atol=1e-12)


def test_energy_is_accounted_for_with_a_moving_surface(build: Build) -> None:
    """A surface that hits a sphere elastically does the work 2 m V^2 on it."""
    run = build(
        plan(plate(0.02, 3), particles([0, 0, 0.0052]), restitution=table(1.0), gravity_m_per_s2=WEIGHTLESS)
    )
    run.velocity_m_per_s = np.array([0.0, 0.0, 0.5])
    before = run.solver.account()
    run.until_clear()
    after = run.solver.account()
    assert after.received_J["surface"] == pytest.approx(2.0 * MASS_KG * 0.5**2, rel=1e-3)
    assert after.lost_J["contact_dissipation"] == pytest.approx(0.0, abs=1e-3 * MASS_KG * 0.5)
    assert energy_defect_J(before, after) == pytest.approx(0.0, abs=1e-3 * MASS_KG * 0.5)


def test_a_jump_of_the_surface_is_booked_as_work(build: Build) -> None:
    """The path may start where the last one did not end: a loaded surface does work by that."""
    run = build(plan(plate(0.02, 3), particles([0, 0, 0.00499]), restitution=table(0.2)))
    run.advance(100)
    before, jump_m = run.solver.account(), 5e-9  # so small that the contact's force hardly changes
    still = at_rest(run.plan.surface)
    lifted = Motion(still.position_m + jump_m * UP, still.velocity_m_per_s)
    run.solver.advance(Interval(100, 1e-3), HermitePath(lifted, lifted, 1e-3))
    work_J = run.solver.account().received_J["surface"] - before.received_J["surface"]
    assert work_J == pytest.approx(MASS_KG * 9.81 * jump_m, rel=1e-3)


def test_snapshot_is_sorted_by_id_and_keeps_what_was_given(build: Build) -> None:
    place_m = 0.02 * np.random.default_rng(2).permutation(12)[:, None] * [1, 0, 0] + [0, 0, 0.3]
    diameter_m = np.linspace(0.004, 0.01, 12)
    run = build(plan(plate(0.01, 1), particles(place_m, [0.1, 0, 0], diameter_m=diameter_m)))
    run.advance(3)
    now = run.solver.snapshot()
    np.testing.assert_array_equal(now.id, np.arange(1, 13))
    np.testing.assert_allclose(now.grains.sieve_size_m, diameter_m, rtol=1e-14)
    np.testing.assert_allclose(now.grains.density_kg_per_m3, 1430.0, rtol=1e-14)
    np.testing.assert_array_equal(now.grains.material, 0)
    np.testing.assert_allclose(now.position_m[:, 0], place_m[:, 0] + 0.1 * 0.003, atol=1e-12)


def test_who_leaves_the_domain_is_taken_out_and_booked(build: Build) -> None:
    given = particles([[0, 0, 0.1], [0, 0, 0.195]], [[0, 0, 0], [0.0, 0, 2.0]])
    domain_m = np.array([[-0.1, -0.1, -0.1], [0.1, 0.1, 0.2]])
    run = build(plan(plate(0.02, 1), given, domain_m=domain_m, gravity_m_per_s2=WEIGHTLESS))
    before = run.solver.account()
    run.advance(5)
    after = run.solver.account()
    np.testing.assert_array_equal(run.solver.snapshot().id, [1])
    np.testing.assert_allclose(after.outside_impulse_N_s, [0, 0, -2.0 * MASS_KG], rtol=1e-12)
    np.testing.assert_allclose(after.momentum_kg_m_per_s, 0.0, atol=1e-15)
    assert energy_defect_J(before, after) == pytest.approx(0.0, abs=1e-12 * MASS_KG)


def exit_box(center_m: Any, half_m: Any, turned_deg: float = 0.0) -> ExitPlan:
    """A box turned about y."""
    axes = Rotation.from_euler("y", turned_deg, degrees=True).as_matrix().T
    return ExitPlan("box", "undersize", np.array(center_m), axes, np.array(half_m))


@pytest.mark.smoke
def test_exits_take_out_who_is_inside(build: Build) -> None:
    """Three spheres fly 20 mm along x: into an exit, below it, out of the domain; a fourth rests
    where the first exit and a second overlap."""
    given = particles([[-0.02, 0, 0.05], [-0.02, 0, 0.01], [0.09, 0, 0.05], [0, 0, 0.08]])
    given.velocity_m_per_s[:3, 0] = 2.0
    exits = (exit_box([0, 0, 0.06], [0.01, 0.1, 0.03]), exit_box([0, 0, 0.09], [0.1, 0.1, 0.02]))
    domain_m = np.array([[-0.1, -0.1, -0.1], [0.1, 0.1, 0.2]])
    run = build(plan(plate(0.02, 1), given, domain_m=domain_m, exits=exits, gravity_m_per_s2=WEIGHTLESS))
    before = run.solver.account()
    run.advance(10)
    after, gone = run.solver.account(), run.solver.removed()
    np.testing.assert_array_equal(run.solver.snapshot().id, [2])
    order = np.argsort(gone.id)
    np.testing.assert_array_equal(gone.id[order], [1, 3, 4])
    np.testing.assert_array_equal(gone.exit[order], [0, -1, 0])
    np.testing.assert_array_equal(gone.grains.sieve_size_m, 0.01)
    np.testing.assert_array_equal(gone.grains.density_kg_per_m3, 1430.0)
    np.testing.assert_array_equal(gone.grains.material, 0)
    assert (np.diff(gone.time_s) >= 0.0).all()
    flown_m = given.position_m[gone.id - 1] + gone.time_s[:, None] * given.velocity_m_per_s[gone.id - 1]
    np.testing.assert_allclose(gone.position_m, flown_m, atol=1e-12)
    first, lost = gone.position_m[order[:2], 0]
    assert -0.01 <= first < -0.005  # caught within half a diameter of the exit's face
    assert 0.1 < lost < 0.105
    np.testing.assert_allclose(after.outside_impulse_N_s, [-4.0 * MASS_KG, 0, 0], rtol=1e-12)
    assert energy_defect_J(before, after) == pytest.approx(0.0, abs=1e-12 * MASS_KG)
    assert len(run.solver.removed().id) == 0


def test_an_exit_takes_only_who_is_below_the_deck_that_reaches_into_it(build: Build) -> None:
    """A plate with an opening of 20 mm in the middle of an exit of the undersize: who hovers over the plate
    or over its opening stays, who is below the plate, in its opening or beside its edge is taken.  All are
    taken around a wall, and by an exit of the oversize."""
    whole = plate(0.05, 5)
    middle = np.abs(whole.position_m[whole.triangles].mean(axis=1)[:, :2]).max(axis=1) < 0.01
    places_m = [[0.03, 0, 0.006], [0, 0, 0.004], [0.03, 0, -0.006], [0, 0, -0.001], [0.08, 0, -0.02]]
    everybody = [1, 2, 3, 4, 5]
    for panel, product, gone in (
        (0, "undersize", everybody[2:]),
        (-1, "undersize", everybody),
        (0, "oversize", everybody),
    ):
        triangles = whole.triangles[~middle]
        panels = np.full(len(triangles), panel)
        surface = replace(whole, triangles=triangles, material=whole.material[~middle], panel=panels)
        exits = (replace(exit_box([0, 0, 0], [0.09, 0.09, 0.03]), product=product),)
        run = build(plan(surface, particles(places_m), exits=exits, gravity_m_per_s2=WEIGHTLESS))
        run.advance(2)
        np.testing.assert_array_equal(np.sort(run.solver.removed().id), gone)


def test_an_exit_is_turned_with_the_deck(build: Build) -> None:
    """A flat box turned by 30 degrees holds what is along its own axis, not along the world's."""
    along = np.array([np.cos(np.pi / 6), 0.0, -np.sin(np.pi / 6)])
    given = particles([0.08 * along, [0.08, 0, 0]], 0.02 * UP)
    exits = (exit_box([0, 0, 0], [0.1, 0.01, 0.01], 30.0),)
    run = build(plan(plate(0.01, 1), given, exits=exits, gravity_m_per_s2=WEIGHTLESS))
    run.advance(200)
    np.testing.assert_array_equal(run.solver.removed().id, [1])


def test_who_falls_into_an_exit_is_booked_to_rounding(build: Build) -> None:
    """Gravity acts until a particle is taken out: its speed there is that of its fall."""
    given = particles([[0, 0, 0.1], [0.05, 0, 0.1]], [0.3, 0, -1.0], [10.0, 0, 0])
    exits = (exit_box([0, 0, 0.0], [0.2, 0.2, 0.06]),)
    run = build(plan(plate(0.001, 1), given, exits=exits))
    before = run.solver.account()
    run.advance(60)
    after, gone = run.solver.account(), run.solver.removed()
    assert len(gone.id) == 2
    t = gone.time_s[:, None]
    np.testing.assert_allclose(gone.velocity_m_per_s, [0.3, 0, -1.0] + t * G_M_PER_S2, atol=1e-12)
    fallen_m = given.position_m + t * [0.3, 0, -1.0] + t**2 / 2.0 * G_M_PER_S2
    np.testing.assert_allclose(gone.position_m, fallen_m, atol=1e-12)
    taken_N_s = MASS_KG * np.linalg.norm(gone.velocity_m_per_s, axis=1).sum()
    assert after.moved_N_s in (0.0, pytest.approx(taken_N_s, rel=1e-12))  # 0: not told
    left_N_s = after.outside_impulse_N_s + before.momentum_kg_m_per_s
    np.testing.assert_allclose(left_N_s, 0.0, atol=1e-12 * MASS_KG)
    assert energy_defect_J(before, after) == pytest.approx(0.0, abs=1e-12 * MASS_KG)
    assert after.lost_J["contact_dissipation"] == pytest.approx(0.0, abs=1e-12 * MASS_KG)


@dataclass
class OnceAt:
    """Offers particles in one interval and remembers the answer."""

    index: int
    given: ParticleList
    accepted: list[bool] = field(default_factory=list)

    def due(self, interval: Interval) -> ParticleList:
        return self.given if interval.index == self.index else EMPTY

    def settle(self, accepted: np.ndarray) -> None:
        self.accepted.extend(accepted.tolist())


class OneEachTime:
    """Offers a particle in each interval, which moves as those that are there."""

    def due(self, interval: Interval) -> ParticleList:
        falling_m_per_s = np.array([0.0, 0.0, -1.0]) + interval.start_s * G_M_PER_S2
        return particles([0.02 * (interval.index % 20) - 0.2, 0.3, 0.3], falling_m_per_s)

    def settle(self, accepted: np.ndarray) -> None:
        assert accepted.all()


def test_exits_act_while_a_feed_brings_particles_all_the_time(build: Build) -> None:
    """Neighbours are listed for those who come; nobody moves far against the others in between."""
    exits = (exit_box([0, 0, 0.0], [0.2, 0.2, 0.06]),)
    given = particles([0.1, -0.05, 0.1], [0.0, 0.0, -1.0], [10.0, 3.0, 0.0])
    run = build(plan(plate(0.001, 1), given, exits=exits, feed=OneEachTime()))
    before = run.solver.account()
    run.advance(60)
    after, gone = run.solver.account(), run.solver.removed()
    np.testing.assert_array_equal(gone.id, [1])
    t = float(gone.time_s[0])
    assert 0.0585 <= gone.position_m[0, 2] <= 0.06  # one interval's way behind the exit's face
    np.testing.assert_allclose(gone.position_m[0, 2], 0.1 - t + t**2 / 2.0 * G_M_PER_S2[2], atol=1e-12)
    np.testing.assert_allclose(gone.velocity_m_per_s[0], [0, 0, -1.0] + t * G_M_PER_S2, atol=1e-12)
    gained_N_s = after.momentum_kg_m_per_s - before.momentum_kg_m_per_s
    outside_N_s = after.outside_impulse_N_s - before.outside_impulse_N_s
    np.testing.assert_allclose(gained_N_s, outside_N_s, atol=1e-12 * 60 * MASS_KG)
    assert energy_defect_J(before, after) == pytest.approx(0.0, abs=1e-12 * 60 * MASS_KG)
    if after.angular is not None and before.angular is not None:
        gained = after.angular.momentum_kg_m2_per_s - before.angular.momentum_kg_m2_per_s
        outside = after.angular.outside_impulse_N_m_s - before.angular.outside_impulse_N_m_s
        np.testing.assert_allclose(gained, outside, atol=1e-12 * 60 * MASS_KG)


def test_feed_is_booked_and_finds_room_or_not(build: Build) -> None:
    given = particles([[0, 0, 0.3], [0, 0, 0.2]], [[1, 0, 0], [2, 0, 0]], material=0)
    feed = OnceAt(2, given)
    present = particles([0, 0, 0.205])
    run = build(plan(plate(0.02, 1), present, feed=feed, gravity_m_per_s2=WEIGHTLESS))
    before = run.solver.account()
    run.advance(6)
    after = run.solver.account()
    now = run.solver.snapshot()
    assert feed.accepted == [True, False]
    np.testing.assert_array_equal(now.id, [1, 2])
    np.testing.assert_allclose(now.position_m[1], [0.004, 0, 0.3], atol=1e-12)
    np.testing.assert_allclose(after.outside_impulse_N_s, [MASS_KG, 0, 0], rtol=1e-12)
    assert after.supplied_J["feed"] == pytest.approx(MASS_KG / 2.0, rel=1e-12)
    assert energy_defect_J(before, after) == pytest.approx(0.0, abs=1e-12 * MASS_KG)


def test_a_feed_finds_no_room_where_the_surface_is(build: Build) -> None:
    """One sphere in the middle of a facet, one 4 mm above (radius 5 mm), one 6 mm above."""
    given = particles([[0.001, 0.002, 0], [0.02, 0, 0.004], [0, 0.02, 0.006]])
    feed = OnceAt(0, given)
    run = build(plan(plate(0.05, 2), EMPTY, feed=feed, gravity_m_per_s2=WEIGHTLESS))
    run.advance(1)
    assert feed.accepted == [False, False, True]


def test_a_feed_can_start_with_no_particles_at_all(build: Build) -> None:
    feed = OnceAt(1, particles([0, 0, 0.0055], [0, 0, -0.5]))
    run = build(plan(plate(0.02, 3), EMPTY, feed=feed))
    run.advance(20)
    assert len(run.solver.snapshot().id) == 1
    assert run.given_N_s[2] < -MASS_KG * 0.5  # it hit the surface and came back


def test_probe_points_get_no_load(build: Build) -> None:
    surface = plate(0.02, 2, probes=3)
    run = build(plan(surface, particles([0.001, 0.002, 0.00499])))
    assert run.solver.initial().force_N.shape == (12, 3)
    run.advance(5)
    assert run.load_N[-1].shape == (12, 3)
    np.testing.assert_array_equal(run.load_N[-1][9:], 0.0)
    assert run.load_N[-1][:9, 2].sum() < 0.0


def test_initial_load_is_the_force_at_the_start(build: Build) -> None:
    run = build(plan(plate(0.02, 3), particles([0, 0, 0.0049])))
    E_star_Pa = 1e7 / (2.0 * (1.0 - 0.3**2))
    hertz_N = 4.0 / 3.0 * E_star_Pa * 0.005**0.5 * 1e-4**1.5
    np.testing.assert_allclose(
        run.solver.initial().force_N.sum(axis=0), [0, 0, -hertz_N], rtol=1e-9, atol=1e-12
    )


def test_a_wrong_number_of_surface_points_is_refused(build: Build) -> None:
    run = build(plan(plate(0.02, 2), particles([0, 0, 0.1])))
    wrong = at_rest(plate(0.02, 3))
    with pytest.raises(BrokenRecord, match=r"\b9\b.*\b16\b"):
        run.solver.advance(Interval(0, 1e-3), HermitePath(wrong, wrong, 1e-3))


def test_a_surface_with_a_nan_cannot_cross() -> None:
    still = at_rest(plate(0.02, 2))
    position_m = still.position_m.copy()
    position_m[4, 1] = np.nan
    with pytest.raises(BrokenRecord, match=r"\b4\b"):
        Motion(position_m, still.velocity_m_per_s)
