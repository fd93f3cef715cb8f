"""The base class of the monitor's items, and the data that the monitor passes to them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

from orchestrator.case.tables.case import Case
from orchestrator.coupling.machine import Machine
from orchestrator.coupling.schemes.scheme import State
from orchestrator.ports import InterfaceData, Saved
from orchestrator.ports.particle_records import BedSnapshot
from orchestrator.run.monitor.interface_work import Works


class Observation(NamedTuple):
    """A value that an item observed, and its place for the message."""

    value: float
    where: str = ""


@dataclass(frozen=True)
class Subject:
    """The run that is monitored: its case, its open solvers, its first state, and the work at its
    interfaces so far."""

    case: Case
    machine: Machine
    start: State
    works: Works


class Books(NamedTuple):
    """The books at a sync point: the state, the terms of the energy ledger, and the bed (None without
    particles), whose overlaps are the deepest since the books before."""

    state: State
    terms_J: dict[str, float]
    bed: BedSnapshot | None


class MonitorItem:
    """A quantity that the monitor observes, and the base class of all items.

    An item observes every few sync intervals (``observe``), the surface every millisecond
    (``observe_surface``), or ledger and bed every five (``observe_books``).  These times do not depend on the
    output of the case.  The item reports the value of the quantity.  The monitor compares the value with the
    limit of the case, and warns, shortens the sync intervals or stops the run.  All methods are called on the
    first rank.
    """

    name: ClassVar[str]
    """The key of ``[monitor]`` (or of ``[monitor.items]``) that says what to do beyond the limit."""
    limit_key: ClassVar[str] = ""
    """The key of ``[monitor]`` that has the limit; empty for items of ``[monitor.items]`` and those with a
    ``fixed_limit``."""
    fixed_limit: ClassVar[float | None] = None
    """The limit of an item that every case has and none may change."""
    message: ClassVar[str]
    """The message about a value beyond the limit, with places for ``{value}`` and ``{where}``."""

    def __init__(self, subject: Subject) -> None:
        self.subject = subject

    def has_own(self, call: str) -> bool:
        """Return whether the item has its own version of a call of this class, so that it must be called."""
        return getattr(type(self), call) is not getattr(MonitorItem, call)

    def add_intervals(self, intervals: list[InterfaceData]) -> None:
        """Add the data that crossed the interfaces in the intervals since the last call, in order.

        How many intervals come at once must make no difference.
        """

    def observe(self) -> Iterable[Observation]:
        """Return the observations to judge now, at most five sync intervals after the last call."""
        return ()

    def observe_surface(self, state: State) -> Iterable[Observation]:
        """Return the observations to judge of the state at a sync point."""
        return ()

    def observe_books(self, books: Books) -> Iterable[Observation]:
        """Return the observations to judge of ledger and bed."""
        return ()

    def begin_anew(self) -> None:
        """Forget recent intervals: the next ones have another length."""

    def save(self) -> Saved:
        """Return the memory of the item for a checkpoint."""
        return {}

    def restore(self, saved: Saved) -> None:
        """Restore the memory that ``save`` returned."""
