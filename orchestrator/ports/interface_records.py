"""The records that cross between solvers, points with a vector at each, and the accounts they give.

What crosses checks itself: a wrong shape, a wrong dtype or a NaN cannot cross a port.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import isfinite
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from scipy.sparse import csr_array

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]


class BrokenRecord(ValueError):
    """A record with a wrong shape, a wrong dtype or a value that is not finite.

    The message names record, field and the first bad point.
    """


def _checked(record: str, field_name: str, value: Array) -> None:
    if not isinstance(value, np.ndarray) or value.dtype != np.float64:
        kind = getattr(value, "dtype", type(value).__name__)
        raise BrokenRecord(f"{record}.{field_name}: float64 array wanted, got {kind}")
    if value.ndim != 2 or value.shape[1] != 3:
        raise BrokenRecord(f"{record}.{field_name}: shape (points, 3) wanted, got {value.shape}")
    if isfinite(np.vdot(value, value)):  # far quicker than number by number; huge ones overflow
        return
    if not np.isfinite(value).all():
        point = int(np.flatnonzero(~np.isfinite(value).all(axis=1))[0])
        raise BrokenRecord(f"{record}.{field_name}: point {point} is {value[point].tolist()}")


@dataclass(frozen=True)
class Motion:
    """Where points are and how fast they go: two float64 arrays of shape (points, 3)."""

    position_m: Array
    velocity_m_per_s: Array

    def __post_init__(self) -> None:
        _checked("Motion", "position_m", self.position_m)
        _checked("Motion", "velocity_m_per_s", self.velocity_m_per_s)
        if self.position_m.shape != self.velocity_m_per_s.shape:
            raise BrokenRecord(
                f"Motion: {len(self.position_m)} positions but {len(self.velocity_m_per_s)} velocities"
            )

    def __len__(self) -> int:
        return len(self.position_m)

    def part(self, points: slice | Indices) -> Motion:
        """The motion of some of the points."""
        return Motion(self.position_m[points], self.velocity_m_per_s[points])


@dataclass(frozen=True)
class Known:
    """Where some of the points are going to be at the end of an interval, whatever pushes them.

    ``which`` (points,), bool: the points of which this is known.  ``motion`` has a row for every
    point; the rows of the others mean nothing.
    """

    motion: Motion
    which: npt.NDArray[np.bool_]

    @staticmethod
    def nothing(points: int) -> Known:
        """Of that many points, none is known."""
        return Known(Motion(*np.zeros((2, points, 3))), np.zeros(points, dtype=np.bool_))

    def part(self, points: slice | Indices) -> Known:
        """What is known of some of the points."""
        return Known(self.motion.part(points), self.which[points])

    def among(self, points: int, at: Indices) -> Known:
        """These points as the numbers ``at`` among so many, of the others of which nothing is
        known."""
        found = Known.nothing(points)
        found.which[at] = self.which
        found.motion.position_m[at] = self.motion.position_m
        found.motion.velocity_m_per_s[at] = self.motion.velocity_m_per_s
        return found

    def over(self, otherwise: Motion) -> Motion:
        """The motion of all points: ``otherwise`` where it is not known."""
        which = self.which[:, None]
        return Motion(
            np.where(which, self.motion.position_m, otherwise.position_m),
            np.where(which, self.motion.velocity_m_per_s, otherwise.velocity_m_per_s),
        )


@dataclass(frozen=True)
class Load:
    """A force at each point, float64 of shape (points, 3): the mean over a sync interval."""

    force_N: Array

    def __post_init__(self) -> None:
        _checked("Load", "force_N", self.force_N)

    def __len__(self) -> int:
        return len(self.force_N)

    @staticmethod
    def zero(points: int) -> Load:
        return Load(np.zeros((points, 3)))


def check_point_count(what: str, record: Motion | Load, points: int) -> None:
    """Refuse a record that has not exactly ``points`` points (BrokenRecord names both numbers)."""
    if len(record) != points:
        raise BrokenRecord(f"{what}: {points} points wanted, got {len(record)}")


@dataclass(frozen=True)
class PanelState:
    """What a panel hands over: its surface points' motion, and its force on the frames.

    ``surface`` has the panel's own surface points, ``reaction`` its clamp points (mean force of
    the panel on the frames over the interval that ended; at t = 0 the static force).
    """

    surface: Motion
    reaction: Load


@dataclass(frozen=True)
class Mount:
    """Clamp points of a panel: where frames hold it.

    ``position_m`` (clamps, 3) in the world at t = 0; ``frame`` (clamps,) the name of the frame
    that holds each point.
    """

    position_m: Array
    frame: tuple[str, ...]


@dataclass(frozen=True)
class AngularAccount:
    """Angular momentum about the world's origin, (3,) each: ``momentum_kg_m2_per_s`` now,
    ``outside_impulse_N_m_s`` received since t = 0 from everything that is not a port, and
    ``received_N_m_s`` through each port, from the solver's own places inside the interval."""

    momentum_kg_m2_per_s: Array
    outside_impulse_N_m_s: Array
    received_N_m_s: Mapping[str, Array]


