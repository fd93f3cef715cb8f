"""The monitor, which runs each interval as finely as needed, observes it, and reacts as the case says."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

from rich.console import Console

from orchestrator.case.file.errors import CaseError
from orchestrator.case.tables.case import Case
from orchestrator.case.tables.numerics import Then
from orchestrator.coupling.machine import Machine
from orchestrator.coupling.mpi import first_rank_does, is_first
from orchestrator.coupling.schemes.scheme import State
from orchestrator.output.cycles import cycle_s, is_driven
from orchestrator.ports import InterfaceData, Saved
from orchestrator.ports.clock import Interval, steps_in
from orchestrator.ports.particle_records import BedSnapshot, Overlaps
from orchestrator.ports.plans import SolverFailed
from orchestrator.ports.state import SavedAttributes, as_arrays, like, restore_attributes, save_attributes
from orchestrator.run.monitor.interface_work import exchanged_J, interface_data, interface_works
from orchestrator.run.monitor.item import Books, MonitorItem, Observation, Subject
from orchestrator.run.monitor.items import (
    ItemLimit,
    all_items,
    item_limit,
    lengths,
    square_sum,
    unknown_items,
)
from orchestrator.run.monitor.pace import Pace

LOG = logging.getLogger("flipflow")
MOST_PARTS = 64
TOGETHER = 5  # intervals judged together while all is well, which costs little more than judging one
CALM_WITHOUT_CYCLE = 100  # intervals, five times those over which created energy is summed
SURFACES_EVERY_S, BOOKS_EVERY_S = 1e-3, 5e-3  # a panel moves by millimetres in a millisecond
WEIGHT: tuple[Then, ...] = ("stop", "shorten", "warn")
FASTEST_M_PER_S = 300.0  # nothing on a screen moves at the speed of sound in air


class Stopped(SolverFailed):
    """A decision of the monitor to stop the run at a sync point; ``state`` is the state at this point."""

    def __init__(self, what: str, state: State) -> None:
        super().__init__(f"stopped by the monitor at {what}")
        self.state = state


class Alarm(NamedTuple):
    """An observation beyond its limit: the reaction, the message, and whether it is the item's first."""

    then: Then
    what: str
    new: bool


class LimitedItem(SavedAttributes):
    """An item with its limit, its largest value, how often it was beyond the limit, and when it first was."""

    STATE = ("_worst", "_times", "_first_s")
    PARTS = ("item",)

    def __init__(self, item: MonitorItem, limit: ItemLimit) -> None:
        self.item, self._limit = item, limit
        self._worst, self._times, self._first_s = 0.0, 0, 0.0

    def judge(self, observations: Iterable[Observation], time_s: float) -> list[Alarm]:
        """Record the observations, and return an alarm for each observation beyond the limit."""
        then, limit, given = self._limit
        alarms = []
        for value, where in observations:
            self._worst = max(self._worst, value)
            if value > limit:
                self._times += 1
                if self._times == 1:
                    self._first_s = time_s
                message = self.item.message.format(value=value, where=where)
                what = f"t = {time_s:.6g} s: {message} ({given})"
                alarms.append(Alarm(then, what, self._times == 1))
        return alarms

    def as_json(self) -> dict[str, Any]:
        """Return the table of the item for ``summary.json``."""
        first_s = self._first_s if self._times else None
        return {"worst": self._worst, "limit": self._limit.limit, "times": self._times, "first_s": first_s}


