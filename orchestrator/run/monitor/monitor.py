"""The watch: runs each interval as finely as needed, looks at it, and does what the case wants."""

from __future__ import annotations

import logging
from typing import Any

from rich.console import Console

from orchestrator.case.bed.particle_step import particle_step_s
from orchestrator.case.tables.case import Case
from orchestrator.case.tables.numerics import Then
from orchestrator.coupling.ledger import created_shares
from orchestrator.coupling.machine import Machine
from orchestrator.coupling.ranks import first_rank_does, is_first
from orchestrator.coupling.schemes.exchange import State
from orchestrator.output.cycles import cycle_s
from orchestrator.ports import Saved
from orchestrator.ports.clock import Interval, steps_in
from orchestrator.ports.particle_records import Bed, Crossings
from orchestrator.ports.plans import SolverFailed
from orchestrator.ports.state import put_back, taken
from orchestrator.run.monitor.coupling_watch import CouplingWatch
from orchestrator.run.monitor.interface_data import Crossed, crossed
from orchestrator.run.monitor.limits import Figures
from orchestrator.run.monitor.output_watch import OutputWatch
from orchestrator.run.monitor.pace import Pace

LOG = logging.getLogger("flipflow")
MOST_PARTS = 64
TOGETHER = 5  # intervals are looked at, which costs little more than one, while all is well
WEIGHT: tuple[Then, ...] = ("stop", "shorten", "warn")


class Stopped(SolverFailed):
    """The watch stops the run, at a sync point with the ``state`` there."""

    def __init__(self, what: str, state: State) -> None:
        super().__init__(f"stopped by the watch at {what}")
        self.state = state


class Monitor:
    """On every rank; the first one looks and decides for all."""

    def __init__(self, case: Case, machine: Machine, start: State, world: Any, console: Console) -> None:
        self._machine, self._world, self._console = machine, world, console
        self._interval_s = case.coupling.sync_interval_s
        self.pace = Pace(self._interval_s, MOST_PARTS, calm_intervals(case))
        self._figures = Figures(case.monitor)
        self._coupling = CouplingWatch(case, machine, start)
        self._output = OutputWatch(machine.panels, machine.penetrations, particle_step_s(case))
        self._crossed: list[Crossed] = []
        self._judged, self._at_once = 0, False
        self._said_shortest = False

    def advance(self, interval: Interval, state: State) -> tuple[State, State]:
        """The state after a sync interval, to go on from and to be recorded."""
        machine = self._machine
        with machine.stopwatch("coupling"):  # what the members take is not counted there
            return self.pace.advance(machine.scheme, machine.solvers, interval, state, self._look)

    def output(self, time_s: float, state: State, terms_J: dict[str, float], bed: Bed | None) -> None:
        """At output times, after which everything is judged; ``terms_J`` of the ledger."""
        self._at_once = True
        if is_first(self._world):
            with self._machine.stopwatch("monitor"):
                self._add_crossed()
                for interface, share in created_shares(terms_J, self._coupling.exchanged_J()).items():
                    self._figures.look("created_in_total", abs(share), time_s, interface)
                self._output.look(self._figures, time_s, state, bed)

    def act(self, interval: Interval, state: State) -> None:
        """After a sync interval: warns or shortens the next ones, as the case wants.  Raises
        Stopped."""
        done = interval.index + 1
        if self.pace.trusted and not self._at_once and done - self._judged < TOGETHER:
            return
        since, self._judged, self._at_once = done - self._judged, done, False
        time_s = interval.end_s
        then, what = first_rank_does(self._world, lambda: self._verdict(time_s))
        if then == "stop":
            self.pace.trusted = False
            raise Stopped(what, state)
        if then == "shorten":
            self._shorten(time_s, what)
        elif self.pace.ease(since):
            self._changed(f"t = {time_s:.6g} s: nothing was amiss for a while")

    def figures(self, intervals: int) -> dict[str, Any]:
        """For ``summary.json``, after so many sync intervals."""
        return {
            "shortened_intervals": self.pace.divided,
            "shortened_share": self.pace.divided / intervals if intervals else 0.0,
            "shortest_interval_s": self._interval_s / self.pace.finest,
            "figures": self._figures.as_json(),
        }

    def exchanged_J(self) -> dict[str, float]:
        """Energy that went through each interface since t = 0; where its hand-over is turned off,
        it has none.  The first rank knows."""
        self._catch_up()
        return self._coupling.exchanged_J()

    def save(self) -> Saved:
        self._catch_up()
        saved = {"pace": self.pace.save(), "figures": self._figures.save()}
        return saved | {"coupling": self._coupling.save()} | taken(self, "_judged", "_at_once")

    def restore(self, saved: Saved) -> None:
        self.pace.restore(saved["pace"])
        self._figures.restore(saved["figures"])
        self._coupling.restore(saved["coupling"])
        put_back(self, saved, "_judged", "_at_once")

    def _look(self, part: Interval) -> None:
        if is_first(self._world):
            self._crossed.append(crossed(self._machine.members, part.length_s))

    def _catch_up(self) -> None:
        with self._machine.stopwatch("monitor"):
            self._add_crossed()

    def _add_crossed(self) -> None:
        for interval in self._crossed:
            self._coupling.add(interval)
        self._crossed.clear()

    def _verdict(self, time_s: float) -> tuple[Then, str]:
        """What is to be done, and why."""
        self._catch_up()
        self._coupling.look(self._figures, time_s)
        self._look_at_crossings(time_s)
        alarms = self._figures.alarms()
        for alarm in alarms:
            if alarm.new:
                self._say(alarm.what)
        for alarm in sorted(alarms, key=lambda alarm: WEIGHT.index(alarm.then)):
            return alarm.then, alarm.what
        return "warn", ""

    def _look_at_crossings(self, time_s: float) -> None:
        particles = self._machine.solvers.particles
        found = particles.crossings() if particles is not None else Crossings.none()
        if found.number:
            self._figures.look("crossed_surface", found.number, time_s, found.first_in_words())

    def _shorten(self, time_s: float, what: str) -> None:
        if self.pace.shorten():
            self._changed(what)
        elif not self._said_shortest:
            self._said_shortest = True
            self._say(f"{what}: the sync intervals cannot be shortened any further")

    def _changed(self, why: str) -> None:
        """The length of what the coupling is looked at by is another from now on."""
        self._coupling.begin_anew()
        parts = self.pace.parts
        if is_first(self._world):
            LOG.info("%s: sync intervals of %g s from here on", why, self._interval_s / parts)

    def _say(self, what: str) -> None:
        LOG.warning(what)
        self._console.print(f"warning: {what}")


def calm_intervals(case: Case) -> int:
    """Sync intervals of a cycle of the machine, if the case says nothing else: what was amiss comes
    back with it."""
    return steps_in(case.monitor.calm_s or cycle_s(case), case.coupling.sync_interval_s)
