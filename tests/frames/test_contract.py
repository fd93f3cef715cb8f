"""The contract of the frames port, on every adapter with its real solver."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from orchestrator.case import solvers
from orchestrator.ports import BrokenRecord, Load, linear_frames
from orchestrator.ports.clock import Interval
from orchestrator.ports.frames import find_driven_points
from orchestrator.ports.state import as_arrays
from tests.frames.contract import CASES, INTERVAL_S, Case, accounts, defect_J, loads
from tests.frames.machines import POINTS_M, body, two_bodies
from tests.saved_states import differences

marked = [
    pytest.param(case, id=name, marks=[pytest.mark.solver] if case.solver == "exudyn" else [])
    for name, case in CASES.items()
]
every_adapter = pytest.mark.parametrize("case", marked)


@every_adapter
def test_points_start_where_they_are_mounted_and_at_rest(case: Case) -> None:
    motion = case.open(case.moving(0.0)).initial()
    assert motion.position_m == pytest.approx(POINTS_M, abs=1e-15)
    assert not motion.velocity_m_per_s.any()


@pytest.mark.smoke
@every_adapter
def test_at_rest_nothing_moves(case: Case) -> None:
    frames = case.open(case.still())
    for index in range(100):
        motion = frames.advance(Interval(index, INTERVAL_S), Load.zero(4))
    assert motion.position_m == pytest.approx(POINTS_M, abs=1e-13)
    assert motion.velocity_m_per_s == pytest.approx(np.zeros((4, 3)), abs=1e-11)


@every_adapter
def test_initial_reaction_is_held_by_the_preload(case: Case) -> None:
    reaction = loads(1)[0]
    frames = case.open(replace(case.still(), reaction_N=reaction))
    for index in range(100):
        motion = frames.advance(Interval(index, INTERVAL_S), Load(reaction))
    assert motion.position_m == pytest.approx(POINTS_M, abs=1e-13)


@pytest.mark.parametrize("solver", ["two-mass", "planar", pytest.param("exudyn", marks=pytest.mark.solver)])
def test_a_body_without_bushings_floats_in_zero_gravity(solver: str) -> None:
    """A taut panel pulls it together with 1000 N, out of balance by what its resting shape is found
    to.  It stays where it is drawn but for  F t^2 / (2 m) = 3e-10 m  of that; a pull that nothing
    holds is refused with what helps."""
    build = solvers.adapter("frames", solver).build
    floating = replace(
        two_bodies(),
        bodies=(body("driving"),),
        bushings=(),
        carrier=("driving",) * 4,
        gravity_m_per_s2=np.zeros(3),
    )
    pull_N = np.outer([1.0, -1.0 - 1e-7, 0.0, 0.0], [1000.0, 0.0, 0.0])
    frames = build(replace(floating, reaction_N=pull_N, points_m=POINTS_M * [1.0, 0.0, 0.0]))
    for index in range(100):
        motion = frames.advance(Interval(index, INTERVAL_S), Load(pull_N))
    assert motion.position_m == pytest.approx(POINTS_M * [1.0, 0.0, 0.0], abs=1e-9)
    pull_N[1] = 0.0
    with pytest.raises(ValueError, match=r"cannot hold 1e\+03 N .* screen.drawn_at_rest = false"):
        build(replace(floating, reaction_N=pull_N))


@pytest.mark.smoke
@every_adapter
def test_momentum_balances_in_every_interval(case: Case) -> None:
    """The balance holds to rounding: 1e-12 of the largest impulse that goes through."""
    reactions = loads(400)
    books = accounts(case.open(case.moving(0.0)), reactions)
    size = max(np.abs(book.outside_impulse_N_s).max() for book in books)
    for (before, after), force_N in zip(pairwise(books), reactions, strict=True):
        change = after.momentum_kg_m_per_s - before.momentum_kg_m_per_s
        outside = after.outside_impulse_N_s - before.outside_impulse_N_s
        received = INTERVAL_S * force_N.sum(axis=0)
        assert change == pytest.approx(outside + received, abs=1e-12 * size)


@every_adapter
def test_energy_defect_is_small_and_falls_with_interval_and_step(case: Case) -> None:
    """exudyn: 1e-7 of the work in intervals of 2.5e-4 s, and second order; others: rounding."""
    work, defects = [], []
    for split in (2, 8):
        step_s = INTERVAL_S / split
        reactions = loads(400).repeat(split, axis=0)
        books = accounts(case.open(case.moving(step_s)), reactions, step_s)
        end = books[-1]
        work.append(sum(abs(v) for book in (end.supplied_J, end.received_J) for v in book.values()))
        defects.append(abs(defect_J(books[0], end)))
    assert defects[0] < 1e-7 * work[0]
    assert defects[1] < max(defects[0] / 8, 1e-12 * work[1])


@every_adapter
def test_a_load_on_the_ground_moves_nothing(case: Case) -> None:
    frames = case.open(replace(case.still(), carrier=("ground",) * 4))
    motion = frames.advance(Interval(0, INTERVAL_S), Load(np.full((4, 3), 100.0)))
    assert motion.position_m == pytest.approx(POINTS_M, abs=1e-15)
    outside = frames.account().outside_impulse_N_s
    start = case.open(replace(case.still(), carrier=("ground",) * 4))
    start.advance(Interval(0, INTERVAL_S), Load.zero(4))
    given = outside - start.account().outside_impulse_N_s
    assert given == pytest.approx(-INTERVAL_S * np.full(3, 400.0), abs=1e-9)


@every_adapter
def test_velocity_is_the_rate_of_position(case: Case) -> None:
    """x1 - x0 = H (v0 + v1) / 2 but for H^3 / 12 times the rate of the acceleration, which second
    differences of the velocity show: 5e-7 m at most, of 3e-4 m; a tenth more for what they miss."""
    frames = case.open(case.moving(0.0))
    run = [frames.initial()]
    for index, force_N in enumerate(loads(200)):
        run.append(frames.advance(Interval(index, INTERVAL_S), Load(force_N)))
    velocity_m_per_s = np.array([motion.velocity_m_per_s for motion in run])
    moved_m = np.diff([motion.position_m for motion in run], axis=0)
    bent_m_per_s = np.abs(np.diff(velocity_m_per_s, n=2, axis=0)).max()
    assert INTERVAL_S * bent_m_per_s / 12 < 1e-6
    mean_m_per_s = (velocity_m_per_s[1:] + velocity_m_per_s[:-1]) / 2
    assert moved_m == pytest.approx(INTERVAL_S * mean_m_per_s, abs=1.1 * INTERVAL_S * bent_m_per_s / 12)


@every_adapter
def test_carried_points_move_as_the_pose_says(case: Case) -> None:
    """The points agree to rounding, with places of a metre and speeds of a metre per second. A rotation
    keeps lengths."""
    plan = case.moving(0.0)
    frames, carrier = case.open(plan), linear_frames.numbers(plan, plan.carrier)
    drawn_m = np.array([body.center_of_mass_m for body in plan.bodies])
    assert np.array_equal(frames.pose().position_m, drawn_m)
    for index, force_N in enumerate(loads(100)):
        motion = frames.advance(Interval(index, INTERVAL_S), Load(force_N))
        pose = frames.pose()
        position_m, velocity_m_per_s = pose.carried(carrier, plan.points_m - drawn_m[carrier])
        assert motion.position_m == pytest.approx(position_m, abs=1e-14)
        assert motion.velocity_m_per_s == pytest.approx(velocity_m_per_s, abs=1e-13)
    assert np.abs(pose.position_m - drawn_m).max() > 1e-4
    product = pose.rotation @ np.swapaxes(pose.rotation, 1, 2)
    assert product == pytest.approx(np.tile(np.eye(3), (2, 1, 1)), abs=1e-14)


@every_adapter
def test_a_restored_solver_goes_on_bit_for_bit(case: Case) -> None:
    """A whole run, and one that another solver, freshly opened, takes over."""
    whole, first, second = (case.open(case.moving(0.0)) for _ in range(3))
    reactions = loads(120)
    for frames in (whole, first):
        accounts(frames, reactions[:70])
    saved = first.save()
    second.restore(saved)
    assert differences(saved, second.save()) == []
    assert differences(as_arrays(whole.account()), as_arrays(second.account())) == []
    for index in range(70, 120):
        motions = [
            solver.advance(Interval(index, INTERVAL_S), Load(reactions[index])) for solver in (whole, second)
        ]
        assert differences(as_arrays(motions[0]), as_arrays(motions[1])) == []
    assert differences(whole.save(), second.save()) == []


@every_adapter
def test_a_wrong_number_of_points_is_refused(case: Case) -> None:
    frames = case.open(case.still())
    with pytest.raises(BrokenRecord, match=r"\b4\b.*\b3\b"):
        frames.advance(Interval(0, INTERVAL_S), Load.zero(3))


@every_adapter
def test_closing_twice_is_harmless(case: Case) -> None:
    frames = case.open(case.still())
    frames.close()
    frames.close()


@every_adapter
def test_what_drives_move_is_known_ahead(case: Case) -> None:
    """The motion of driven bodies and the ground is known to rounding; without a drive nothing is. Asking
    changes nothing."""
    plan = case.moving(0.0)
    plan = replace(plan, carrier=(*plan.carrier[:3], "ground"))
    frames, unasked = case.open(plan), case.open(plan)
    bodies = {drive.body for drive in plan.drives} | {"ground"}
    others_stand_still = case.solver == "prescribed"
    for index, force_N in enumerate(loads(80)):
        interval = Interval(index, INTERVAL_S)
        known = find_driven_points(frames, interval)
        motion = frames.advance(interval, Load(force_N))
        assert differences(as_arrays(motion), as_arrays(unasked.advance(interval, Load(force_N)))) == []
        if not plan.drives:
            assert known is None
            continue
        assert known is not None
        assert known.which.tolist() == [others_stand_still or c in bodies for c in plan.carrier]
        which = known.which
        assert known.motion.position_m[which] == pytest.approx(motion.position_m[which], abs=1e-13)
        assert known.motion.velocity_m_per_s[which] == pytest.approx(
            motion.velocity_m_per_s[which], abs=1e-11
        )
    assert differences(frames.save(), unasked.save()) == []


@every_adapter
def test_matrices_are_those_of_the_present_interval(case: Case) -> None:
    """A solver that has made intervals of one length goes on with others as one that is opened there:
    neither keeps matrices of a step that is no more."""
    used, force_N = case.open(case.moving(0.0)), loads(6)
    for index in range(3):
        used.advance(Interval(index, INTERVAL_S), Load(force_N[index]))
    opened = case.open(case.moving(0.0))
    opened.restore(used.save())
    for index, length_s in ((1, 3 * INTERVAL_S), (4, 1.5 * INTERVAL_S), (10, 0.75 * INTERVAL_S)):
        interval = Interval(index, length_s)
        actual, wanted = (solver.advance(interval, Load(force_N[3])) for solver in (used, opened))
        assert actual.position_m == pytest.approx(wanted.position_m, abs=1e-13)
        assert actual.velocity_m_per_s == pytest.approx(wanted.velocity_m_per_s, abs=1e-10)
        opened = case.open(case.moving(0.0))
        opened.restore(used.save())
