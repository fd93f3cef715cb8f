"""How frames are turned, read from the points that they carry."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from orchestrator.ports import Array, Indices, Motion

ARMS = np.arange(1, 4)


def rotations(carried: Motion, centres: Indices) -> tuple[Array, Array]:
    """Rotation vectors since t = 0 in rad and angular velocities in rad/s, (frames, 3) each, in
    the world.

    ``centres`` (frames,): numbers of the centres of mass; the three points after each are the ends
    of arms that were 1 m long and lay along the world's axes at t = 0 (``pieces.frame_pieces``).
    """
    if not len(centres):  # which Rotation does not take
        return np.empty((0, 3)), np.empty((0, 3))
    ends = centres[:, None] + ARMS
    arms_m, rates_m_per_s = (
        value[ends] - value[centres][:, None] for value in (carried.position_m, carried.velocity_m_per_s)
    )
    rotation_rad = Rotation.from_matrix(arms_m.transpose(0, 2, 1)).as_rotvec()
    # for orthonormal arms a:  sum of a x (spin x a) = 2 spin
    return rotation_rad, np.cross(arms_m, rates_m_per_s).sum(axis=1) / 2
