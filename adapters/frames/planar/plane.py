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

from orchestrator.ports import Array, Indices

Complex = npt.NDArray[np.complex128]


def in_plane(vector: Array) -> Complex:
    """z + i x of vectors (..., 3)."""
    return np.asarray(vector[..., 2] + 1j * vector[..., 0])


def in_space(value: Complex) -> Array:
    """The vectors (..., 3) of  z + i x,  without a part across."""
    vector = np.zeros((*value.shape, 3))
    vector[..., 0], vector[..., 2] = value.imag, value.real
    return vector


def power(force: Complex, velocity: Complex) -> Array:
    """F . v"""
    return np.asarray((force.conj() * velocity).real)


def carrying(body: Indices, position_m: Array, drawn_m: Array) -> Complex:
    """(2 bodies, n): displacement of points at ``position_m`` (n, 3) per natural coordinate.
    They are fixed to the bodies ``body`` (n,), -1 for the ground, centres at ``drawn_m``."""
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
        """The plane's part of matrices (..., 3, 3)."""
        up, along, mixed = matrix[..., 2, 2], matrix[..., 0, 0], matrix[..., 0, 2]
        return Symmetric((up + along) / 2, (up - along) / 2 + 1j * mixed)

    def times(self, vector: Complex) -> Complex:
        return np.asarray(self.even * vector + self.odd * vector.conj())


@dataclass(frozen=True)
class Poses:
    """Bodies at several times: natural coordinates ``place`` and their ``rate`` (times, 2
    bodies), displacements first; ``turn`` = exp(i angle) and ``spin_rad_per_s`` (times, bodies)."""

    place: Complex
    rate: Complex
    turn: Complex
    spin_rad_per_s: Array

    @staticmethod
    def of(place: Array, rate: Array) -> Poses:
        """From (times, bodies, 3) each: displacement up and along, angle; and their rates."""
        turned, spin_rad_per_s = np.expm1(1j * place[..., 2]), rate[..., 2]
        turn = 1 + turned
        return Poses(
            np.concatenate([place[..., 0] + 1j * place[..., 1], turned], axis=1),
            np.concatenate([rate[..., 0] + 1j * rate[..., 1], 1j * spin_rad_per_s * turn], axis=1),
            turn,
            spin_rad_per_s,
        )

    @property
    def moved_m(self) -> Complex:
        """Of the centres of mass, (times, bodies)."""
        return self.place[:, : self.turn.shape[1]]

    def acceleration(self, body_m_per_s2: Complex, spin_rad_per_s2: Array) -> Complex:
        """Of the natural coordinates, (times, 2 bodies), from that of the centres of mass and of
        the angles, (times, bodies) each."""
        return np.concatenate(
            [body_m_per_s2, (1j * spin_rad_per_s2 - self.spin_rad_per_s**2) * self.turn], axis=1
        )

    @property
    def velocity_m_per_s(self) -> Complex:
        return self.rate[:, : self.turn.shape[1]]


def wrench(force: Complex, turn: Complex) -> Array:
    """Force up and along, and moment, (times, bodies, 3), of forces (times, 2 bodies) on the
    natural coordinates of bodies with these ``turn``."""
    bodies = turn.shape[1]
    found = np.empty((*turn.shape, 3))
    found[..., 0], found[..., 1] = force[:, :bodies].real, force[:, :bodies].imag
    found[..., 2] = (force[:, bodies:] * turn.conj()).imag
    return found
