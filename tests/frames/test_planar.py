"""planar against closed forms, two_mass and exudyn; tolerances are rounding unless stated."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import ellipk

from adapters.frames import exudyn, prescribed, two_mass
from orchestrator.ports import Array, Frames, Load
from orchestrator.ports.clock import Interval
from orchestrator.ports.plans import BodyPlan, BushingPlan, FramesPlan, SolverFailed
from tests.frames.contract import both_driven, compared, drive, driven, loads, one_driven
from tests.frames.driven_base import carried_along_m, rocked
from tests.frames.machines import ACROSS, ALONG, POINTS_M, UP, body, bushing, exciter, two_bodies
from tests.reference import planar


def end_of(frames: Frames, count: int, interval_s: float, load: Load | None = None) -> Array:
    """Displacements of the carried points after ``count`` intervals."""
    start_m = frames.initial().position_m
    for index in range(count):
        motion = frames.advance(Interval(index, interval_s), load or Load.zero(len(start_m)))
    return np.asarray(motion.position_m - start_m)


def test_where_nothing_turns_it_does_what_two_mass_does() -> None:
    """Two counter-rotating unbalances and no weight: all forces and stretches lie along x."""
    pair = tuple(
        exciter(95.0, 0.1, axis=axis, start=ALONG, mass_moment_kg_m=1.75) for axis in (ACROSS, -ACROSS)
    )
    plan = replace(two_bodies(pair), gravity_m_per_s2=np.zeros(3))
    moved_m = [end_of(solver.build(plan), 400, 1e-3) for solver in (planar, two_mass)]
    assert np.abs(moved_m[1]).max() > 1e-3
    assert moved_m[0] == pytest.approx(moved_m[1], abs=1e-13)


def off_centre(step_s: float) -> FramesPlan:
    """A machine that translates and rocks in the plane, with oblique bushings."""
    turning = exciter(95.0, 0.1, position_m=np.array([0.05, 0.0, 0.226]))
    plan = two_bodies((turning,), interval_s=step_s, step_s=step_s)
    tilted = np.array([[0.8, 0, 0.6], [0, 1, 0], [-0.6, 0, 0.8]])
    bushings = (*plan.bushings[:4], *(replace(b, axes=tilted) for b in plan.bushings[4:]))
    return replace(plan, bushings=bushings)


@pytest.mark.solver
def test_exudyn_comes_near_it_in_second_order_where_motion_is_planar() -> None:
    """The same equations, so halving exudyn's step quarters the difference.  Its size is that of
    the trapezoidal rule: phase  w t (w h)^2 / 12 = 5e-3 at 95 rad/s, 0.3 s, 0.5 ms, of 4 mm."""
    differences = []
    for step_s in (1e-3, 5e-4):
        plan = off_centre(step_s)
        moved_m = [end_of(solver.build(plan), round(0.3 / step_s), step_s) for solver in (planar, exudyn)]
        assert np.ptp(moved_m[0][:2, 2]) > 2e-4  # it rocks
        differences.append(np.abs(moved_m[0] - moved_m[1]).max())
    assert differences[0] / differences[1] == pytest.approx(4.0, rel=0.05)
    assert differences[1] < 2e-5


@pytest.mark.parametrize("parts", [1, 4])
def test_the_step_makes_no_difference(parts: int) -> None:
    """1e-11 m: the exciter's angular acceleration has a kink where the run-up ends."""
    expected_m = end_of(planar.build(off_centre(0.0005)), 600, 0.0005)
    plan = replace(off_centre(0.002), step_s=0.002 / parts)
    assert end_of(planar.build(plan), 150, 0.002) == pytest.approx(expected_m, abs=1e-11)


@pytest.mark.parametrize("start_rad", [0.05, 2.5])
def test_a_compound_pendulum_swings_as_the_elliptic_integral_says(start_rad: float) -> None:
    """T = 4 sqrt(I / (m g d)) K(sin^2(start / 2)), for any angle (Landau and Lifshitz, Mechanics,
    1976, par. 11); at a quarter of it the body hangs straight down.  The pin gives way by m g /
    k = 1e-5 m at rest, by up to five times that in the swing, and rings on: 1e-4 m."""
    mass_kg, arm_m, inertia_kg_m2 = 10.0, 0.4, 1.2
    center_m = arm_m * np.array([np.sin(start_rad), 0.0, -np.cos(start_rad)])
    pin = BushingPlan("pin", ("ground", "body"), np.zeros(3), np.eye(3), np.full(3, 1e7), np.zeros(3))
    period_s = 4 * np.sqrt((inertia_kg_m2 + mass_kg * arm_m**2) / (mass_kg * 9.81 * arm_m))
    period_s *= ellipk(np.sin(start_rad / 2) ** 2)
    interval_s = period_s / 4 / 50
    plan = FramesPlan(
        bodies=(BodyPlan("body", mass_kg, np.diag([1.0, inertia_kg_m2, 1.0]), center_m),),
        bushings=(pin,),
        exciters=(),
        drives=(),
        gravity_m_per_s2=-9.81 * UP,
        points_m=center_m[None],
        carrier=("body",),
        reaction_N=np.zeros((1, 3)),
        drawn_at_rest=False,
        step_s=0.0,
        sync_interval_s=interval_s,
    )
    frames = planar.build(plan)
    hanging_m = center_m + end_of(frames, 50, interval_s)[0]
    assert hanging_m == pytest.approx([0.0, 0.0, -arm_m], abs=1e-4)
    for index in range(50, 100):
        motion = frames.advance(Interval(index, interval_s), Load.zero(1))
    turned_over_m = center_m * [-1.0, 1.0, 1.0]
    assert motion.position_m[0] == pytest.approx(turned_over_m, abs=1e-4)


