"""The grains as rigid bodies: their motion, and the sums of what acts on their spheres."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from orchestrator.ports import Array, Indices, ParticleSnapshot, Removed
from orchestrator.ports.grains import Grains, Shape
from orchestrator.ports.plans import ParticleList
from orchestrator.ports.rows import Rows
from tests.reference.spheres.spheres import Spheres
from tests.reference.spheres.triangle_spin import cross
from tests.reference.spheres.visits import Visits


def rotations(quaternions: Array) -> Array:
    """The rotations (n, 3, 3) of quaternions w, x, y, z (n, 4)."""
    if not len(quaternions):
        return np.empty((0, 3, 3))
    return np.asarray(Rotation.from_quat(quaternions[:, [1, 2, 3, 0]]).as_matrix())


def quaternions(rotations: Array) -> Array:
    """The quaternions of rotations."""
    if not len(rotations):
        return np.empty((0, 4))
    return np.asarray(Rotation.from_matrix(rotations).as_quat()[:, [3, 0, 1, 2]])


@dataclass
class Bodies(Rows):
    """n grains sorted by id; the columns of ``rotation`` (n, 3, 3) are their principal axes in the world."""

    id: Indices
    grains: Grains
    position_m: Array
    velocity_m_per_s: Array
    spin_rad_per_s: Array
    rotation: Array

    @staticmethod
    def of(particles: ParticleList, first_id: int) -> Bodies:
        """The grains of a list, with ids in order from ``first_id``."""
        count = len(particles)
        motion = (particles.position_m, particles.velocity_m_per_s, particles.spin_rad_per_s)
        rotation = rotations(particles.orientation)
        ids = first_id + np.arange(count)
        return Bodies(ids, particles.grains, *(values.copy() for values in motion), rotation=rotation)

    def __len__(self) -> int:
        return len(self.id)

    @property
    def mass_kg(self) -> Array:
        return self.grains.mass_kg

    @property
    def radius_m(self) -> Array:
        return self.grains.bounding_radius_m

    def spheres(self, shapes: Sequence[Shape]) -> Spheres:
        """The spheres of which the grains are made, body by body."""
        count = np.array([len(shape.spheres) for shape in shapes], dtype=np.int64)
        table = np.array([sphere for shape in shapes for sphere in shape.spheres]).reshape(-1, 4)
        body = np.repeat(np.arange(len(self)), count[self.grains.shape])
        first = np.cumsum(count[self.grains.shape]) - count[self.grains.shape]
        row = (np.cumsum(count) - count)[self.grains.shape][body] + np.arange(len(body)) - first[body]
        size_m = self.grains.sieve_size_m[body]
        spheres = Spheres(
            mass_kg=self.mass_kg[body],
            radius_m=size_m * table[row, 3],
            position_m=np.empty((len(body), 3)),
            velocity_m_per_s=np.empty((len(body), 3)),
            spin_rad_per_s=np.empty((len(body), 3)),
            id=self.id[body],
            material=self.grains.material[body],
            body=body,
            own_m=size_m[:, None] * table[row, :3],
            arm_m=np.empty((len(body), 3)),
            inverse_inertia_1_kg_m2=np.empty((len(body), 3, 3)),
        )
        self.carry(spheres)
        return spheres

    def carry(self, spheres: Spheres) -> None:
        """Move the spheres to where the grains are now."""
        if not len(spheres.body):
            return
        body = spheres.body
        arm_m = spheres.arm_m = self._arms_m(spheres)
        inverse = 1.0 / self.grains.inertia_kg_m2
        turned = np.einsum("nij,nj,nkj->nik", self.rotation, inverse, self.rotation)
        spheres.inverse_inertia_1_kg_m2 = turned[body]
        spheres.position_m = self.position_m[body] + arm_m
        spheres.spin_rad_per_s = self.spin_rad_per_s[body]
        spheres.velocity_m_per_s = self.velocity_m_per_s[body] + cross(spheres.spin_rad_per_s, arm_m)

    def _arms_m(self, spheres: Spheres) -> Array:
        return np.einsum("nij,nj->ni", self.rotation[spheres.body], spheres.own_m)

    def kick(
        self, spheres: Spheres, force_N: Array, torque_N_m: Array, step_s: float, gravity_m_per_s2: Array
    ) -> None:
        """Let the forces and torques on the spheres, (m, 3) each, and gravity act for ``step_s``."""
        force, torque = np.zeros((2, len(self), 3))
        np.add.at(force, spheres.body, force_N)
        np.add.at(torque, spheres.body, torque_N_m + cross(self._arms_m(spheres), force_N))
        self.velocity_m_per_s += step_s * (force / self.mass_kg[:, None] + gravity_m_per_s2)
        self.spin_rad_per_s += step_s * self._turned(torque, 1.0 / self.grains.inertia_kg_m2)
        self.carry(spheres)

    def drift(self, spheres: Spheres, step_s: float) -> None:
        """Let the grains fly and tumble for ``step_s``; half way they turn as their angular momentum says."""
        self.position_m += step_s * self.velocity_m_per_s
        inertia_kg_m2 = self.grains.inertia_kg_m2
        tumbles = np.flatnonzero(np.ptp(inertia_kg_m2, axis=1) > 0.0)
        if len(tumbles):
            momentum, start = self._turned(self.spin_rad_per_s, inertia_kg_m2), self.rotation[tumbles]
            for part_s in (step_s / 2.0, step_s):
                turn = Rotation.from_rotvec(part_s * self.spin_rad_per_s[tumbles]).as_matrix()
                self.rotation[tumbles] = Rotation.from_matrix(turn @ start).as_matrix()  # no scale creeps in
                self.spin_rad_per_s[tumbles] = self._turned(momentum, 1.0 / inertia_kg_m2)[tumbles]
        self.carry(spheres)

    def _turned(self, vectors: Array, factors: Array) -> Array:
        """Vectors (n, 3) times factors (n, 3) along the principal axes."""
        own = np.einsum("nij,ni->nj", self.rotation, vectors)
        return np.asarray(np.einsum("nij,nj->ni", self.rotation, factors * own))

    def momentum_kg_m_per_s(self) -> Array:
        return self.mass_kg @ self.velocity_m_per_s

    def angular_momentum_kg_m2_per_s(self) -> Array:
        """Their angular momentum (3,) about the world's origin."""
        own = self._turned(self.spin_rad_per_s, self.grains.inertia_kg_m2).sum(axis=0)
        return np.asarray(self.mass_kg @ np.cross(self.position_m, self.velocity_m_per_s) + own)

    def kinetic_J(self) -> float:
        turning = np.vdot(self.spin_rad_per_s, self._turned(self.spin_rad_per_s, self.grains.inertia_kg_m2))
        return float(self.mass_kg @ np.sum(self.velocity_m_per_s**2, axis=1) + turning) / 2.0

    def gravitational_J(self, gravity_m_per_s2: Array) -> float:
        return -float(self.mass_kg @ (self.position_m @ gravity_m_per_s2))

    def mechanical_J(self, gravity_m_per_s2: Array) -> float:
        return self.kinetic_J() + self.gravitational_J(gravity_m_per_s2)

    def snapshot(self) -> ParticleSnapshot:
        """A copy, as the port has it."""
        return ParticleSnapshot(
            id=self.id.copy(),
            position_m=self.position_m.copy(),
            velocity_m_per_s=self.velocity_m_per_s.copy(),
            spin_rad_per_s=self.spin_rad_per_s.copy(),
            grains=self.grains,
            orientation=quaternions(self.rotation),
        )

    def removed(self, time_s: float, exit_of: Indices, visits: Visits) -> Removed:
        """The record of all of them, taken out at ``time_s`` through ``exit_of`` (n,)."""
        return Removed(
            id=self.id,
            time_s=np.full(len(self), time_s),
            position_m=self.position_m,
            velocity_m_per_s=self.velocity_m_per_s,
            grains=self.grains,
            exit=exit_of,
            contacts=visits.contacts.astype(np.int32),
            over_s=visits.over_s.astype(np.float32),
            within_reach_s=visits.within_reach_s.astype(np.float32),
            last_panel=visits.last_panel,
        )