class Monitor:
    """The monitor of a run, on every rank; the first rank observes and decides for all.

    Raises CaseError for a table ``[monitor.items.<name>]`` whose item does not exist.
    """

    def __init__(self, case: Case, machine: Machine, start: State, world: Any, console: Console) -> None:
        if problems := unknown_items(case):
            raise CaseError(problems)
        self._machine, self._world, self._console = machine, world, console
        self._interval_s = case.coupling.sync_interval_s
        self.pace = Pace(self._interval_s, MOST_PARTS, calm_intervals(case))
        self._works = interface_works(case, machine, start)
        subject = Subject(case, machine, start, self._works)
        self._items = {
            name: LimitedItem(kind(subject), limit)
            for name, kind in all_items().items()
            if (limit := item_limit(case.monitor, kind)) is not None
        }
        every = self._items.values()
        self._adding = [one for one in every if one.item.has_own("add_intervals")]
        self._observing = [one for one in every if one.item.has_own("observe")]
        self._of_surfaces = [one for one in every if one.item.has_own("observe_surface")]
        self._of_books = [one for one in every if one.item.has_own("observe_books")]
        self._surfaces_every = max(1, round(SURFACES_EVERY_S / self._interval_s))
        self._books_every = max(1, round(BOOKS_EVERY_S / self._interval_s))
        self._alarms: list[Alarm] = []
        self._pending: list[InterfaceData] = []
        self._judged, self._deepest = 0, Overlaps()
        self._warned_of_shortest = False

    def advance(self, interval: Interval, state: State) -> tuple[State, State]:
        """Return the state after a sync interval, and the state to record (``Pace.advance``)."""
        machine = self._machine
        with machine.stopwatch("coupling"):  # the stopwatch counts the members' time elsewhere
            return self.pace.advance(machine.scheme, machine.solvers, interval, state, self._note)

    def wants_books(self, done: int) -> bool:
        """Return whether the books are to be observed after ``done`` sync intervals, whatever the output."""
        return done % self._books_every == 0

    def note_books(
        self, done: int, time_s: float, state: State, terms_J: dict[str, float], bed: BedSnapshot | None
    ) -> None:
        """Note the books, and observe them where that is due.  ``terms_J`` are the ledger's terms."""
        if not is_first(self._world):
            return
        if bed is not None:
            self._deepest = self._deepest.deepest(bed.overlaps)
        if not self.wants_books(done):
            return
        with self._machine.stopwatch("monitor"):
            self._add_pending()
            if bed is not None:
                bed, self._deepest = BedSnapshot(bed.particles, self._deepest), Overlaps()
            for limited in self._of_books:
                books = Books(state, terms_J, bed)
                self._alarms += limited.judge(limited.item.observe_books(books), time_s)

    def observe_surface(self, done: int, time_s: float, state: State) -> None:
        """Observe the surface after ``done`` sync intervals where that is due."""
        if done % self._surfaces_every == 0 and is_first(self._world):
            with self._machine.stopwatch("monitor"):
                for limited in self._of_surfaces:
                    self._alarms += limited.judge(limited.item.observe_surface(state), time_s)

    def _is_due(self, done: int) -> bool:
        """Return whether what was observed is judged after ``done`` sync intervals; the same on all ranks.

        While all is well, that is at fixed multiples of the sync interval, so that neither the output nor
        the end of a run changes how it goes on.
        """
        every = (TOGETHER, self._surfaces_every, self._books_every)
        return not self.pace.trusted or any(done % each == 0 for each in every)

    def act(self, interval: Interval, state: State) -> None:
        """Warn after a sync interval, or shorten the next ones, as the case says.  Raises Stopped."""
        done = interval.index + 1
        if not self._is_due(done):
            return
        since, self._judged = done - self._judged, done
        time_s = interval.end_s
        then, what = first_rank_does(self._world, lambda: self._verdict(time_s))
        if then == "stop":
            self.pace.trusted = False
            raise Stopped(what, state)
        if then == "shorten":
            self._shorten(what)
        elif self.pace.ease(since):
            self._begin_anew(f"t = {time_s:.6g} s: nothing was amiss for a while")

    def figures(self, intervals: int) -> dict[str, Any]:
        """Return the monitor's table for ``summary.json``, after a number of sync intervals."""
        return {
            "shortened_intervals": self.pace.divided,
            "shortened_share": self.pace.divided / intervals if intervals else 0.0,
            "shortest_interval_s": self._interval_s / self.pace.finest,
            "figures": {name: limited.as_json() for name, limited in self._items.items()},
        }

    def exchanged_J(self) -> dict[str, float]:
        """Return the energy that went through each interface since t = 0; valid on the first rank.

        An interface whose exchange is turned off has no entry.
        """
        self._catch_up()
        return exchanged_J(self._works)

    def save(self) -> Saved:
        """Return the monitor's memory for a checkpoint."""
        self._catch_up()
        items = {name: limited.save() for name, limited in self._items.items()}
        works = {name: work.save() for name, work in self._works.items()}
        books = {"pace": self.pace.save(), "work": works, "items": items}
        return books | save_attributes(self, "_judged") | {"deepest": as_arrays(self._deepest)}

    def restore(self, saved: Saved) -> None:
        """Restore the memory that ``save`` returned; an item that the case did not have then begins now."""
        self.pace.restore(saved["pace"])
        for name, work in self._works.items():
            work.restore(saved["work"][name])
        for name, limited in self._items.items():
            if name in saved["items"]:
                limited.restore(saved["items"][name])
        restore_attributes(self, saved, "_judged")
        self._deepest = like(Overlaps(), saved["deepest"])

    def _note(self, part: Interval) -> None:
        if is_first(self._world):
            self._pending.append(interface_data(self._machine.members, part.length_s))

    def _catch_up(self) -> None:
        with self._machine.stopwatch("monitor"):
            self._add_pending()

    def _add_pending(self) -> None:
        pending, self._pending = self._pending, []
        if pending:
            for work in self._works.values():
                work.add(pending)
            for limited in self._adding:
                limited.item.add_intervals(pending)

    def _verdict(self, time_s: float) -> tuple[Then, str]:
        self._catch_up()
        for limited in self._observing:
            self._alarms += limited.judge(limited.item.observe(), time_s)
        alarms, self._alarms = self._alarms, []
        for alarm in alarms:
            if alarm.new:
                self._warn(alarm.what)
        if not alarms:
            return "warn", ""
        gravest = min(alarms, key=lambda alarm: WEIGHT.index(alarm.then))
        return gravest.then, gravest.what

    def _shorten(self, what: str) -> None:
        if self.pace.shorten():
            self._begin_anew(what)
        elif not self._warned_of_shortest:
            self._warned_of_shortest = True
            self._warn(f"{what}: the sync intervals cannot be shortened any further")

    def _begin_anew(self, why: str) -> None:
        """Tell all works and items that the next intervals have another length."""
        for work in self._works.values():
            work.begin_anew()
        for limited in self._items.values():
            limited.item.begin_anew()
        if is_first(self._world):
            LOG.info("%s: sync intervals of %g s from here on", why, self._interval_s / self.pace.parts)

    def _warn(self, what: str) -> None:
        LOG.warning(what)
        self._console.print(f"warning: {what}")


def check_speeds(state: State, time_s: float, advice: Callable[[], str]) -> None:
    """Raise SolverFailed, with the advice at its end, if a point of the surface or of a frame is
    faster than ``FASTEST_M_PER_S``."""
    for member, motion in (("frames", state.clamps), ("panel", state.panel.surface)):
        if square_sum(motion.velocity_m_per_s) < FASTEST_M_PER_S**2:  # of all, and the quickest test
            continue
        fastest_m_per_s = float(lengths(motion.velocity_m_per_s).max(initial=0.0))
        if fastest_m_per_s > FASTEST_M_PER_S:
            raise SolverFailed(
                f"{member} became unstable at t = {time_s:.6g} s: a point moves at "
                f"{fastest_m_per_s:.3g} m/s (limit {FASTEST_M_PER_S:g} m/s). {advice()}"
            )


def calm_intervals(case: Case) -> int:
    """Return how many sync intervals without trouble count as calm: ``monitor.calm_s``, or else a cycle.

    Trouble in one phase of the machine's cycle comes back in the next cycle.
    """
    if not (case.monitor.calm_s or is_driven(case)):
        return CALM_WITHOUT_CYCLE
    return steps_in(case.monitor.calm_s or cycle_s(case), case.coupling.sync_interval_s)
