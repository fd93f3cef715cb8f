"""The deformation and the force of every bushing, from the motion of the frames that it joins.

A frame is rigid: each of its points is its centre of mass plus a fixed combination of the arms of
1 m that start there (``coupling/surface_parts.py``).  The same combination gives the point's velocity.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from orchestrator.ports import Array, Indices, Motion
from orchestrator.ports.plans import BushingPlan

ARMS = 3
GROUND_M = np.vstack([np.zeros(3), np.eye(3)])  # its centre and the ends of its arms


def frame_points(centres: Mapping[str, int]) -> tuple[dict[str, int], Indices]:
    """Return the carried points that show how frames move, each one's centre of mass with its arms, and the
    place of each centre among them; ``centres`` are their numbers among all carried points."""
    points = np.array([np.arange(1 + ARMS) + centre for centre in centres.values()], dtype=np.int64)
    return {name: (1 + ARMS) * number for number, name in enumerate(centres)}, points.ravel()


@dataclass(frozen=True)
class BushingForces:
    """All n bushings of a machine, with both ends among points that frames carry.

    ``first``, ``second`` (n, 4): numbers of a frame's centre of mass and arms, -1 for the ground; ``arm_m``
    (2, n, 3): places of the ends relative to those centres (for the ground: to the origin).
    """

    names: tuple[str, ...]
    first: Indices
    second: Indices
    arm_m: Array
    axes: Array
    stiffness_N_per_m: Array
    damping_N_s_per_m: Array

    @staticmethod
    def of(bushings: Sequence[BushingPlan], centres: Mapping[str, int], position_m: Array) -> BushingForces:
        """Return the bushings of a plan.

        ``centres`` has the number of each frame's centre of mass among carried points, which its arms
        follow; ``position_m`` has the places of these points at t = 0.
        """
        bushings = [bushing.beside_elements() for bushing in bushings]
        ends = np.array(
            [
                [np.arange(1 + ARMS) + centres[body] if body in centres else [-1] * 4 for body in b.bodies]
                for b in bushings
            ],
            dtype=np.int64,
        ).reshape(-1, 2, 1 + ARMS)
        place_m = np.array([b.position_m for b in bushings]).reshape(-1, 3)
        origin_m = np.vstack([position_m, np.zeros(3)])[ends[:, :, 0]]
        return BushingForces(
            names=tuple(b.name for b in bushings),
            first=ends[:, 0],
            second=ends[:, 1],
            arm_m=place_m - origin_m.transpose(1, 0, 2),
            axes=np.array([b.axes for b in bushings]).reshape(-1, 3, 3),
            stiffness_N_per_m=np.array([b.stiffness_N_per_m for b in bushings]).reshape(-1, 3),
            damping_N_s_per_m=np.array([b.damping_N_s_per_m for b in bushings]).reshape(-1, 3),
        )

    def at(self, carried: Motion, element_N: Array | None = None) -> tuple[Array, Array]:
        """Return deformation in m and force in N of every bushing, (n, 3) each, along its own axes.

        All arrays may have a leading axis of moments, which are then computed together, to the same bits.
        The axes turn with the first body.  The deformation is the place of the second end against the first,
        and the force holds the second end there.  Both count from t = 0: the preload that carries weight is
        not included.  ``element_N`` (n, 3) are the forces of friction and Maxwell elements, which the frames
        know.
        """
        place_m, velocity_m_per_s, turn = self._ends(carried)
        axes = self.axes @ np.swapaxes(turn[..., 0, :, :, :], -1, -2)
        deformation_m = _times(axes, place_m[..., 1, :, :] - place_m[..., 0, :, :])
        rate_m_per_s = _times(axes, velocity_m_per_s[..., 1, :, :] - velocity_m_per_s[..., 0, :, :])
        force_N = self.stiffness_N_per_m * deformation_m + self.damping_N_s_per_m * rate_m_per_s
        return deformation_m, force_N if element_N is None else force_N + element_N

    def _ends(self, carried: Motion) -> tuple[Array, Array, Array]:
        """Return places and velocities (..., 2, n, 3) of both ends, and rotations (..., 2, n, 3, 3) of their
        bodies."""
        points = np.array((self.first, self.second))
        still = points[..., :1, None] < 0
        place_m = np.where(still, GROUND_M, carried.position_m[..., points, :])
        velocity_m_per_s = np.where(still, 0.0, carried.velocity_m_per_s[..., points, :])
        turn, spin = (np.swapaxes(x[..., 1:, :] - x[..., :1, :], -1, -2) for x in (place_m, velocity_m_per_s))
        return (
            place_m[..., 0, :] + _times(turn, self.arm_m),
            velocity_m_per_s[..., 0, :] + _times(spin, self.arm_m),
            turn,
        )


def _times(matrices: Array, vectors: Array) -> Array:
    """Return matrices (..., 3, 3) times vectors (..., 3); no product depends on how many there are."""
    return (matrices @ vectors[..., None])[..., 0]
