"""The poses and motions of rigid bodies, and of points that they carry."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchestrator.ports import Array, Indices
from orchestrator.ports.interface_records import cross, turn


@dataclass(frozen=True)
class Poses:
    """The bodies' centres of mass and rotations since t = 0, in the world.

    The ground is the last row, so that it has the body number -1.  ``center_m``, ``velocity_m_per_s`` and
    ``spin_rad_per_s`` have the shape (bodies + 1, 3), ``rotation`` has (bodies + 1, 3, 3).  ``spin_per_rate``
    (bodies, 3, 3) maps the rates of the rotation angles to angular velocities.
    """

    center_m: Array
    rotation: Array
    velocity_m_per_s: Array
    spin_rad_per_s: Array
    spin_per_rate: Array

    def angular_acceleration_rad_per_s2(self, rate_rad_per_s: Array, growth_rad_per_s2: Array) -> Array:
        """Return the angular accelerations (bodies, 3) for first and second derivatives of the rotation
        angles, (bodies, 3) each: each axis is turned by the angles before it."""
        first, second, third = np.moveaxis(self.spin_per_rate, -1, 0)
        spin = rate_rad_per_s[:, :1] * first
        turned = rate_rad_per_s[:, 1:2] * cross(spin, second)
        spin = spin + rate_rad_per_s[:, 1:2] * second
        turned += rate_rad_per_s[:, 2:] * cross(spin, third)
        return turn(self.spin_per_rate, growth_rad_per_s2) + turned


def turning(angles_rad: Array) -> tuple[Array, Array]:
    """Return the rotation Rx Ry Rz (bodies, 3, 3), and the axes of the three rates as columns."""
    (sx, sy, sz), (cx, cy, cz) = np.sin(angles_rad.T), np.cos(angles_rad.T)
    one, zero = np.ones_like(sx), np.zeros_like(sx)
    rotation = [
        [cy * cz, -cy * sz, sy],
        [cx * sz + sx * sy * cz, cx * cz - sx * sy * sz, -sx * cy],
        [sx * sz - cx * sy * cz, sx * cz + cx * sy * sz, cx * cy],
    ]
    axes = [[one, zero, sy], [zero, cx, -sx * cy], [zero, sx, cx * cy]]
    return np.array(rotation).transpose(2, 0, 1), np.array(axes).transpose(2, 0, 1)


@dataclass(frozen=True)
class Attached:
    """Points fixed to bodies.

    ``body`` (n,) is the body number, -1 for the ground, and ``arm_m`` (n, 3) the arm from the centre of mass
    in body axes (for the ground: the place itself).
    """

    body: Indices
    arm_m: Array

    @staticmethod
    def at(position_m: Array, body: Indices, drawn_m: Array) -> Attached:
        """Return points that are attached to bodies at ``position_m`` (n, 3) in the drawn position."""
        return Attached(body, position_m - np.vstack([drawn_m, np.zeros(3)])[body])

    def motion(self, poses: Poses) -> tuple[Array, Array]:
        """Return positions and velocities of the points, (n, 3) each, for these poses."""
        arm_m = turn(poses.rotation[self.body], self.arm_m)
        position_m = poses.center_m[self.body] + arm_m
        velocity_m_per_s = poses.velocity_m_per_s[self.body] + cross(poses.spin_rad_per_s[self.body], arm_m)
        return position_m, velocity_m_per_s
