"""Features of the spheres in NumPy: friction, energy and the order of Verlet."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator.ports import Array
from orchestrator.ports.geometry import closest_on_triangle
from orchestrator.ports.plans import ExitPlan, GrainMaterial
from tests.particles.contract import WEIGHTLESS, Run, energy_defect_J, particles, plan, plate, table
from tests.reference import spheres

MASS_KG = 1430.0 * np.pi / 6.0 * 0.01**3


def opened(given: object) -> Run:
    return Run(spheres.build(given), given)  # type: ignore[arg-type]


def test_a_sliding_sphere_ends_rolling_at_five_sevenths() -> None:
    """Sliding friction torques a solid sphere until it rolls: u = 5 u0 / 7, spin = u / r (any
    textbook of mechanics); the spring's half overlap in the lever adds delta / 2r = 0.2 %."""
    run = opened(plan(plate(0.3, 1), particles([-0.1, 0.02, 0.00498], [0.3, 0, 0]), restitution=table(0.3)))
    run.advance(150)  # sliding ends after 2 u0 / (7 mu g) = 29 ms
    now = run.solver.snapshot()
    assert now.velocity_m_per_s[0, 0] == pytest.approx(0.3 * 5.0 / 7.0, rel=2e-3)
    assert now.spin_rad_per_s[0, 1] * 0.005 == pytest.approx(0.3 * 5.0 / 7.0, rel=4e-3)


def test_an_oblique_impact_that_slides_throughout() -> None:
    """Friction takes mu (1 + e) v_n from the tangential velocity and gives 5/2 of that, over r, to
    the spin, as long as tan(angle) > 7/2 mu (1 + e) (Chung and Ooi 2011, test 4).  The damper's
    pull at the end also rubs: |F_n| is used as in LIGGGHTS, so e = 1 here."""
    impact = particles([0, 0, 0.00501], [3.0, 0, -1.0])
    run = opened(
        plan(
            plate(0.05, 1),
            impact,
            restitution=table(1.0),
            sliding_friction=table(0.1),
            gravity_m_per_s2=WEIGHTLESS,
            step_s=2e-6,
        )
    )
    run.until_clear()
    now = run.solver.snapshot()
    assert now.velocity_m_per_s[0, 2] == pytest.approx(1.0, rel=1e-3)
    assert now.velocity_m_per_s[0, 0] == pytest.approx(3.0 - 0.1 * 2.0, rel=1e-3)
    # the lever is r - delta / 2; the overlap reaches 6 % of r here
    assert now.spin_rad_per_s[0, 1] * 0.005 == pytest.approx(2.5 * 0.1 * 2.0, rel=0.04)


def test_a_contact_between_spheres_keeps_the_angular_momentum() -> None:
    given = particles(
        [[-0.00501, 0, 0.5], [0.00501, 0.003, 0.5]], [[0.5, 0, 0], [-0.5, 0.1, 0]], [0, 3.0, 20.0]
    )
    run = opened(plan(plate(0.01, 1), given, gravity_m_per_s2=WEIGHTLESS))

    def angular_momentum() -> Array:
        now = run.solver.snapshot()
        orbital = np.cross(now.position_m - [0, 0, 0.5], now.velocity_m_per_s)
        return MASS_KG * (orbital + 0.4 * 0.005**2 * now.spin_rad_per_s).sum(axis=0)

    before = angular_momentum()
    run.advance(30)
    speed_m_per_s = run.solver.snapshot().velocity_m_per_s[0, 0]
    assert speed_m_per_s < 0.0  # they met
    # to the rounding of 1500 steps
    np.testing.assert_allclose(angular_momentum(), before, rtol=0.0, atol=1e-11 * np.abs(before).max())


def bouncing_spheres(step_s: float) -> Run:
    """Eighteen spheres dropped onto a plate that moves up and along."""
    place_m = 0.011 * np.stack(np.meshgrid([-1, 0, 1], [-1, 0, 1], [1, 2], indexing="ij"), -1)
    place_m = place_m.reshape(-1, 3) - np.array([0.0, 0.0, 0.0055])
    velocity_m_per_s = np.random.default_rng(1).normal(0.0, 0.3, (18, 3))
    run = opened(plan(plate(0.05, 5), particles(place_m, velocity_m_per_s, [5.0, -9.0, 3.0]), step_s=step_s))
    run.velocity_m_per_s = np.array([0.3, 0.0, 0.2])
    return run


def test_the_energy_account_closes_at_second_order() -> None:
    """Work of dampers and friction is summed by itself, so that the defect is a real check."""
    defect_J = []
    for step_s in (2e-5, 1e-5):
        run = bouncing_spheres(step_s)
        before = run.solver.account()
        run.advance(40)
        after = run.solver.account()
        defect_J.append(abs(energy_defect_J(before, after)))
        turned_over_J = after.lost_J["contact_dissipation"] + after.received_J["surface"]
    assert turned_over_J > 5e-4
    assert defect_J[1] < 1e-3 * turned_over_J
    assert defect_J[1] < 0.5 * defect_J[0]