@dataclass(frozen=True)
class Account:
    """What a solver owns and what went through it since t = 0 (all SI, world frame).

    ``momentum_kg_m_per_s`` (3,) now; ``outside_impulse_N_s`` (3,) the impulse received so far from
    everything that is *not* a port (gravity, ground, exciters, drives, particles fed or removed).
    ``stored_J`` by name, now; ``lost_J`` (dissipated), ``supplied_J`` (exciters, drives, feed) by
    name, summed since t = 0; ``received_J`` the work received through each port since t = 0,
    positive into the solver, computed from the solver's own motion inside the interval.
    A solver's own defect is  d(stored) + lost - supplied - received, zero for a perfect one.
    ``angular`` is the same for angular momentum, None of a solver that does not tell.
    """

    momentum_kg_m_per_s: Array
    outside_impulse_N_s: Array
    stored_J: Mapping[str, float] = field(default_factory=dict)
    lost_J: Mapping[str, float] = field(default_factory=dict)
    supplied_J: Mapping[str, float] = field(default_factory=dict)
    received_J: Mapping[str, float] = field(default_factory=dict)
    angular: AngularAccount | None = None


@dataclass(frozen=True)
class ContactTangent:
    """How the particles' mean load on the surface over an interval answers to the surface's motion:
    at each point, moving with the constant velocity v from where the particles last saw it,

        load = push_N - impedance_N_s_per_m v.

    ``push_N`` (points, 3), ``impedance_N_s_per_m`` (points, 3, 3) symmetric and not negative; the part
    of a contact inside a triangle stands at its corners, by the same shares as its load.  It knows
    only the contacts that there are when it is asked for, each linear about its present place.
    """

    push_N: Array
    impedance_N_s_per_m: Array


@dataclass(frozen=True)
class Inertia:
    """Free masses ``mass_kg`` (masses,) that carry surface points: the points' velocity is
    ``shapes`` (points, masses), sparse, times the masses' (masses, 3), and the masses feel its
    transpose times the points' load.  ``held`` (masses, 3): the unit vector along which a mass
    does not yield, zero where it yields every way.  The row of a point that nothing is known of is
    empty.
    """

    shapes: csr_array
    mass_kg: Array
    held: Array

    def yielding(self, values: Array) -> Array:
        """The part of vectors (masses, 3) in which the masses yield."""
        along = np.einsum("mk,mk->m", values, self.held)
        return np.asarray(values - along[:, None] * self.held)

    @staticmethod
    def unknown(points: int) -> Inertia:
        from scipy.sparse import csr_array  # takes long to import, and few commands need it

        return Inertia(csr_array((points, 0)), np.empty(0), np.empty((0, 3)))


@dataclass(frozen=True)
class HermitePath:
    """Points moving from ``start`` to ``end`` in ``length_s`` with continuous velocity."""

    start: Motion
    end: Motion
    length_s: float

    def position_m(self, fraction: float) -> Array:
        """(points, 3) at ``fraction`` (0 ... 1) of the interval."""
        t, h = fraction, self.length_s
        value: Array = (
            (1 + 2 * t) * (1 - t) ** 2 * self.start.position_m
            + t * (1 - t) ** 2 * h * self.start.velocity_m_per_s
            + t * t * (3 - 2 * t) * self.end.position_m
            + t * t * (t - 1) * h * self.end.velocity_m_per_s
        )
        return value

    def velocity_m_per_s(self, fraction: float) -> Array:
        t, h = fraction, self.length_s
        value: Array = (
            6 * t * (t - 1) / h * (self.start.position_m - self.end.position_m)
            + (1 - t) * (1 - 3 * t) * self.start.velocity_m_per_s
            + t * (3 * t - 2) * self.end.velocity_m_per_s
        )
        return value

    def acceleration_m_per_s2(self, fraction: float) -> Array:
        t, h = fraction, self.length_s
        value: Array = (
            (12 * t - 6) / h**2 * (self.start.position_m - self.end.position_m)
            + (6 * t - 4) / h * self.start.velocity_m_per_s
            + (6 * t - 2) / h * self.end.velocity_m_per_s
        )
        return value

    def at(self, fraction: float) -> Motion:
        return Motion(self.position_m(fraction), self.velocity_m_per_s(fraction))
