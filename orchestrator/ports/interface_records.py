"""The records that cross between solvers (points with a vector at each) and the accounts they give.

Records check themselves: a wrong shape, a wrong dtype or a NaN cannot cross a port.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from math import isfinite
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from scipy.sparse import csr_array

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]


class BrokenRecord(ValueError):
    """An error of a record with a wrong shape, a wrong dtype or a value that is not finite.

    The message names the record, the field and the first bad point.
    """


def _checked(record: str, field_name: str, value: Array) -> None:
    if not isinstance(value, np.ndarray) or value.dtype != np.float64:
        kind = getattr(value, "dtype", type(value).__name__)
        raise BrokenRecord(f"{record}.{field_name}: float64 array wanted, got {kind}")
    if value.ndim != 2 or value.shape[1] != 3:
        raise BrokenRecord(f"{record}.{field_name}: shape (points, 3) wanted, got {value.shape}")
    flat = value.ravel()
    if isfinite(flat.dot(flat)):  # far quicker than number by number; huge ones overflow
        return
    if not np.isfinite(value).all():
        point = int(np.flatnonzero(~np.isfinite(value).all(axis=1))[0])
        raise BrokenRecord(f"{record}.{field_name}: point {point} is {value[point].tolist()}")


@dataclass(frozen=True)
class Motion:
    """The places and velocities of points.

    Parameters
    ----------
    position_m, velocity_m_per_s
        float64 arrays of shape (points, 3), in the world frame.

    Raises
    ------
    BrokenRecord
        The shapes differ or are wrong, or a value is not finite.
    """

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

    @staticmethod
    def unchecked(position_m: Array, velocity_m_per_s: Array) -> Motion:
        """Return a motion computed from checked ones, without another check."""
        motion = object.__new__(Motion)
        motion.__dict__.update(position_m=position_m, velocity_m_per_s=velocity_m_per_s)
        return motion

    def part(self, points: slice | Indices) -> Motion:
        """Return the motion of some of the points."""
        return Motion.unchecked(self.position_m[points], self.velocity_m_per_s[points])


@dataclass(frozen=True)
class Known:
    """The motion of some of the points at the end of an interval, whatever pushes them.

    Parameters
    ----------
    motion
        A row for every point; the rows of points that are not known mean nothing.
    which
        Bool, (points,): the points of which the motion is known.
    """

    motion: Motion
    which: npt.NDArray[np.bool_]

    @staticmethod
    def nothing(points: int) -> Known:
        """Return the record of that many points without any known motion."""
        return Known(Motion(*np.zeros((2, points, 3))), np.zeros(points, dtype=np.bool_))

    def part(self, points: slice | Indices) -> Known:
        """Return the known motion of some of the points."""
        return Known(self.motion.part(points), self.which[points])

    def among(self, points: int, at: Indices) -> Known:
        """Return these points as the numbers ``at`` among ``points``; the others are not known."""
        known = Known.nothing(points)
        known.which[at] = self.which
        known.motion.position_m[at] = self.motion.position_m
        known.motion.velocity_m_per_s[at] = self.motion.velocity_m_per_s
        return known

    def over(self, otherwise: Motion) -> Motion:
        """Return the motion of all points: ``otherwise`` where it is not known."""
        which = self.which[:, None]
        return Motion(
            np.where(which, self.motion.position_m, otherwise.position_m),
            np.where(which, self.motion.velocity_m_per_s, otherwise.velocity_m_per_s),
        )


@dataclass(frozen=True)
class Load:
    """A force at each point, of the giver on the receiver: the mean over a sync interval.

    Parameters
    ----------
    force_N
        float64 array of shape (points, 3), in the world frame.

    Raises
    ------
    BrokenRecord
        The shape is wrong, or a value is not finite.
    """

    force_N: Array

    def __post_init__(self) -> None:
        _checked("Load", "force_N", self.force_N)

    def __len__(self) -> int:
        return len(self.force_N)

    @staticmethod
    def unchecked(force_N: Array) -> Load:
        """Return a load computed from checked ones, without another check."""
        load = object.__new__(Load)
        load.__dict__["force_N"] = force_N
        return load

    def part(self, points: slice | Indices) -> Load:
        """Return the load on some of the points."""
        return Load.unchecked(self.force_N[points])

    @staticmethod
    def zero(points: int) -> Load:
        """Return a load of zero at that many points."""
        return Load(np.zeros((points, 3)))


def check_point_count(what: str, record: Motion | Load, points: int) -> None:
    """Raise BrokenRecord for a record of other than ``points`` points; the message names ``what`` and both
    numbers."""
    if len(record) != points:
        raise BrokenRecord(f"{what}: {points} points wanted, got {len(record)}")


@dataclass(frozen=True)
class PanelState:
    """What a panel hands over at a sync point.

    Parameters
    ----------
    surface
        The motion of the panel's own surface points.
    reaction
        The panel's mean force on the frames over the interval that ended, one row per clamp point;
        at t = 0 the static force.
    """

    surface: Motion
    reaction: Load


@dataclass(frozen=True)
class Mount:
    """The clamp points of a panel, where frames hold it.

    Parameters
    ----------
    position_m
        (clamps, 3) in the world at t = 0.
    frame
        The name of the frame that holds each point, (clamps,).
    """

    position_m: Array
    frame: tuple[str, ...]


@dataclass(frozen=True)
class Pose:
    """The places and rotations of rigid bodies, and their rates, in world axes.

    All arrays may have a leading axis of moments.

    Parameters
    ----------
    position_m
        (bodies, 3), of the centres of mass.
    rotation
        (bodies, 3, 3), the rotations since t = 0: an arm r of t = 0 is now  rotation r.
    velocity_m_per_s
        (bodies, 3), of the centres of mass.
    spin_rad_per_s
        (bodies, 3), the angular velocities.
    """

    position_m: Array
    rotation: Array
    velocity_m_per_s: Array
    spin_rad_per_s: Array

    @staticmethod
    def nothing() -> Pose:
        """Return the pose of no body."""
        return Pose(np.empty((0, 3)), np.empty((0, 3, 3)), *np.empty((2, 0, 3)))

    def carried(self, body: Indices, arm_m: Array) -> tuple[Array, Array]:
        """Return places and velocities (..., n, 3) of points that bodies carry.

        ``body`` (n,) are the bodies' numbers and ``arm_m`` (n, 3) the points' arms at t = 0 from the centres
        of mass; -1 is the ground, whose points are at ``arm_m`` itself.  No value depends on how many moments
        are asked for.
        """
        turned_m = turn(self.rotation[..., body, :, :], arm_m)
        spun_m_per_s = cross(self.spin_rad_per_s[..., body, :], turned_m)
        on_ground = (body < 0)[:, None]
        return (
            np.where(on_ground, arm_m, self.position_m[..., body, :] + turned_m),
            np.where(on_ground, 0.0, self.velocity_m_per_s[..., body, :] + spun_m_per_s),
        )


def turn(rotation: Array, vector: Array) -> Array:
    """Return each vector (..., 3), turned by its matrix (..., 3, 3); none depends on how many there are."""
    return np.asarray((rotation @ vector[..., None])[..., 0])


def cross(a: Array, b: Array) -> Array:
    """Return cross products (..., 3); ten times faster than np.cross for few rows."""
    product = np.empty_like(b)
    product[..., 0] = a[..., 1] * b[..., 2] - a[..., 2] * b[..., 1]
    product[..., 1] = a[..., 2] * b[..., 0] - a[..., 0] * b[..., 2]
    product[..., 2] = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return product


@dataclass(frozen=True)
class AngularAccount:
    """Angular momentum of a solver about the world's origin; all vectors (3,).

    Parameters
    ----------
    momentum_kg_m2_per_s
        The angular momentum now.
    outside_impulse_N_m_s
        Received since t = 0 from everything that is not a port.
    received_N_m_s
        Received since t = 0 through each port by name, from the solver's own places of the points
        inside the intervals.
    """

    momentum_kg_m2_per_s: Array
    outside_impulse_N_m_s: Array
    received_N_m_s: Mapping[str, Array]


@dataclass(frozen=True)
class Account:
    """What a solver owns, and what went through it since t = 0.

    The solver's own defect is  d(stored) + lost - supplied - received, zero for a perfect one.

    Parameters
    ----------
    momentum_kg_m_per_s
        The momentum now, (3,).
    outside_impulse_N_s
        The impulse (3,) received since t = 0 from everything that is *not* a port: gravity, ground,
        exciters, drives, particles fed or removed.
    stored_J
        Energy now, by name (kinetic, elastic, ...).
    lost_J
        Energy dissipated since t = 0, by name.
    supplied_J
        Energy that exciters, drives, gravity or feeds supplied since t = 0, by name.
    received_J
        Work received through each port since t = 0, positive into the solver, from the solver's own
        motion inside the intervals.
    angular
        The same for angular momentum; None of a solver that does not tell it.
    moved_N_s
        The sum of the sizes of the momenta of all single bodies that it has now, and of those that came
        and went since t = 0: they may cancel each other to rounding.  0 where the impulses through its
        points tell as much.
    """

    momentum_kg_m_per_s: Array
    outside_impulse_N_s: Array
    stored_J: Mapping[str, float] = field(default_factory=dict)
    lost_J: Mapping[str, float] = field(default_factory=dict)
    supplied_J: Mapping[str, float] = field(default_factory=dict)
    received_J: Mapping[str, float] = field(default_factory=dict)
    angular: AngularAccount | None = None
    moved_N_s: float = 0.0


@dataclass(frozen=True)
class ContactTangent:
    """How the particles' mean load over an interval depends on the surface's velocity.

    At each point that moves with the constant velocity v from where the particles last saw it,

        load = push_N - impedance_N_s_per_m v.

    Only contacts that exist when the tangent is asked for count, each linear about its present place.

    Parameters
    ----------
    push_N
        The load on a surface at rest, (points, 3).
    impedance_N_s_per_m
        (points, 3, 3), symmetric and not negative.  The part of a contact inside a triangle stands
        at the triangle's corners, by the same shares as its load.
    """

    push_N: Array
    impedance_N_s_per_m: Array


@dataclass(frozen=True)
class Inertia:
    """Free masses that carry surface points.

    The points' velocity is ``shapes`` times the masses', and the masses feel the transpose of
    ``shapes`` times the points' load.

    Parameters
    ----------
    shapes
        (points, masses), sparse; the row of a point of which nothing is known is empty.
    mass_kg
        (masses,).
    held
        (masses, 3): the unit vector along which a mass does not yield, zero where it yields every
        way.
    """

    shapes: csr_array
    mass_kg: Array
    held: Array

    def yielding(self, values: Array) -> Array:
        """Return the part of vectors (masses, 3) along which the masses yield."""
        if not self._any_held:
            return values
        along = np.einsum("mk,mk->m", values, self.held)
        return np.asarray(values - along[:, None] * self.held)

    @cached_property
    def _any_held(self) -> bool:
        return bool(self.held.any())

    @staticmethod
    def unknown(points: int) -> Inertia:
        """Return the record of that many points behind which no mass is known."""
        from scipy.sparse import csr_array  # takes long to import, and few commands need it

        return Inertia(csr_array((points, 0)), np.empty(0), np.empty((0, 3)))


@dataclass(frozen=True)
class HermitePath:
    """The smooth path of points between two motions: cubic Hermite in position and velocity.

    Parameters
    ----------
    start, end
        The motions at both ends.
    length_s
        The time between them.

    Examples
    --------
    >>> import numpy as np
    >>> still = np.zeros((1, 3))
    >>> path = HermitePath(Motion(still, still), Motion(still + 1.0, still), 2.0)
    >>> float(path.position_m(0.5)[0, 0]), float(path.velocity_m_per_s(0.5)[0, 0])
    (0.5, 0.75)
    """

    start: Motion
    end: Motion
    length_s: float

    def position_m(self, fraction: float) -> Array:
        """Return the places (points, 3) at ``fraction`` (0 ... 1) of the time."""
        t, h = fraction, self.length_s
        value: Array = (
            (1 + 2 * t) * (1 - t) ** 2 * self.start.position_m
            + t * (1 - t) ** 2 * h * self.start.velocity_m_per_s
            + t * t * (3 - 2 * t) * self.end.position_m
            + t * t * (t - 1) * h * self.end.velocity_m_per_s
        )
        return value

    def velocity_m_per_s(self, fraction: float) -> Array:
        """Return the velocities (points, 3) at ``fraction`` of the time."""
        t, h = fraction, self.length_s
        value: Array = (
            6 * t * (t - 1) / h * (self.start.position_m - self.end.position_m)
            + (1 - t) * (1 - 3 * t) * self.start.velocity_m_per_s
            + t * (3 * t - 2) * self.end.velocity_m_per_s
        )
        return value

    def acceleration_m_per_s2(self, fraction: float) -> Array:
        """Return the accelerations (points, 3) at ``fraction`` of the time."""
        t, h = fraction, self.length_s
        value: Array = (
            (12 * t - 6) / h**2 * (self.start.position_m - self.end.position_m)
            + (6 * t - 4) / h * self.start.velocity_m_per_s
            + (6 * t - 2) / h * self.end.velocity_m_per_s
        )
        return value

    def at(self, fraction: float) -> Motion:
        """Return places and velocities at ``fraction`` of the time."""
        return Motion(self.position_m(fraction), self.velocity_m_per_s(fraction))


class InterfaceData(NamedTuple):
    """The data that crossed both interfaces in an interval of ``length_s``, under any scheme.

    ``frames`` has the frames' load and motion.  ``panel`` has the prescribed motion of the panels' clamps,
    the load on the panels, and the panels' state at the end.  ``particles`` has the path that the
    particles saw and their load, or is None without particles.
    """

    length_s: float
    frames: tuple[Load, Motion]
    panel: tuple[Motion, Load, PanelState]
    particles: tuple[HermitePath, Load] | None
