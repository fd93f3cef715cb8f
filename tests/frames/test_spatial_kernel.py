"""The compiled poses, forces and books of bodies in space against the same in Python."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from adapters.frames.exudyn.compiled import CompiledBodies
from orchestrator.ports import Array, Load, linear_frames
from orchestrator.ports.plans import DrivePlan, FramesPlan
from tests.frames.machines import ACROSS, ALONG, UP, bushing, exciter, two_bodies
from tests.frames.spatial_reference import SpatialReference

RANDOM = np.random.default_rng(5)
STEP_S, LENGTH_S = 1e-3, 3e-3


def machine(driven: bool) -> FramesPlan:
    """Two bodies with bushings of oblique axes on the ground and between each other, two exciters that run
    up at different times, and points on both bodies and on the ground."""
    axes, _ = np.linalg.qr(RANDOM.normal(size=(3, 3)))
    plan = two_bodies((exciter(run_up_s=0.1), exciter(90.0, 0.02, start_s=0.01, position_m=0.3 * ALONG)))
    oblique = [
        bushing(bodies, RANDOM.normal(size=3), (1e5, 2e5, 3e5), axes=axes)
        for bodies in (("ground", "driven"), ("driven", "driving"), ("driving", "ground"))
    ]
    bodies = [replace(body, center_of_mass_m=RANDOM.normal(size=3)) for body in plan.bodies]
    still = np.zeros(3)
    drive = DrivePlan("driven", still, 50.0, 0.01 * UP, still, 0.01 * ACROSS, still, 0.0)
    return replace(
        plan,
        bodies=tuple(bodies),
        bushings=(*plan.bushings, *oblique),
        drives=(drive,) if driven else (),
        points_m=RANDOM.normal(size=(5, 3)),
        carrier=("driving", "driven", "ground", "driving", "driven"),
        reaction_N=np.zeros((5, 3)),
    )


def close(value: Array | float, expected: Array | float) -> bool:
    scale = max(1e-9, float(np.abs(expected).max()))
    return bool(np.abs(np.subtract(value, expected)).max() < 1e-12 * scale)


@pytest.mark.parametrize("driven", [False, True])
def test_compiled_bodies_do_what_the_reference_does(driven: bool) -> None:
    plan = machine(driven)
    sag_m = 1e-3 * RANDOM.normal(size=(len(plan.bushings), 3))
    reference = SpatialReference(plan, sag_m)
    carrier = linear_frames.numbers(plan, plan.carrier)
    bodies = CompiledBodies(plan, carrier, reference.drawn_m, sag_m)
    coordinates, rates = 0.1 * RANDOM.normal(size=(2, 2, 6))
    bodies.kernel.start(coordinates=coordinates.ravel(), rates=rates.ravel())
    before = couples = reference.at(coordinates, rates, 0.0)
    wrench = np.zeros((2, 6))
    for step in range(1, 25):
        reaction = Load(RANDOM.normal(size=(5, 3)))
        change = bodies.kernel.wrench_of(force_N=reaction.force_N, length_s=LENGTH_S) - wrench
        wrench = reference.wrench_of(before, reaction, LENGTH_S)
        acceleration = RANDOM.normal(size=12)
        expected = acceleration.reshape(2, 6) + reference.acceleration_of(before, change)
        bodies.kernel.apply(wrench=wrench, acceleration=acceleration)
        assert close(acceleration.reshape(2, 6), expected)
        exciter_N, torque_N_m = bodies.kernel.coming_loads(end_s=step * STEP_S)
        coordinates, rates = 0.1 * RANDOM.normal(size=(2, 2, 6))
        element_N = 1e3 * RANDOM.normal(size=sag_m.shape)
        after = reference.at(coordinates, rates, step * STEP_S, element_N)
        assert close(exciter_N, after.exciter_N)
        assert close(torque_N_m, wrench[:, 3:] + 2 * before.couple_N_m - couples.couple_N_m)
        bodies.kernel.reach(coordinates=coordinates.ravel(), rates=rates.ravel())
        bodies.memory["element_N"][:] = element_N
        books = bodies.kernel.book(step_s=STEP_S)
        for name, value in reference.step_books(before, after, STEP_S).items():
            assert close(books[name], value), name  # type: ignore[literal-required]
        for name, array in {**vars(after), **vars(after.poses)}.items():
            assert name == "poses" or close(bodies.memory[name], array), name
        before, couples = after, before


def test_the_reaction_is_booked_where_it_goes() -> None:
    plan = machine(driven=True)
    reference = SpatialReference(plan, np.zeros((len(plan.bushings), 3)))
    carrier = linear_frames.numbers(plan, plan.carrier)
    bodies = CompiledBodies(plan, carrier, reference.drawn_m, np.zeros((len(plan.bushings), 3)))
    bodies.kernel.start(coordinates=0.1 * RANDOM.normal(size=12), rates=RANDOM.normal(size=12))
    motion, (position_m, velocity_m_per_s) = bodies.carried(), reference.carried.motion(bodies.poses)
    assert close(motion.position_m, position_m)
    assert close(motion.velocity_m_per_s, velocity_m_per_s)
    before_m, force_N = RANDOM.normal(size=(2, 5, 3))
    books = bodies.kernel.reaction(force_N=force_N, before_m=before_m, after_m=position_m, length_s=LENGTH_S)
    for name, value in reference.reaction_books(Load(force_N), position_m - before_m, LENGTH_S).items():
        assert close(books[name], value), name  # type: ignore[literal-required]


def test_arrays_go_to_the_kernel_by_name_and_size() -> None:
    plan = machine(driven=False)
    sag_m = np.zeros((len(plan.bushings), 3))
    carrier = linear_frames.numbers(plan, plan.carrier)
    bodies = CompiledBodies(plan, carrier, np.zeros((2, 3)), sag_m)
    with pytest.raises(ValueError, match=r"^rates:.*\b12\b.*\b6$"):
        bodies.kernel.start(coordinates=np.zeros(12), rates=np.zeros(6))
