"""Rigid bodies in the plane normal to y, written with complex numbers.

A vector of the plane is  z + i x.  Then turning about y by an angle a is a multiplication by
exp(i a), and the moment about y of a force F at an arm r is Im(conj(r) F).  No angle is small.

Natural coordinates of a body are its displacement and  exp(i angle) - 1:  all its points move
linearly in them,  displacement + arm (exp(i angle) - 1),  so that one constant matrix takes the
coordinates of all bodies to the displacements of all points, their rates to velocities, and
forces on the points back to forces on the coordinates (Garcia de Jalon and Bayo, Kinematic and
Dynamic Simulation of Multibody Systems, 1994, ch. 2).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from adapters.frames.common.drive import coordinates
from orchestrator.ports import Array, Indices
from orchestrator.ports.plans import BodyPlan, DrivePlan

Complex = npt.NDArray[np.complex128]


def in_plane(vector: Array) -> Complex:
    """Return  z + i x  of vectors (..., 3)."""
    return np.asarray(vector[..., 2] + 1j * vector[..., 0])


def in_space(value: Complex) -> Array:
    """Return the vectors (..., 3) of  z + i x,  without a part across."""
    vector = np.zeros((*value.shape, 3))
    vector[..., 0], vector[..., 2] = value.imag, value.real
    return vector


def power(force: Complex, velocity: Complex) -> Array:
    """Return the power F . v of a force at a point with this velocity."""
    return np.asarray((force.conj() * velocity).real)


def carrying(body: Indices, position_m: Array, drawn_m: Array) -> Complex:
    """Return the matrix (2 bodies, n) of the points' displacements per natural coordinate.

    The points at ``position_m`` (n, 3) are fixed to the bodies ``body`` (n,), -1 for the ground, whose
    centres are at ``drawn_m``.
    """
    fixed = np.arange(len(drawn_m))[:, None] == body
    arm_m = in_plane(position_m) - in_plane(drawn_m)[:, None]
    return np.vstack([fixed, fixed * arm_m])


@dataclass(frozen=True)
class Symmetric:
    """Symmetric matrices of the plane:  matrix times vector = even v + odd conj(v)."""

    even: Array
    odd: Complex

    @staticmethod
    def of(matrix: Array) -> Symmetric:
        """Return the plane's part of matrices (..., 3, 3)."""
        up, along, mixed = matrix[..., 2, 2], matrix[..., 0, 0], matrix[..., 0, 2]
        return Symmetric((up + along) / 2, (up - along) / 2 + 1j * mixed)

    def times(self, vector: Complex) -> Complex:
        return np.asarray(self.even * vector + self.odd * vector.conj())


@dataclass(frozen=True)
class PlanarPoses:
    """Bodies in the plane at several times.

    ``place`` and ``rate`` (times, 2 bodies) are the natural coordinates and their rates, displacements first;
    ``turn`` = exp(i angle) and ``spin_rad_per_s`` (times, bodies).
    """

    place: Complex
    rate: Complex
    turn: Complex
    spin_rad_per_s: Array

    @staticmethod
    def of(place: Array, rate: Array) -> PlanarPoses:
        """Return the poses for displacements up and along, and angles.

        ``place`` and the rates ``rate`` have the shape (times, bodies, 3).
        """
        rotation, spin_rad_per_s = np.expm1(1j * place[..., 2]), rate[..., 2]
        turn = 1 + rotation
        return PlanarPoses(
            np.concatenate([place[..., 0] + 1j * place[..., 1], rotation], axis=1),
            np.concatenate([rate[..., 0] + 1j * rate[..., 1], 1j * spin_rad_per_s * turn], axis=1),
            turn,
            spin_rad_per_s,
        )

    @property
    def moved_m(self) -> Complex:
        """The displacement of the centres of mass, (times, bodies)."""
        return self.place[:, : self.turn.shape[1]]

    def acceleration(self, body_m_per_s2: Complex, spin_rad_per_s2: Array) -> Complex:
        """Return the acceleration of the natural coordinates, (times, 2 bodies), from that of the centres
        of mass and of the angles, (times, bodies) each."""
        return np.concatenate(
            [body_m_per_s2, (1j * spin_rad_per_s2 - self.spin_rad_per_s**2) * self.turn], axis=1
        )

    @property
    def velocity_m_per_s(self) -> Complex:
        """The velocity of the centres of mass, (times, bodies)."""
        return self.rate[:, : self.turn.shape[1]]


def wrench(force: Complex, turn: Complex) -> Array:
    """Return force up and along, and moment, (times, bodies, 3), of forces (times, 2 bodies) on the
    natural coordinates of bodies with these ``turn``."""
    push, moment = np.split(force, 2, axis=1)
    return np.stack([push.real, push.imag, (moment * turn.conj()).imag], axis=-1)


class PlanarDrive:
    """The motion of body number ``body``, exactly as its drive says.

    Raises ValueError for a drive that leaves the plane.
    """

    def __init__(self, number: int, body: BodyPlan, drive: DrivePlan) -> None:
        across = (drive.amplitude_m[1], *drive.rotation_rad[[0, 2]])
        if any(across):
            raise ValueError(
                f"the drive of {drive.body!r} leaves the vertical plane, to which planar frames "
                "are bound; exudyn and prescribed know no such bounds"
            )
        self.body, self._drive = number, drive
        self._arm_m = in_plane(body.center_of_mass_m - drive.center_m)

    def coordinates(self, time_s: Array) -> tuple[Array, Array]:
        """Return displacement of the centre of mass up and along, and angle; and their rates: (times,
        3) each."""
        value, rate = coordinates(self._drive, time_s)
        shift_m, shift_m_per_s = in_plane(value[:, 0]), in_plane(rate[:, 0])
        angle_rad, spin_rad_per_s = value[:, 1, 1], rate[:, 1, 1]
        moved_m = shift_m + np.expm1(1j * angle_rad) * self._arm_m
        velocity_m_per_s = shift_m_per_s + 1j * spin_rad_per_s * np.exp(1j * angle_rad) * self._arm_m
        place = np.stack([moved_m.real, moved_m.imag, angle_rad], axis=1)
        return place, np.stack([velocity_m_per_s.real, velocity_m_per_s.imag, spin_rad_per_s], axis=1)
