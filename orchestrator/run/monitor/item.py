"""What an item of the monitor is, and what it is shown."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

from orchestrator.case.tables.case import Case
from orchestrator.coupling.machine import Machine
from orchestrator.coupling.schemes.scheme import State
from orchestrator.ports import Saved
from orchestrator.ports.particle_records import Bed
from orchestrator.run.monitor.interface_work import InterfaceData, Works


class Observation(NamedTuple):
    """A value that an item observed, and where it did, for the message."""

    value: float
    where: str = ""


@dataclass(frozen=True)
class Subject:
    """The run that is monitored: its case, its open solvers, its first state, and the energy that
    went through its interfaces so far."""

    case: Case
    machine: Machine
    start: State
    works: Works


class OutputTime(NamedTuple):
    """An output time: the state, the terms of the energy ledger, and the bed (None without particles)."""

    state: State
    terms_J: dict[str, float]
    bed: Bed | None


class MonitorItem:
    """One quantity that the monitor observes; the base of all items.

    An item observes some sync intervals apart (``observe``), at output times (``observe_output``), or
    both.  It reports how large the quantity is; the monitor compares that with the limit of the case,
    and warns, shortens the sync intervals or stops the run.  All methods are called on the first rank.
    """

    name: ClassVar[str]
    """The key of ``[monitor]`` (or of ``[monitor.items]``) that says what to do beyond the limit."""
    limit_key: ClassVar[str] = ""
    """The key of ``[monitor]`` that has the limit; empty for items of ``[monitor.items]``."""
    message: ClassVar[str]
    """What is said beyond the limit, with places for ``{value}`` and ``{where}``."""

    def __init__(self, subject: Subject) -> None:
        self.subject = subject

    def add_interval(self, data: InterfaceData) -> None:
        """Take in what crossed the interfaces in one interval; called for each, in their order."""

    def observe(self) -> Iterable[Observation]:
        """Return what is to be judged now: five sync intervals after the last time at most."""
        return ()

    def observe_output(self, output: OutputTime) -> Iterable[Observation]:
        """Return what is to be judged at an output time."""
        return ()

    def begin_anew(self) -> None:
        """Is called when intervals are of another length from now on."""

    def save(self) -> Saved:
        """Return all that the item remembers, for a checkpoint."""
        return {}

    def restore(self, saved: Saved) -> None:
        """Take back what ``save`` returned."""
