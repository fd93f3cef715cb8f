"""Grains of several spheres: the contract of the port, for every solver that takes them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import pi

import numpy as np
import numpy.typing as npt
import pytest

from orchestrator.case import solvers
from orchestrator.ports.clock import Interval
from orchestrator.ports.grains import Shape, ShapeTable, turned
from orchestrator.ports.plans import ParticleFeed, ParticleList, ParticlesPlan
from tests.docs.pages import code_on
from tests.particles import test_contract
from tests.particles.contract import (
    G_M_PER_S2,
    SOLVERS,
    WEIGHTLESS,
    Run,
    energy_defect_J,
    particles,
    plan,
    plate,
)
from tests.particles.test_contract import OnceAt

ASKED = SOLVERS
Build = Callable[[ParticlesPlan], Run]
DUMBBELL = solvers.shape("dumbbell")
D_M = 0.01
MASS_KG = 2 * 1430.0 * pi / 6 * D_M**3
ALONG_KG_M2 = MASS_KG * D_M**2 / 10
ACROSS_KG_M2 = ALONG_KG_M2 + MASS_KG * D_M**2 / 4


def made_of(shape: Shape, given: ParticleList) -> ParticleList:
    return replace(given, grains=replace(given.grains, shapes=ShapeTable.of([shape])))


def dumbbells(shape: Shape, plan: ParticlesPlan) -> ParticlesPlan:
    """The plan with such grains in place of its spheres."""
    given = made_of(shape, plan.particles)
    feed = None if plan.feed is None else Reshaped(shape, plan.feed)
    radius_m = shape.bounding_radius / 0.5 * plan.largest_radius_m
    return replace(plan, shapes=(shape,), particles=given, largest_radius_m=radius_m, feed=feed)


@dataclass
class Reshaped:
    """A feed of such grains in place of its spheres."""

    shape: Shape
    feed: ParticleFeed

    def due(self, interval: Interval) -> ParticleList:
        return made_of(self.shape, self.feed.due(interval))

    def settle(self, accepted: npt.NDArray[np.bool_]) -> None:
        self.feed.settle(accepted)


OF_ANY_SHAPE = [
    test_contract.test_snapshot_is_sorted_by_id_and_keeps_what_was_given,
    test_contract.test_who_leaves_the_domain_is_taken_out_and_booked,
    test_contract.test_exits_take_out_who_is_inside,
    test_contract.test_an_exit_is_turned_with_the_deck,
    test_contract.test_feed_is_booked_and_finds_room_or_not,
    test_contract.test_a_wrong_number_of_surface_points_is_refused,
]


@pytest.mark.parametrize("test", OF_ANY_SHAPE, ids=lambda test: test.__name__)
def test_the_contract_holds_for_a_dumbbell(build: Build, test: Callable[[Build], None]) -> None:
    """The dumbbell is as light as a sphere of its sieve size, whose mass the contract expects."""
    hollow = replace(DUMBBELL, volume=pi / 6, inertia=tuple(np.array(DUMBBELL.inertia) / 2))
    test(lambda plan: build(dumbbells(hollow, plan)))


def test_the_page_has_this_dumbbell() -> None:
    page: dict[str, object] = {}
    exec(code_on("how-to/add-a-shape.md")[0], page)
    assert page["ADAPTER"] == DUMBBELL


def test_mass_and_inertia_are_those_of_two_spheres() -> None:
    grains = made_of(DUMBBELL, particles([0, 0, 0])).grains
    assert grains.mass_kg[0] == pytest.approx(MASS_KG, rel=1e-14)
    np.testing.assert_allclose(grains.inertia_kg_m2[0], [ACROSS_KG_M2, ACROSS_KG_M2, ALONG_KG_M2], rtol=1e-14)
    assert grains.bounding_radius_m[0] == D_M
    assert grains.contact_radius_m[0] == D_M / 2
    assert grains.equivalent_diameter_m[0] == pytest.approx(2 ** (1 / 3) * D_M, rel=1e-14)


def test_a_free_dumbbell_tumbles_as_euler_s_top(build: Build) -> None:
    """Its axis precesses about the angular momentum L at L / (moment across), by 1.9 turns in 0.1 s."""
    spin = np.array([80.0, 0.0, 60.0])
    given = particles([0, 0, 0.3], spin_rad_per_s=spin)
    run = build(dumbbells(DUMBBELL, plan(plate(0.01, 1), given, gravity_m_per_s2=WEIGHTLESS)))
    before = run.solver.account()
    run.advance(100)
    after = run.solver.account()
    momentum = spin * [ACROSS_KG_M2, ACROSS_KG_M2, ALONG_KG_M2]
    assert after.angular is not None
    np.testing.assert_allclose(after.angular.momentum_kg_m2_per_s, momentum, rtol=1e-11, atol=1e-16)
    assert after.stored_J["kinetic"] == pytest.approx(before.stored_J["kinetic"], rel=1e-7)
    size = np.linalg.norm(momentum)
    about, turned = momentum / size, size / ACROSS_KG_M2 * 0.1
    along = (spin @ about) * about  # of the spin; the rest goes round
    across = spin - along
    now = along + np.cos(turned) * across + np.sin(turned) * np.cross(about, across)
    np.testing.assert_allclose(run.solver.snapshot().spin_rad_per_s[0], now, atol=1e-3 * np.linalg.norm(spin))


def test_a_dumbbell_on_end_loads_the_surface_with_its_weight(build: Build) -> None:
    given = particles([0.001, 0.002, 0.00999])
    run = build(dumbbells(DUMBBELL, plan(plate(0.02, 3), given)))
    run.advance(60)
    force_N = np.mean(run.load_N[-20:], axis=0)
    np.testing.assert_allclose(force_N.sum(axis=0)[2], MASS_KG * G_M_PER_S2[2], rtol=1e-3)


def test_an_oblique_hit_turns_it_as_the_impulse_says(build: Build) -> None:
    """A frictionless elastic hit at one end of a dumbbell that lies in the air.

    The plate gives the impulse J = 2 m v / (1 + m a^2 / I), at the arm a = d / 2 from the middle (Stronge,
    W. J., Impact Mechanics, 2000, chapter 3); the other end stays clear of it for the time of the hit.
    """
    surface = plate(0.03, 1)
    surface.position_m[:, 0] += 0.03 + 0.001  # it ends below the middle: one sphere meets it
    given = particles([0, 0, 0.00502], [0, 0, -0.5])
    lying = replace(DUMBBELL, spheres=((-0.5, 0, 0, 0.5), (0.5, 0, 0, 0.5)), inertia=DUMBBELL.inertia[::-1])
    smooth = plan(
        surface,
        given,
        gravity_m_per_s2=WEIGHTLESS,
        restitution=np.ones((1, 1)),
        sliding_friction=np.zeros((1, 1)),
    )
    run = build(dumbbells(lying, smooth))
    run.until_clear()
    now, arm_m = run.solver.snapshot(), D_M / 2
    impulse_N_s = 2 * MASS_KG * 0.5 / (1 + MASS_KG * arm_m**2 / ACROSS_KG_M2)
    assert now.velocity_m_per_s[0, 2] == pytest.approx(impulse_N_s / MASS_KG - 0.5, abs=2e-2 * 0.5)
    spin = -impulse_N_s * arm_m / ACROSS_KG_M2  # about y: the end along x is thrown up
    assert now.spin_rad_per_s[0, 1] == pytest.approx(spin, rel=2e-2)


def test_a_rod_that_slides_begins_to_roll(build: Build) -> None:
    """Thrown across its axis, it slides until v = m r^2 / (I + m r^2) of the first speed, 5/7 of a sphere's.

    Friction 0.3 g takes the rest away: the closed form of a body that rolls about a principal axis.  The
    contacts give way by 1e-3 of the radius.
    """
    rod = solvers.shape("rod")
    lying = replace(rod, spheres=tuple((z, y, x, r) for x, y, z, r in rod.spheres), inertia=rod.inertia[::-1])
    given = particles([0, -0.015, 0.005], [0, 0.2, 0])
    run = build(dumbbells(lying, plan(plate(0.04, 3), given)))
    share = rod.volume / 4 / (rod.inertia[2] + rod.volume / 4)
    stops_s = 0.2 * (1 - share) / (0.3 * 9.81)
    run.advance(round(0.5 * stops_s / 1e-3))
    _, along, up = run.solver.snapshot().velocity_m_per_s[0]
    load = 9.81 * run.time_s + up  # the impulse of the plate over the mass
    assert along == pytest.approx(0.2 - 0.3 * load, abs=2e-4)
    run.advance(round(1.5 * stops_s / 1e-3))
    now = run.solver.snapshot()
    assert now.velocity_m_per_s[0, 1] == pytest.approx(share * 0.2, rel=5e-3)
    assert now.spin_rad_per_s[0, 0] == pytest.approx(-share * 0.2 / 0.005, rel=1e-2)


def test_books_close_while_dumbbells_come_hit_and_leave(build: Build) -> None:
    """Momentum and angular momentum to the rounding of 6000 steps, energy to the error of a step."""
    place_m = np.array(
        [[-0.012, 0.0, 0.02], [0.004, 0.003, 0.021], [0.015, -0.004, 0.043], [-0.01, 0.0, 0.045]]
    )
    given = particles(place_m, [0.1, 0.05, -0.6], [5.0, -9.0, 3.0])
    feed = OnceAt(10, particles([0.0, 0.01, 0.08], [0.0, 0.0, -1.0], [20.0, 0.0, 5.0]))
    domain_m = np.array([[-0.025, -0.03, -0.1], [0.018, 0.03, 0.2]])
    run = build(dumbbells(DUMBBELL, plan(plate(0.03, 5), given, feed=feed, domain_m=domain_m)))
    before = run.solver.account()
    run.advance(120)
    after, gone = run.solver.account(), run.solver.removed()
    assert feed.accepted == [True]
    assert 0 < len(gone.id) < 5
    np.testing.assert_array_equal(gone.grains.shapes.name[gone.grains.shape], "dumbbell")
    assert abs(run.given_N_s[2]) > MASS_KG  # there were impacts
    gained = after.momentum_kg_m_per_s - before.momentum_kg_m_per_s - after.outside_impulse_N_s
    np.testing.assert_allclose(gained + run.given_N_s, 0.0, atol=1e-11 * MASS_KG)
    earlier, later = before.angular, after.angular
    assert earlier is not None
    assert later is not None
    turned = later.momentum_kg_m2_per_s - earlier.momentum_kg_m2_per_s - later.outside_impulse_N_m_s
    turned = turned + earlier.outside_impulse_N_m_s
    received = later.received_N_m_s["surface"] - earlier.received_N_m_s["surface"]
    np.testing.assert_allclose(turned, received, atol=1e-12 * MASS_KG)
    moved_J = 5 * MASS_KG * 0.6**2
    assert energy_defect_J(before, after) == pytest.approx(0.0, abs=1e-2 * moved_J)


def test_a_feed_looks_at_each_sphere(build: Build) -> None:
    """The feed has room beside an upright dumbbell within the sphere that holds it, and none above it."""
    feed = OnceAt(0, particles([[0.0105, 0, 0.1], [0, 0, 0.119], [0, 0.05, 0.1]]))
    present = particles([0, 0, 0.1])
    run = build(dumbbells(DUMBBELL, plan(plate(0.02, 1), present, feed=feed, gravity_m_per_s2=WEIGHTLESS)))
    run.advance()
    assert feed.accepted == [True, False, True]


def test_it_goes_on_bit_for_bit_after_a_restore(build: Build) -> None:
    given = particles([[0, 0, 0.0101], [0.004, 0.003, 0.033]], [0.3, 0.1, -0.5], [5.0, -9.0, 3.0])
    wanted = dumbbells(DUMBBELL, plan(plate(0.03, 3), given))
    first, second = build(wanted), build(wanted)
    first.advance(20)
    second.solver.restore(first.solver.save())
    second.index = first.index
    for run in (first, second):
        run.advance(60)
    for name in ("position_m", "velocity_m_per_s", "spin_rad_per_s"):
        mine, its = (getattr(run.solver.snapshot(), name) for run in (first, second))
        np.testing.assert_array_equal(mine, its)


def test_a_grain_is_turned_as_it_was_given_and_as_it_spins(build: Build) -> None:
    """A dumbbell that lies along (0.6, 0.8, 0) spins about z by a quarter of a turn in 0.1 s."""
    half = np.sqrt(0.5)  # of a right angle, about (-0.8, 0.6, 0): from z to (0.6, 0.8, 0)
    lies = np.array([[half, -0.8 * half, 0.6 * half, 0.0]])
    given = replace(particles([0, 0, 0.3], spin_rad_per_s=[0, 0, 5 * pi]), orientation=lies)
    run = build(dumbbells(DUMBBELL, plan(plate(0.01, 1), given, gravity_m_per_s2=WEIGHTLESS)))

    def axis() -> npt.NDArray[np.float64]:
        return turned(run.solver.snapshot().orientation, np.array([[0.0, 0.0, 1.0]]))[0]

    np.testing.assert_allclose(axis(), [0.6, 0.8, 0.0], atol=1e-14)
    run.advance(100)
    np.testing.assert_allclose(axis(), [-0.8, 0.6, 0.0], atol=1e-4)
    run.advance(100)
    np.testing.assert_allclose(axis(), [-0.6, -0.8, 0.0], atol=2e-4)


def test_a_lying_dumbbell_touches_with_both_spheres(build: Build) -> None:
    """It rests half as high as an upright one, and a feed sees where its spheres are."""
    half = np.sqrt(0.5)
    flat = np.array([[half, half, 0.0, 0.0]])  # about x: its axis along y
    given = replace(particles([0, 0, 0.00501]), orientation=flat)
    offered = replace(particles([[0, 0.009, 0.012], [0.009, 0, 0.012]]), orientation=np.tile(flat, (2, 1)))
    feed = OnceAt(5, offered)
    run = build(dumbbells(DUMBBELL, plan(plate(0.03, 3), given, feed=feed)))
    run.advance(40)
    assert feed.accepted == [False, True]
    assert run.solver.snapshot().position_m[0, 2] == pytest.approx(0.005, rel=1e-2)


def test_books_know_how_fed_grains_are_turned(build: Build) -> None:
    """Angular momentum and energy that come in are those of a turned body that spins about no own axis."""
    turn = np.array([[0.5, 0.5, -0.5, 0.5]])
    spins = replace(particles([0, 0, 0.3], [0.1, 0, 0], [30.0, 35.0, 20.0]), orientation=turn)
    nobody = particles(np.empty((0, 3)))
    feed = OnceAt(0, spins)
    run = build(dumbbells(DUMBBELL, plan(plate(0.01, 1), nobody, feed=feed, gravity_m_per_s2=WEIGHTLESS)))
    before = run.solver.account()
    run.advance(3)
    after = run.solver.account()
    axis = turned(turn, np.array([[0.0, 0.0, 1.0]]))[0]
    spin = spins.spin_rad_per_s[0]
    own = ACROSS_KG_M2 * spin + (ALONG_KG_M2 - ACROSS_KG_M2) * (spin @ axis) * axis
    orbital = MASS_KG * np.cross(spins.position_m[0], spins.velocity_m_per_s[0])
    assert after.angular is not None
    np.testing.assert_allclose(after.angular.momentum_kg_m2_per_s, own + orbital, rtol=1e-12)
    np.testing.assert_allclose(after.angular.outside_impulse_N_m_s, own + orbital, rtol=1e-12)
    assert energy_defect_J(before, after) == pytest.approx(0.0, abs=1e-8)
