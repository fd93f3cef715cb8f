"""The ports: what crosses between solvers, and the two calls that every solver has.

Start reading here.  Motion runs down (frames -> panels -> particles), load runs up (particles ->
panels -> frames).  Everything that crosses is a list of points with a vector at each, in SI units
and in one world frame, so that the power through any interface is the sum of F . v.

Signs: a ``Load`` is always the force that the *giver* exerts on the *receiver*: particles on the
surface, panel on the frames.  A load that crosses is the mean over the sync interval
(impulse / length), never a sample, so that momentum is handed over exactly.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from math import isfinite
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt
from scipy.sparse import csr_array

from orchestrator.clock import Interval

if TYPE_CHECKING:
    from orchestrator.hermite import Path

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
    velocity_m_s: Array

    def __post_init__(self) -> None:
        _checked("Motion", "position_m", self.position_m)
        _checked("Motion", "velocity_m_s", self.velocity_m_s)
        if self.position_m.shape != self.velocity_m_s.shape:
            raise BrokenRecord(
                f"Motion: {len(self.position_m)} positions but {len(self.velocity_m_s)} velocities"
            )

    def __len__(self) -> int:
        return len(self.position_m)

    def part(self, points: slice | Indices) -> Motion:
        """The motion of some of the points."""
        return Motion(self.position_m[points], self.velocity_m_s[points])


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


def counted(what: str, record: Motion | Load, points: int) -> None:
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
class Account:
    """What a solver owns and what went through it since t = 0 (all SI, world frame).

    ``momentum_kg_m_s`` (3,) now; ``outside_impulse_N_s`` (3,) the impulse received so far from
    everything that is *not* a port (gravity, ground, exciters, drives, particles fed or removed).
    ``stored_J`` by name, now; ``lost_J`` (dissipated), ``supplied_J`` (exciters, drives, feed) by
    name, summed since t = 0; ``received_J`` the work received through each port since t = 0,
    positive into the solver, computed from the solver's own motion inside the interval.
    A solver's own defect is  d(stored) + lost - supplied - received, zero for a perfect one.
    """

    momentum_kg_m_s: Array
    outside_impulse_N_s: Array
    stored_J: Mapping[str, float] = field(default_factory=dict)
    lost_J: Mapping[str, float] = field(default_factory=dict)
    supplied_J: Mapping[str, float] = field(default_factory=dict)
    received_J: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class ParticleSnapshot:
    """All particles at one instant, sorted by id.  Arrays of n rows; complete on rank 0 only."""

    id: Indices
    position_m: Array
    velocity_m_s: Array
    spin_rad_s: Array
    diameter_m: Array
    density_kg_m3: Array
    material: Indices


@dataclass(frozen=True)
class Removed:
    """Particles taken out, in the order of time, then id.  Arrays of n rows; complete on rank 0
    only.

    State of each when it was taken out; ``exit`` is the number of the exit that it was in, -1 of
    one that was lost: it left the domain.
    """

    id: Indices
    time_s: Array
    position_m: Array
    velocity_m_s: Array
    diameter_m: Array
    density_kg_m3: Array
    material: Indices
    exit: Indices


def in_order(parts: Sequence[Removed]) -> Removed:
    """All of several, none included, in the order of time, then id."""
    nothing, nobody = np.empty(0), np.empty(0, dtype=np.int64)
    places = np.empty((0, 3))
    none = Removed(nobody, nothing, places, places, nothing, nothing, nobody, nobody)
    names = [part.name for part in fields(Removed)]
    joined = {n: np.concatenate([getattr(one, n) for one in (none, *parts)]) for n in names}
    order = np.lexsort((joined["id"], joined["time_s"]))
    return Removed(**{name: values[order] for name, values in joined.items()})


class Frames(Protocol):
    """Rigid bodies that carry points.  The points (clamps, walls, probes) are given at build."""

    def initial(self) -> Motion:
        """Carried points at t = 0."""
        ...

    def advance(self, interval: Interval, reaction: Load) -> Motion:
        """Carried points at the interval's end; ``reaction`` acts on them during the interval."""
        ...

    def account(self) -> Account:
        """received_J has the key "reaction"."""
        ...

    def close(self) -> None: ...


class Panel(Protocol):
    """A deformable surface held at its clamp points.

    The clamps move smoothly (cubic Hermite in position and velocity) from the motion given last
    to the motion given now.
    """

    mount: Mount

    def initial(self) -> PanelState:
        """At rest between the clamps at t = 0."""
        ...

    def advance(self, interval: Interval, clamps: Motion, load: Load) -> PanelState:
        """``load`` is constant over the interval and acts on the surface points."""
        ...

    def account(self) -> Account:
        """received_J has the keys "load" and "clamps"."""
        ...

    def close(self) -> None: ...


class MeshedPanel(Panel, Protocol):
    """A panel with a mesh of its own, which the particles' surface is mapped to."""

    def interpolation(self, coordinates_m: Array) -> csr_array:
        """H of shape (n, surface points): values at material coordinates (n, 2) = H @ values at
        the surface points.  Rows sum to one, so H.T hands over load without loss."""
        ...


class Particles(Protocol):
    """Particles that touch a triangulated surface (its topology is given at build)."""

    def initial(self) -> Load:
        """Force on the surface points at t = 0."""
        ...

    def advance(self, interval: Interval, path: Path) -> Load:
        """Mean force on the surface points over the interval, during which they follow ``path``.

        The path's start may differ from the last path's end by the coupling's correction of
        what was extrapolated; the work of that small jump is booked as received, too.
        """
        ...

    def snapshot(self) -> ParticleSnapshot: ...

    def removed(self) -> Removed:
        """Who was taken out since this was last asked."""
        ...

    def account(self) -> Account:
        """received_J has the key "surface"."""
        ...

    def close(self) -> None: ...


class Wearing(Protocol):
    """Particles that wear the surface, built from a plan that asks for it."""

    def worn_m3(self) -> Array:
        """(surface points,) volume worn off since t = 0, by point; alike on every rank."""
        ...


Saved = dict[str, Any]
"""Arrays by name, or more of the same: what ``state.py`` makes of a solver's state."""


@runtime_checkable
class Restorable(Protocol):
    """A solver that can be taken back to a sync point, or another one brought there.

    A run that goes on from there is, bit for bit, the one that never stopped.  Both calls are
    collective under MPI; what each rank saves is its own.
    """

    def save(self) -> Saved:
        """All that decides how it goes on: copies, so that it may go on meanwhile.  Changes
        nothing."""
        ...

    def restore(self, saved: Saved) -> None:
        """Of this solver, or of another one opened with the same plan."""
        ...
