"""One run, from a loaded case to a finished run folder: the coupling loop and its books."""

from __future__ import annotations

import logging
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from resource import RUSAGE_SELF, getrusage
from typing import Any

from rich.console import Console

from orchestrator.bed.particle_step import particle_step_s
from orchestrator.build import build
from orchestrator.casefile.levels import LoadedCase
from orchestrator.casefile.slice import share
from orchestrator.children import python
from orchestrator.clock import Interval, exact, intervals, steps_in
from orchestrator.coupling import State, initial
from orchestrator.ledger import Ledger
from orchestrator.machine import Machine
from orchestrator.metered import named
from orchestrator.records import summary
from orchestrator.records.recorder import Recorder
from orchestrator.records.run_folder import LOG, write_json
from orchestrator.results.compute import results
from orchestrator.results.seen import checked
from orchestrator.results.store import store
from orchestrator.scene.account import Entry, at_end
from orchestrator.stability import words
from orchestrator.stability.bound import Card
from orchestrator.stopwatch import Stopwatch
from orchestrator.watch import Interrupted, Say, Stop, check_stable


class Run:
    """A coupled run in its folder; every rank of ``world`` (MPI communicator or None) has one."""

    def __init__(
        self,
        loaded: LoadedCase,
        effects: Mapping[str, Entry],
        stability: Card,
        folder: Path,
        world: Any,
        console: Console,
    ) -> None:
        self._loaded, self._folder, self._world, self._console = loaded, folder, world, console
        self._effects, self._stability = effects, stability
        self._case = loaded.case
        self._stopwatch = Stopwatch()
        self._started = time.perf_counter()
        self._interval_s = self._case.coupling.sync_interval_s
        self._intervals = steps_in(self._case.duration_s, self._interval_s)
        self._every = steps_in(self._case.output.interval_s, self._interval_s)
        self._steps = steps_in(self._interval_s, particle_step_s(self._case))
        self._particle_steps = 0
        self._done: dict[str, Any] = {"sync_intervals": 0, "simulated_s": 0.0, "particles": 0}

    def go(self) -> None:
        """Runs to the end.  Raises CaseError or SolverMissing before anything is computed;
        SolverFailed, OSError or Interrupted with everything written up to the last output time.
        """
        self._console.print("opening the solvers")
        with self._stopwatch("rest"), Stop().listening() as stop:
            machine = build(self._loaded, self._folder, self._world, self._stopwatch)
            LOG.info("all solvers are open after %.1f s", time.perf_counter() - self._started)
            try:
                self._coupled(machine, stop)
            finally:
                machine.close()

    def _coupled(self, machine: Machine, stop: Stop) -> None:
        state = initial(machine.solvers)
        ledger = Ledger(machine.members, machine.scheme.pending(state, self._interval(0)))
        with written(0.0):
            recorder = Recorder(self._folder, machine, ledger, state, self._case, self._world)
        interrupted = None
        try:
            self._record(recorder, state, 0)
            state = self._loop(machine, recorder, state, stop)
        except Interrupted as stopped:
            interrupted, state = stopped, stopped.state
        finally:
            recorder.close()
        pending = machine.scheme.pending(state, self._interval(0))
        residuals = ledger.momentum_residual(pending)
        self._done["momentum_residual_relative"] = max(residuals.values())
        self._done["momentum_residuals"] = residuals
        self._done["energy_ledger_J"] = ledger.energy_J()
        if interrupted:
            raise interrupted

    def _loop(self, machine: Machine, recorder: Recorder, state: State, stop: Stop) -> State:
        with Say(self._intervals, self._interval_s, self._console) as say:
            for interval in intervals(self._case.duration_s, self._interval_s):
                with named("the coupling", interval):
                    state = machine.scheme.advance(machine.solvers, interval, state)
                check_stable(state, interval.end_s)
                self._record(recorder, state, interval.index + 1)
                say.done(interval.index + 1)
                stop.check(self._world, state)
        return state

    def _record(self, recorder: Recorder, state: State, done: int) -> None:
        """Sync point ``done``; an output time every ``_every`` of them, and the last."""
        time_s = float(done * exact(self._interval_s))
        with self._stopwatch("output"), written(time_s):
            recorder.sync_point(done, time_s, state)
            if done % self._every == 0 or done == self._intervals:
                try:
                    self._done["particles"] = recorder.output(time_s, state)
                finally:  # also when it is the material that stops the run
                    self._done["material"] = recorder.material()
        if done:
            self._particle_steps += self._steps * self._done["particles"]
        self._done |= {"sync_intervals": done, "simulated_s": time_s}

    def _interval(self, index: int) -> Interval:
        return Interval(index, self._interval_s)

    def finish(self, status: str, reason: str = "") -> dict[str, Any]:
        """Writes ``summary.json`` and the pictures (call it on one rank); returns the summary.

        ``status``: "done", "interrupted" or "failed", with the ``reason``.
        """
        wall_s = time.perf_counter() - self._started
        by_part = summary.wall_by_part_s(self._stopwatch.wall_s, wall_s)
        rate = self._particle_steps / by_part["particles"] if by_part["particles"] else 0.0
        figures = {
            "status": status,
            "reason": reason,
            "case": self._loaded.name,
            "level": self._loaded.level,
            "left_out": self._loaded.left_out,
            "effects": {name: one.figures() for name, one in self._effects.items()},
            "share_of_width": share(self._case.whole),
            "cycle_s": summary.cycle_s(self._case),
            "stability": words.figures(self._stability),
            "wall_s": wall_s,
            "processor_s": time.process_time(),
            "peak_memory_MiB": getrusage(RUSAGE_SELF).ru_maxrss / 1024,
            "wall_by_part_s": by_part,
            "particle_steps_per_s": rate,
            **self._done,
        }
        if figures["sync_intervals"]:
            figures["probes"] = summary.probes(self._folder / "history.h5", figures["cycle_s"])
        write_json(self._folder / "summary.json", figures)
        if figures["sync_intervals"]:
            self._add_results(figures)
        if self._case.output.pictures and figures["sync_intervals"]:
            draw(self._folder)
        return figures

    def _check_effects(self, figures: dict[str, Any]) -> None:
        """What was judged before the run, by what it recorded."""
        after = checked(self._effects, self._loaded.described, self._folder, figures["results"])
        figures["effects"] = {name: one.figures() for name, one in after.items()}
        write_json(self._folder / "summary.json", figures)
        for line in at_end(after):
            LOG.log(logging.WARNING if line.startswith("WARNING") else logging.INFO, line)
            self._console.print(line)

    def _add_results(self, figures: dict[str, Any]) -> None:
        """To ``summary.json`` and ``history.h5``.  A mistake in them loses nothing else."""
        try:
            figures["results"] = results(self._folder)
            write_json(self._folder / "summary.json", figures)
            store(self._folder / "history.h5", figures["results"])
            self._check_effects(figures)
        except OSError:
            raise
        except Exception as error:
            LOG.exception("no results: %s", error)


@contextmanager
def written(time_s: float) -> Iterator[None]:
    """An error of the disk inside says when it came."""
    try:
        yield
    except OSError as error:
        raise OSError(f"the results at t = {time_s:.6g} s cannot be written: {error}") from error


def draw(folder: Path) -> None:
    """Pictures in a process of their own; one that fails is a warning in the log."""
    drawn = python("-m", "orchestrator.records.pictures", str(folder), capture_output=True)
    if drawn.returncode:
        LOG.warning("no pictures: %s", drawn.stderr.strip().splitlines()[-1:])
