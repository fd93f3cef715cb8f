"""Poses, forces and books of bodies in space, computed by compiled code (``frames/kernel``).

Newmark's step with beta = 1/4, gamma = 1/2 is  m (v1 - v0) = h/2 (f0 + f1)  and
x1 - x0 = h/2 (v0 + v1).  So the mean of the forces at the two ends of a step gives the step's impulse to
rounding, and mean force times displacement gives the work exactly where the equations are linear.
``tests/frames/spatial_reference.py`` has the same in Python, with which the tests compare it.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from adapters.frames.common.ledger import BodyMotion
from adapters.frames.common.rigid_frames import BushingTable
from adapters.frames.exudyn.poses import Attached, Poses
from orchestrator.ports import Array, Indices, Motion, Pose, Saved, linear_frames
from orchestrator.ports.interface_records import cross, turn
from orchestrator.ports.plans import FramesPlan, SolverMissing

try:
    from adapters.frames import _kernel as kernel
except ImportError as missing:
    raise SolverMissing(
        f"the exudyn frames need their compiled part, which docker/setup.sh builds: {missing}"
    ) from missing


class CompiledBodies:
    """The bodies of a plan whose bushings are stretched by ``sag_m`` (bushings, 3) in the drawn position.

    ``kernel`` does the computing.  ``memory`` holds the arrays of the last step's end, on which the compiled
    code works, and ``poses`` shows those of the poses.  Of the bushings they are ``stretch_m`` and
    ``stretch_m_per_s`` along the spring axes, ``element_N``, the force of elements along these axes, which
    the frames set, and ``pull_N`` on the first body at ``from_m``, whose opposite acts on the second body at
    ``to_m``; all are (bushings, 3).  ``couple_N_m`` (bodies, 3) is the couple that a stretched bushing adds
    to its first body, and ``couple_before_N_m`` that of one step before.  ``exciter_N`` and ``exciter_m``
    (exciters, 3) are the forces and places of the exciters, and ``wrench`` (bodies, 6) is the load on the
    centres of mass.
    """

    def __init__(self, plan: FramesPlan, carrier: Indices, drawn_m: Array, sag_m: Array) -> None:
        self._drawn_m, self._inertia_kg_m2 = drawn_m, _array([body.inertia_kg_m2 for body in plan.bodies])
        bodies, bushings, exciters = len(plan.bodies), len(plan.bushings), len(plan.exciters)
        self.poses = Poses(
            center_m=np.zeros((bodies + 1, 3)),
            rotation=np.tile(np.eye(3), (bodies + 1, 1, 1)),
            velocity_m_per_s=np.zeros((bodies + 1, 3)),
            spin_rad_per_s=np.zeros((bodies + 1, 3)),
            spin_per_rate=np.zeros((bodies, 3, 3)),
        )
        by_bushing = ("stretch_m", "stretch_m_per_s", "element_N", "pull_N", "from_m", "to_m")
        self.memory: dict[str, Array] = {
            **vars(self.poses),
            **{name: np.zeros((bushings, 3)) for name in by_bushing},
            **{name: np.zeros((bodies, 3)) for name in ("couple_N_m", "couple_before_N_m")},
            **{name: np.zeros((exciters, 3)) for name in ("exciter_N", "exciter_m")},
            "wrench": np.zeros((bodies, 6)),
        }
        table = BushingTable(plan)
        self._stiffness_N_per_m, self._axes = table.stiffness_N_per_m, table.axes
        self._first, self._second = table.first, table.second
        excited = linear_frames.numbers(plan, tuple(exciter.body for exciter in plan.exciters))
        excited_m = _array([exciter.position_m for exciter in plan.exciters]).reshape(-1, 3)
        constants: dict[str, Any] = {
            "drawn_m": drawn_m,
            "mass_kg": _array([body.mass_kg for body in plan.bodies]),
            "inertia_kg_m2": self._inertia_kg_m2,
            "gravity_m_per_s2": _array(plan.gravity_m_per_s2),
            "is_free": _flags(bodies, linear_frames.free(plan)),
            "is_driven": _flags(bodies, linear_frames.driven(plan)),
            **_attached("first", Attached.at(table.place_m, table.first, drawn_m)),
            **_attached("second", Attached.at(table.place_m, table.second, drawn_m)),
            "axes": table.axes,
            "stiffness_N_per_m": table.stiffness_N_per_m,
            "damping_N_s_per_m": table.damping_N_s_per_m,
            "sag_m": _array(sag_m),
            **_attached("excited", Attached.at(excited_m, excited, drawn_m)),
            "start": _array([exciter.start for exciter in plan.exciters]).reshape(-1, 3),
            "across": _array([np.cross(e.axis, e.start) for e in plan.exciters]).reshape(-1, 3),
            **_attached("carried", Attached.at(plan.points_m, carrier, drawn_m)),
        }
        turning = ("speed_rad_per_s", "run_up_s", "start_s", "stop_s", "run_down_s", "phase_rad")
        for name in ("mass_moment_kg_m", *turning):
            constants[name] = _array([getattr(exciter, name) for exciter in plan.exciters])
        self.kernel = kernel.SpatialBodies(**constants, **self.memory)

    def carried(self) -> Motion:
        """Return the motion of the carried points."""
        return Motion(*self.kernel.carry())

    def pose(self) -> Pose:
        """Return the pose of the bodies."""
        poses, bodies = self.poses, slice(-1)
        return Pose(
            poses.center_m[bodies].copy(),
            poses.rotation[bodies].copy(),
            poses.velocity_m_per_s[bodies].copy(),
            poses.spin_rad_per_s[bodies].copy(),
        )

    def motion(self) -> BodyMotion:
        """Return the motion of the bodies."""
        poses = self.poses
        velocity_m_per_s, spin_rad_per_s = poses.velocity_m_per_s[:-1], poses.spin_rad_per_s[:-1]
        body_spin = turn(poses.rotation[:-1].transpose(0, 2, 1), spin_rad_per_s)
        turning_J = np.sum(body_spin * turn(self._inertia_kg_m2, body_spin), axis=1) / 2
        return BodyMotion(velocity_m_per_s, poses.center_m[:-1] - self._drawn_m, turning_J)

    def elastic_J(self) -> float:
        """Return the elastic energy in the bushings' linear springs in J."""
        return float(np.sum(self._stiffness_N_per_m * self.memory["stretch_m"] ** 2)) / 2

    def replace_element_forces(self, element_N: Array) -> Array:
        """Put other forces of elements along the axes, (bushings, 3), in the place of those that act now, and
        return by how much the loads (bodies, 6) on the centres of mass grow."""
        memory, poses = self.memory, self.poses
        along_N = element_N - memory["element_N"]
        pull_N = turn(poses.rotation[self._first], np.einsum("nij,ni->nj", self._axes, along_N))
        memory["element_N"][:] = element_N
        memory["pull_N"][:] += pull_N
        wrench = np.zeros((len(poses.center_m), 6))  # the ground is the last row
        for body, place_m, force_N in (
            (self._first, memory["from_m"], pull_N),
            (self._second, memory["to_m"], -pull_N),
        ):
            moment_N_m = cross(place_m - poses.center_m[body], force_N)
            np.add.at(wrench, body, np.hstack([force_N, moment_N_m]))
        couple_N_m = np.zeros((len(poses.center_m), 3))
        np.add.at(couple_N_m, self._first, cross(memory["to_m"] - memory["from_m"], pull_N))
        memory["couple_N_m"][:] += couple_N_m[:-1]
        return wrench[:-1]

    def save(self) -> Saved:
        return {name: array.copy() for name, array in self.memory.items()}

    def restore(self, saved: Saved) -> None:
        """Restore into the arrays that are there: compiled code works on them."""
        for name, array in self.memory.items():
            array[:] = saved[name]


def _array(values: Any) -> Array:
    return np.ascontiguousarray(values, dtype=np.float64)


def _flags(bodies: int, some: Indices) -> kernel.Ints:
    return np.isin(np.arange(bodies), some).astype(np.int32)


def _attached(name: str, points: Attached) -> dict[str, Any]:
    return {f"{name}_body": points.body.astype(np.int32), f"{name}_arm_m": _array(points.arm_m)}
