"""Bushings' deformations from the poses of the frames."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from orchestrator.coupling.bushing_forces import BushingForces
from orchestrator.output.records.series import rotations_rad
from orchestrator.ports import Array, Pose
from orchestrator.ports.plans import BodyPlan, BushingPlan

CENTRE_M = np.array([[1.0, 0.2, -0.3], [0.8, 0.3, 0.1]])
PLACE_M = np.array([0.4, -0.1, 0.2])
AXES = Rotation.from_euler("xyz", [10, 20, 30], degrees=True).as_matrix()
STIFFNESS, DAMPING = np.array([2e5, 5e6, 3e5]), np.array([10.0, 40.0, 20.0])
BODIES = [BodyPlan(n, 1.0, np.eye(3), c) for n, c in zip(("driving", "driven"), CENTRE_M, strict=True)]


def forces(*bodies: str) -> BushingForces:
    bushing = BushingPlan("b", (bodies[0], bodies[1]), PLACE_M, AXES, STIFFNESS, DAMPING)
    return BushingForces.of([bushing], BODIES)


def moved(turn: Rotation, shift_m: Array, spin_rad_per_s: Array, speed_m_per_s: Array) -> Pose:
    """Return the pose of both frames, moved as one rigid body about the origin."""
    position_m, spin = turn.apply(CENTRE_M) + shift_m, np.tile(spin_rad_per_s, (2, 1))
    velocity_m_per_s = np.cross(spin, position_m - shift_m) + speed_m_per_s
    return Pose(position_m, np.tile(turn.as_matrix(), (2, 1, 1)), velocity_m_per_s, spin)


TURN = Rotation.from_rotvec([0.1, -0.2, 0.05])
SHIFT_M, SPIN, SPEED = np.array([[0.01, 0.02, -0.03], [1.0, -2.0, 0.5], [0.3, 0.1, -0.2]])


def test_a_machine_that_moves_as_one_body_strains_no_bushing() -> None:
    deformation_m, force_N = forces("driving", "driven").at(moved(TURN, SHIFT_M, SPIN, SPEED))
    assert deformation_m == pytest.approx(np.zeros((1, 3)), abs=1e-14)
    assert force_N == pytest.approx(np.zeros((1, 3)), abs=1e-6)  # 5e6 N/m times rounding


def test_axes_turn_with_the_first_body() -> None:
    """The second body has moved further, by a vector that turns with the first."""
    extra_m, rate_m_per_s = np.array([1e-3, -2e-3, 3e-3]), np.array([0.1, 0.2, -0.3])
    together = moved(TURN, SHIFT_M, np.zeros(3), SPEED)
    position_m, velocity_m_per_s = together.position_m.copy(), together.velocity_m_per_s.copy()
    position_m[1] += TURN.apply(extra_m)
    velocity_m_per_s[1] += TURN.apply(rate_m_per_s)
    further = replace(together, position_m=position_m, velocity_m_per_s=velocity_m_per_s)
    deformation_m, force_N = forces("driving", "driven").at(further)
    assert deformation_m[0] == pytest.approx(AXES @ extra_m, abs=1e-14)
    assert force_N[0] == pytest.approx(STIFFNESS * (AXES @ extra_m) + DAMPING * (AXES @ rate_m_per_s))


@pytest.mark.parametrize(("bodies", "sign"), [(("ground", "driven"), 1), (("driven", "ground"), -1)])
def test_the_ground_stands_still(bodies: tuple[str, str], sign: int) -> None:
    """A frame that only shifts strains its bushing by just that."""
    motion = moved(Rotation.identity(), SHIFT_M, np.zeros(3), SPEED)
    deformation_m, force_N = forces(*bodies).at(motion)
    assert deformation_m[0] == pytest.approx(sign * AXES @ SHIFT_M, abs=1e-14)
    assert force_N[0] == pytest.approx(sign * (STIFFNESS * (AXES @ SHIFT_M) + DAMPING * (AXES @ SPEED)))


def test_a_point_of_a_turning_frame_moves_with_its_lever_arm() -> None:
    """The other side of the bushing is a ground that does not turn: the bushing's place is turned and
    moved."""
    deformation_m, _ = forces("ground", "driving").at(moved(TURN, SHIFT_M, SPIN, SPEED))
    expected_m = TURN.apply(PLACE_M) + SHIFT_M - PLACE_M
    assert deformation_m[0] == pytest.approx(AXES @ expected_m, abs=1e-14)


def test_several_moments_at_once_change_no_bit() -> None:
    """The series are computed in blocks, and a resumed run has other blocks than one that never stopped."""
    turns = [Rotation.from_rotvec(0.01 * (number + 1) * np.array([1.0, -2.0, 0.5])) for number in range(7)]
    every = [moved(turn, SHIFT_M, SPIN, SPEED) for turn in turns]
    together = Pose(*(np.stack([getattr(pose, f.name) for pose in every]) for f in fields(Pose)))
    bushing, element_N = forces("driving", "driven"), np.arange(21.0).reshape(7, 1, 3)
    for number, pose in enumerate(every):
        for stacked, alone in (
            (bushing.at(together, element_N), bushing.at(pose, element_N[number])),
            ([rotations_rad(together)], [rotations_rad(pose)]),
        ):
            for values, single in zip(stacked, alone, strict=True):
                assert np.array_equal(values[number], single)
