"""The ports: what crosses between solvers, and the two calls that every solver has.

Start reading here; the records are in interface_records.py and particle_records.py.  Motion runs down
(frames -> panels -> particles), load runs up (particles -> panels -> frames).  Everything that
crosses is a list of points with a vector at each, in SI units and in one world frame, so that the
power through any interface is the sum of F . v.

Signs: a ``Load`` is always the force that the *giver* exerts on the *receiver*: particles on the
surface, panel on the frames.  A load that crosses is the mean over the sync interval
(impulse / length), never a sample, so that momentum is handed over exactly.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

from orchestrator.ports.clock import Interval
from orchestrator.ports.interface_records import (
    Account,
    AngularAccount,
    Array,
    BrokenRecord,
    ContactTangent,
    HermitePath,
    Indices,
    Inertia,
    Known,
    Load,
    Motion,
    Mount,
    PanelState,
    check_point_count,
)
from orchestrator.ports.particle_records import Crossings, Overlaps, ParticleSnapshot, Removed, sort_removed

if TYPE_CHECKING:
    from scipy.sparse import csr_array


__all__ = [
    "Account",
    "AngularAccount",
    "Array",
    "BrokenRecord",
    "ContactTangent",
    "Crossings",
    "Following",
    "Frames",
    "HermitePath",
    "Indices",
    "Inert",
    "Inertia",
    "Known",
    "Load",
    "MeshedPanel",
    "Motion",
    "Mount",
    "Overlaps",
    "Panel",
    "PanelState",
    "ParticleSnapshot",
    "Particles",
    "Predicting",
    "Removed",
    "Restorable",
    "Saved",
    "Scheduled",
    "Wearing",
    "check_point_count",
    "sort_removed",
]


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

    def advance(self, interval: Interval, path: HermitePath) -> Load:
        """Mean force on the surface points over the interval, during which they follow ``path``.

        Where the surface's motion was extrapolated, the path's start may differ from the last
        path's end by the coupling's correction of that; the work of this small jump is booked as
        received, too.
        """
        ...

    def snapshot(self) -> ParticleSnapshot: ...

    def removed(self) -> Removed:
        """Who was taken out since this was last asked."""
        ...

    def overlaps(self) -> Overlaps:
        """The deepest of all steps since this was last asked, the first time since t = 0; at a sync
        point, alike on every rank (collective under MPI)."""
        ...

    def crossings(self) -> Crossings:
        """Particles that went through the surface, looked for in every step; alike on every rank,
        and known there without asking the others."""
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


class Predicting(Protocol):
    """Particles that foretell their load, built from a plan that asks for it."""

    def contact_tangent(self, length_s: float) -> ContactTangent:
        """Over the next interval of ``length_s``; at a sync point, alike on every rank (collective
        under MPI).  Changes nothing."""
        ...


@runtime_checkable
class Scheduled(Protocol):
    """Frames that move some of their points by a schedule, which no reaction changes: a drive."""

    def ahead(self, interval: Interval) -> Known | None:
        """Where those points are at the interval's end, exactly; changes nothing.  None where
        nothing is driven: what stands still needs no schedule."""
        ...


@runtime_checkable
class Following(Protocol):
    """A panel with surface points that its clamps alone move, whatever loads them."""

    def ahead(self, interval: Interval, clamps: Known) -> Known:
        """Where those of them are at the interval's end whose clamps are known; what ``advance``
        with such clamps will say of them.  Changes nothing."""
        ...


@runtime_checkable
class Inert(Protocol):
    """A panel that tells the masses behind its surface points."""

    def inertia(self) -> Inertia: ...


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
