"""Rotation and angular velocity of frames, read from the points that they carry."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from orchestrator.output.records.series import rotations
from orchestrator.ports import Array, Motion

vectors = st.lists(st.floats(-1.7, 1.7), min_size=3, max_size=3).map(np.array)


def carried(turn_rad: Array, spin_rad_per_s: Array) -> Motion:
    """A probe that is not looked at, then a frame's centre and arms, away from the origin."""
    arms = Rotation.from_rotvec(turn_rad).apply(np.vstack([np.zeros(3), np.eye(3)]))
    position_m = np.vstack([[7.0, 8.0, 9.0], np.array([0.5, -2.0, 1.0]) + arms])
    velocity_m_per_s = np.array([0.3, 0.1, -4.0]) + np.cross(spin_rad_per_s, arms)
    return Motion(position_m, np.vstack([[1.0, 1.0, 1.0], velocity_m_per_s]))


@given(vectors, vectors)
def test_they_are_those_of_the_body(turn_rad: Array, spin_rad_per_s: Array) -> None:
    """|turn| < pi, where the rotation vector is unique."""
    rotation_rad, found_rad_per_s = rotations(carried(turn_rad, spin_rad_per_s), np.array([1]))
    assert rotation_rad[0] == pytest.approx(turn_rad, abs=1e-12)
    assert found_rad_per_s[0] == pytest.approx(spin_rad_per_s, abs=1e-13)


def test_a_machine_without_frames_has_none() -> None:
    nothing = np.empty(0, dtype=np.int64)
    assert [len(value) for value in rotations(carried(np.zeros(3), np.zeros(3)), nothing)] == [0, 0]
