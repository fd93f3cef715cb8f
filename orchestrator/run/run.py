"""A run from a loaded case to a finished run folder: the coupling loop and its records."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import closing, contextmanager
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Any

from rich.console import Console

from orchestrator.case.solver_plans import particle_step_s
from orchestrator.coupling.build import build
from orchestrator.coupling.ledger import Ledger
from orchestrator.coupling.machine import Machine
from orchestrator.coupling.mpi import is_first
from orchestrator.coupling.schemes.scheme import State, initial_state
from orchestrator.figures.accuracy import Accuracy
from orchestrator.output.checkpoints import Checkpoint
from orchestrator.output.records.recorder import Recorder
from orchestrator.output.records.run_folder import LOG
from orchestrator.ports.clock import Interval, intervals, steps_in, times_s
from orchestrator.ports.failures import solver_failure_context, write_failure_context
from orchestrator.ports.plans import SolverFailed
from orchestrator.preflight.judge import JudgedCase
from orchestrator.preflight.judgement.account import Entry
from orchestrator.preflight.stability.report import StabilityReport, with_scheme
from orchestrator.run.checkpointer import Checkpointer, Schedule
from orchestrator.run.ending import Ending
from orchestrator.run.interruption import Interrupted, StopRequest
from orchestrator.run.monitor.monitor import Monitor, Stopped, check_speeds
from orchestrator.run.origin import origin
from orchestrator.run.progress import Progress, ProgressBar


class Run:
    """A coupled run in its folder; every rank of ``world`` (MPI communicator or None) has one.

    ``accuracy`` is what a stored study says about it.  With a ``checkpoint`` the run goes on from there, in
    the folder of the run that wrote it.
    """

    def __init__(
        self,
        loaded: JudgedCase,
        effects: Mapping[str, Entry],
        stability: StabilityReport,
        folder: Path,
        world: Any,
        console: Console,
        accuracy: Accuracy,
        checkpoint: Checkpoint | None = None,
    ) -> None:
        self._loaded, self._folder, self._world, self._console = loaded, folder, world, console
        self._case, self._stability, self.resumes = loaded.case, stability, checkpoint
        self._coupled_as = replace(loaded, case=with_scheme(loaded.case, stability.scheme))
        self._ending = Ending(loaded, effects, stability, folder, console, accuracy)
        self._progress = Progress()
        if checkpoint is not None:
            self._progress.restore(checkpoint.about["progress"])
        self._interval_s = self._case.coupling.sync_interval_s
        self._intervals = steps_in(self._case.duration_s, self._interval_s)
        self._every = steps_in(self._case.output.interval_s, self._interval_s)
        self._step_s = particle_step_s(self._case)
        self._schedule = Schedule(self._case.checkpoint, self._interval_s, world)

    def go(self) -> None:
        """Run to the end.

        Raises CaseError or SolverMissing before anything is computed, and SolverFailed, OSError or
        Interrupted after everything up to the last output time has been written.
        """
        self._console.print("opening the solvers")
        stopwatch = self._progress.stopwatch
        with stopwatch("rest"), StopRequest(waits=self._world is not None).listen() as stop:
            machine = build(self._coupled_as, self._folder, self._world, stopwatch)
            stop.waits = True
            LOG.info("all solvers are open after %.1f s", self._progress.wall_s)
            try:
                self._run_coupled(machine, stop)
            finally:
                machine.close()

    def _run_coupled(self, machine: Machine, stop: StopRequest) -> None:
        state = initial_state(machine.solvers)
        ledger = Ledger(machine.members, machine.scheme.pending(state, Interval(0, self._interval_s)))
        with write_failure_context("results", 0.0):
            resumed = self.resumes is not None
            recorder = Recorder(self._folder, machine, ledger, state, self._case, self._world, resumed)
        monitor = Monitor(self._case, machine, state, self._world, self._console)
        checkpointer = Checkpointer(
            self._folder, self._case, machine, recorder, monitor, self._about, self._world
        )
        interrupted: Interrupted | Stopped | None = None
        try:
            state = self._start(checkpointer, recorder, monitor, state)
            state = self._loop(machine, ledger, recorder, checkpointer, monitor, state, stop)
        except (Interrupted, Stopped) as stopped:
            interrupted, state = stopped, stopped.state
            self._save(checkpointer, state)
            recorder.book_last_contacts()
            self._progress.figures["material"] = recorder.material_balance()
        finally:
            with closing(recorder):
                self._progress.figures["monitor"] = monitor.figures(self._progress.done)
        pending = machine.scheme.pending(state, Interval(0, monitor.pace.last_s))
        self._progress.figures |= ledger.figures(pending) | {"iterations": machine.scheme.figures()}
        self._progress.figures["energy_exchanged_J"] = monitor.exchanged_J()
        if interrupted:
            raise interrupted

    def _start(self, checkpointer: Checkpointer, recorder: Recorder, monitor: Monitor, state: State) -> State:
        if self.resumes is None:
            self._record(recorder, monitor, state, state, 0, 0)
            return state
        try:
            return checkpointer.restore(self.resumes, state)
        except (KeyError, ValueError, RuntimeError) as error:
            then = self.resumes.about["provenance"]["commit"]
            raise SolverFailed(
                f"{self.resumes.folder} cannot be put back ({type(error).__name__}: {error}): it "
                f"was saved by another flipflow, of commit {then}; that one can go on with it"
            ) from error

    def _loop(
        self,
        machine: Machine,
        ledger: Ledger,
        recorder: Recorder,
        checkpointer: Checkpointer,
        monitor: Monitor,
        state: State,
        stop: StopRequest,
    ) -> State:
        first, felt = self._progress.done, int(machine.scheme.late)  # late loads come an interval later
        with ProgressBar(first, self._intervals, self._interval_s, self._console) as bar:
            for interval in intervals(self._case.duration_s, self._interval_s, first):
                runs, before = machine.particle_runs, state
                with self._add_advice(), solver_failure_context("the coupling", interval):
                    state, observed = monitor.advance(interval, state)
                    if interval.index == felt:
                        ledger.book_blow()
                check_speeds(observed, interval.end_s, self._stability.advice)
                steps = steps_in(monitor.pace.last_s, self._step_s) * (machine.particle_runs - runs)
                self._record(recorder, monitor, before, observed, interval.index + 1, steps)
                with self._add_advice():
                    monitor.act(interval, state)
                bar.update(interval.index + 1)
                stop.check(self._world, state)
                if self._schedule.is_due(interval.index + 1):
                    self._save(checkpointer, state)
        self._save(checkpointer, state)
        return state

    @contextmanager
    def _add_advice(self) -> Iterator[None]:
        """Add advice to a failure inside if the case lies beyond the limits that ensure stability."""
        try:
            yield
        except SolverFailed as error:
            if self._stability.is_unsafe:
                error.add_note(self._stability.advice())
            raise

    def _save(self, checkpointer: Checkpointer, state: State) -> None:
        time_s = self._progress.simulated_s
        with self._progress.stopwatch("checkpoints"), write_failure_context("checkpoint", time_s):
            checkpointer.save(state, self._progress.done)
        self._schedule.note_checkpoint()

    def _about(self) -> dict[str, Any]:
        """Return the origin and progress of the run for a checkpoint; only on the first rank."""
        if not is_first(self._world):
            return {}
        return self._origin | {"progress": self._progress.as_json()}

    @cached_property
    def _origin(self) -> dict[str, Any]:
        left_out = {name: self._ending.effects[name].figures() for name in self._loaded.left_out}
        return origin(self._loaded, self._folder, self._world) | {"left_out": left_out}

    def _record(
        self, recorder: Recorder, monitor: Monitor, before: State, state: State, done: int, steps: int
    ) -> None:
        """Record sync point ``done``, before which each particle took ``steps`` steps.

        ``before`` is the state at the sync point before it.  Every ``_every``-th sync point is an output
        time, and so is the last one.
        """
        time_s = times_s(done, self._interval_s)
        figures = self._progress.figures
        with self._progress.stopwatch("output"), write_failure_context("results", time_s):
            recorder.record_sync_point(done, time_s, state)
            is_output = done % self._every == 0 or done == self._intervals
            if is_output or monitor.wants_books(done):
                try:
                    terms_J, bed = recorder.book(time_s)
                finally:  # even if the material stops the run
                    figures["material"] = recorder.material_balance()
                figures["particles"] = len(bed.particles.id) if bed is not None else 0
                if is_output:
                    recorder.record_output(time_s, state, before, terms_J, bed)
                monitor.note_books(done, time_s, state, terms_J, bed)
            monitor.observe_surface(done, time_s, state)
        self._progress.count_sync_point(done, time_s, steps)

    @property
    def simulated_s(self) -> float:
        """The simulated time so far."""
        return self._progress.simulated_s

    def finish(self, status: str, reason: str = "") -> dict[str, Any]:
        """Write summary, results and pictures (``Ending.write``) on one rank, and return the summary."""
        return self._ending.write(self._progress, status, reason)
