"""The deformation and the force of every bushing, from the poses of the frames that it joins."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from orchestrator.ports import Array, Indices, Pose
from orchestrator.ports.interface_records import turn
from orchestrator.ports.plans import BodyPlan, BushingPlan, CharacteristicPlan


@dataclass(frozen=True)
class BushingForces:
    """All n bushings of a machine.

    ``first``, ``second`` (n,): numbers of the bodies at their ends, -1 for the ground; ``arm_m`` (2, n, 3):
    places of the ends relative to these bodies' centres of mass at t = 0 (for the ground: to the origin);
    ``characteristics``: with the numbers of their bushings.
    """

    names: tuple[str, ...]
    first: Indices
    second: Indices
    arm_m: Array
    axes: Array
    stiffness_N_per_m: Array
    damping_N_s_per_m: Array
    characteristics: tuple[tuple[int, CharacteristicPlan], ...]

    @staticmethod
    def of(bushings: Sequence[BushingPlan], bodies: Sequence[BodyPlan]) -> BushingForces:
        """Return the bushings of a plan with these bodies."""
        bushings = [bushing.beside_elements() for bushing in bushings]
        number = {body.name: place for place, body in enumerate(bodies)} | {"ground": -1}
        ends = np.array([[number[name] for name in b.bodies] for b in bushings], dtype=np.int64).reshape(
            -1, 2
        )
        place_m = np.array([b.position_m for b in bushings]).reshape(-1, 3)
        centres_m = np.array([*(body.center_of_mass_m for body in bodies), np.zeros(3)])
        return BushingForces(
            names=tuple(b.name for b in bushings),
            first=ends[:, 0],
            second=ends[:, 1],
            arm_m=place_m - centres_m[ends.T],
            axes=np.array([b.axes for b in bushings]).reshape(-1, 3, 3),
            stiffness_N_per_m=np.array([b.stiffness_N_per_m for b in bushings]).reshape(-1, 3),
            damping_N_s_per_m=np.array([b.damping_N_s_per_m for b in bushings]).reshape(-1, 3),
            characteristics=tuple((n, law) for n, b in enumerate(bushings) for law in b.characteristics),
        )

    def at(self, pose: Pose, element_N: Array | None = None) -> tuple[Array, Array]:
        """Return deformation in m and force in N of every bushing, (n, 3) each, along its own axes.

        All arrays may have a leading axis of moments, which are then computed together, to the same bits.
        The axes turn with the first body.  The deformation is the place of the second end against the first,
        and the force holds the second end there.  Both count from t = 0: the preload that carries weight is
        not included.  ``element_N`` (n, 3) are the forces of elements beside spring and damper, which frames
        that are moved by forces know; without them, gap springs count from the bushing without load.
        """
        first_m, first_m_per_s = pose.carried(self.first, self.arm_m[0])
        second_m, second_m_per_s = pose.carried(self.second, self.arm_m[1])
        on_ground = (self.first < 0)[:, None, None]
        back = np.where(on_ground, np.eye(3), np.swapaxes(pose.rotation[..., self.first, :, :], -1, -2))
        axes = self.axes @ back
        deformation_m = turn(axes, second_m - first_m)
        rate_m_per_s = turn(axes, second_m_per_s - first_m_per_s)
        force_N = self.stiffness_N_per_m * deformation_m + self.damping_N_s_per_m * rate_m_per_s
        if element_N is not None:
            return deformation_m, force_N + element_N
        for number, law in self.characteristics:
            force_N[..., number, law.axis] += law.gap_force_N(deformation_m[..., number, law.axis])
        return deformation_m, force_N
