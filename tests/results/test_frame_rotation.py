"""Rotation vectors of frames, from their poses."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from orchestrator.output.records.series import rotations_rad
from orchestrator.ports import Array, Pose

vectors = st.lists(st.floats(-1.7, 1.7), min_size=3, max_size=3).map(np.array)


@given(vectors, vectors)
def test_they_are_those_of_the_bodies(one_rad: Array, other_rad: Array) -> None:
    """|turn| < pi, where the rotation vector is unique."""
    turn_rad = np.array([one_rad, other_rad])
    pose = Pose(np.ones((2, 3)), Rotation.from_rotvec(turn_rad).as_matrix(), *np.zeros((2, 2, 3)))
    assert rotations_rad(pose) == pytest.approx(turn_rad, abs=1e-12)


def test_a_machine_without_frames_has_none() -> None:
    assert rotations_rad(Pose.nothing()).shape == (0, 3)