def test_verlet_is_of_second_order() -> None:
    """Elastic bounce: the place inside the contact, against a fine step."""
    places_m = []
    for steps in (25, 50, 100, 1600):
        given = particles([0, 0, 0.005], [0.0, 0, -0.5])
        run = opened(plan(plate(0.02, 1), given, restitution=table(1.0), step_s=1e-3 / steps))
        run.advance(1)  # the whole contact lasts 1.3 ms
        places_m.append(run.solver.snapshot().position_m[0, 2])
    error_m = np.abs(np.array(places_m[:3]) - places_m[3])
    order = np.log2(error_m[:-1] / error_m[1:])
    np.testing.assert_allclose(order, 2.0, atol=0.2)


def test_closest_points_are_nearer_than_any_sample_of_the_triangle() -> None:
    generator = np.random.default_rng(4)
    point_m, corners_m = generator.normal(size=(400, 3)), generator.normal(size=(400, 3, 3))
    weights = closest_on_triangle(point_m, corners_m)
    assert (weights >= 0.0).all()
    np.testing.assert_allclose(weights.sum(axis=1), 1.0, atol=1e-12)

    def distance(some: Array) -> Array:
        return np.linalg.norm(np.einsum("ij,ijk->ik", some, corners_m) - point_m, axis=1)

    nearest = distance(weights)
    for _ in range(200):
        assert np.all(nearest <= distance(generator.dirichlet([0.5] * 3, 400)) + 1e-12)


def test_two_materials_give_the_series_stiffness() -> None:
    """1 / E* adds up the two half-spaces' compliances (Hertz)."""
    hard, soft = GrainMaterial("hard", 2e9, 0.2), GrainMaterial("soft", 1e7, 0.45)
    surface = plate(0.02, 1)
    surface.material[:] = 1
    table = np.full((2, 2), 0.5)
    given = plan(
        surface,
        particles([0, 0, 0.0049]),
        materials=(hard, soft),
        restitution=table,
        sliding_friction=table,
        rolling_friction=np.zeros((2, 2)),
    )
    E_star_Pa = 1.0 / ((1.0 - 0.2**2) / 2e9 + (1.0 - 0.45**2) / 1e7)
    force_N = opened(given).solver.initial().force_N[:, 2].sum()
    assert force_N == pytest.approx(-4.0 / 3.0 * E_star_Pa * 0.005**0.5 * 1e-4**1.5, rel=1e-9)


@pytest.mark.parametrize("restitution", [0.0, 1.1])
def test_an_impossible_restitution_is_refused(restitution: float) -> None:
    with pytest.raises(ValueError, match="restitution"):
        spheres.build(plan(plate(0.02, 1), particles([0, 0, 0.1]), restitution=table(restitution)))


def test_contacts_go_on_when_another_particle_leaves_or_comes() -> None:
    """The load on the surface of a resting sphere does not notice that another one leaves."""
    given = particles([[0.004, 0, 0.15], [0, 0, 0.00499]], [[50.0, 0, 0], [0, 0, 0]])
    domain_m = np.array([[-1.0, -1.0, -1.0], [0.5, 1.0, 1.0]])
    both = opened(plan(plate(0.02, 2), given, domain_m=domain_m))
    alone = opened(plan(plate(0.02, 2), particles([0, 0, 0.00499])))
    both.advance(30)
    alone.advance(30)
    assert len(both.solver.snapshot().id) == 1
    np.testing.assert_allclose(both.load_N, alone.load_N, atol=1e-15)


def test_contacts_that_end_by_removal_take_their_energy_along() -> None:
    """Two spheres pressed 0.5 mm into each other and the lower one into the plate; the upper one is
    in an exit: what their contact stores goes with it."""
    exits = (ExitPlan("above", "undersize", np.array([0.0, 0.0, 0.05]), np.eye(3), 0.04 * np.ones(3)),)
    given = particles([[0.0, 0.0, 0.0045], [0.0, 0.0, 0.0140]])
    quick = {"restitution": table(1.0), "step_s": 1e-7, "sync_interval_s": 1e-6}
    run = opened(plan(plate(0.02, 3), given, exits=exits, **quick))
    before = run.solver.account()
    run.advance()
    after = run.solver.account()
    np.testing.assert_array_equal(run.solver.snapshot().id, [1])
    E_Pa, overlap_m = 1e7 / (2.0 * (1.0 - 0.3**2)), 0.0005
    between_J = 2.0 / 5.0 * 4.0 / 3.0 * E_Pa * np.sqrt(0.0025) * overlap_m**2.5
    change_J = after.stored_J["contact_elastic"] - before.stored_J["contact_elastic"]
    assert change_J == pytest.approx(-between_J, rel=0.02)
    assert energy_defect_J(before, after) == pytest.approx(0.0, abs=1e-4 * between_J)