def test_rocking_on_springs_at_sqrt_of_k_x2_over_I() -> None:
    """A small moment, held: angle = M / (sum k x^2) (1 - cos(w t)); 1e-7 for arms that turn by
    3e-4 rad."""
    center_m = np.array([0.2, 0.1, 0.3])
    places_m = [center_m + np.array([x, y, 0.0]) for x in (-0.9, 0.9) for y in (-0.4, 0.4)]
    plan = replace(
        two_bodies(),
        bodies=(body("driving", center_m=center_m),),
        bushings=tuple(bushing(("ground", "driving"), p, (225e3,) * 3, 0.0) for p in places_m),
        points_m=center_m + np.array([[1.0, 0, 0], [-1.0, 0, 0]]),
        carrier=("driving",) * 2,
        reaction_N=np.zeros((2, 3)),
    )
    stiffness, inertia = 4 * 225e3 * 0.9**2, 0.67 * 764.0
    period_s = 2 * np.pi / np.sqrt(stiffness / inertia)
    load = Load(50.0 * np.array([UP, -UP]))
    for fraction, share in ((0.25, 1.0), (0.5, 2.0), (1.25, 1.0)):
        moved_m = end_of(planar.build(plan), 40, fraction * period_s / 40, load)
        expected_m = share * 100.0 / stiffness
        assert moved_m[:, 2] == pytest.approx([expected_m, -expected_m], rel=1e-6)


@pytest.mark.parametrize(
    ("bodies", "stiffness_N_per_m"),
    [
        (("base", "mass"), np.array([2e5, 5e4, 1e5])),  # the axes turn with the base
        (("mass", "base"), np.full(3, 1e5)),
    ],
)
def test_a_rocking_body_carries_a_free_one_along(bodies: tuple[str, str], stiffness_N_per_m: Array) -> None:
    """The body rocks by 0.4 rad, against an independent Runge-Kutta solution (1e-9 m)."""
    plan = rocked(1e-3, np.array([0.0, 0.4, 0.0]), bodies, stiffness_N_per_m)
    found_m = plan.points_m[0] + end_of(planar.build(plan), 200, 1e-3)[0]
    assert found_m == pytest.approx(carried_along_m(plan, 0.2), abs=1e-8)


def test_with_every_body_driven_it_does_what_prescribed_does() -> None:
    """Massless bodies, as prescribed has them, under reactions of 50 kN."""
    weightless = tuple(
        replace(b, mass_kg=0.0, inertia_kg_m2=np.zeros((3, 3))) for b in both_driven(0.0).bodies
    )
    plan = replace(both_driven(0.0), bodies=weightless, bushings=())
    large = tuple(replace(d, rotation_rad=2.0 * ACROSS) for d in plan.drives)
    plan = replace(plan, drives=large)
    compared(planar.build(plan), prescribed.build(plan), 100 * loads(300), plan.sync_interval_s)


def test_what_pushes_across_moves_nothing() -> None:
    across = Load(np.full((4, 3), 1e3) * ACROSS)
    assert end_of(planar.build(two_bodies()), 100, 1e-3, across) == pytest.approx(0.0, abs=1e-13)


@pytest.mark.parametrize(
    ("broken", "named"),
    [
        (replace(one_driven(0.0), drives=(drive("ground"),)), "ground"),
        (replace(one_driven(0.0), exciters=(exciter(),)), r"\['driving'\]"),
        (driven(replace(drive(), rotation_rad=0.1 * UP)), "'driven'.*plane"),
        (driven(replace(drive(), amplitude_m=0.1 * ACROSS)), "'driven'.*plane"),
        (replace(two_bodies(), bushings=two_bodies().bushings[:4]), "hold"),
    ],
)
def test_plans_that_make_no_sense_are_refused(broken: FramesPlan, named: str) -> None:
    with pytest.raises(ValueError, match=named):
        planar.build(broken)


def test_rounds_that_do_not_end_stop_the_run_with_its_time() -> None:
    """Forces of 1e10 N, whose moment changes with the angle, and nothing to hold the body."""
    plan = replace(two_bodies(drawn_at_rest=False), bodies=(body("driving"),), bushings=())
    plan = replace(plan, carrier=("driving",) * 4, points_m=POINTS_M)
    frames = planar.build(plan)
    with pytest.raises(SolverFailed, match=r"planar.*\b0\.\d+\b.*frames\.step_s"):
        end_of(frames, 100, 1e-3, Load(1e10 * np.array([UP, -UP, 0 * UP, 0 * UP])))
