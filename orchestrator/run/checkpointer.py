"""The checkpoints of a run: when they are due, and the state that decides how the run goes on."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from orchestrator.case.bed.grains import material_numbers
from orchestrator.case.bed.saved_bed import from_snapshot
from orchestrator.case.tables.carried_bed import CarriedBed
from orchestrator.case.tables.case import Case
from orchestrator.case.tables.numerics import CheckpointSettings
from orchestrator.coupling.machine import Machine
from orchestrator.coupling.mpi import first_rank_does
from orchestrator.coupling.schemes.scheme import State
from orchestrator.output import checkpoints
from orchestrator.output.checkpoints import Checkpoint
from orchestrator.output.records.recorder import Recorder
from orchestrator.output.records.run_folder import HISTORY
from orchestrator.ports import Restorable, Saved
from orchestrator.ports.clock import exact, steps_in
from orchestrator.ports.state import as_arrays, like
from orchestrator.run.monitor.monitor import Monitor


class Schedule:
    """The schedule of checkpoints, by the simulated time or by the wall clock of the first rank."""

    def __init__(self, settings: CheckpointSettings, interval_s: float, world: Any) -> None:
        self._every = steps_in(settings.every_s, interval_s) if settings.every_s else 0
        self._wall_s, self._world = 60.0 * settings.wall_min, world
        self._last_s = time.monotonic()

    def is_due(self, done: int) -> bool:
        """Return whether a checkpoint is due after ``done`` sync intervals; all ranks get the same answer."""
        if self._every and done % self._every == 0:
            return True
        return self._wall_s > 0 and first_rank_does(
            self._world, lambda: time.monotonic() - self._last_s >= self._wall_s
        )

    def note_checkpoint(self) -> None:
        """Note that a checkpoint has been written now."""
        self._last_s = time.monotonic()


class Checkpointer:
    """The writer of a run's checkpoints, which also restores a run from one of them.

    ``about`` returns the description of the run at the moment of the call, for ``checkpoint.json``.
    """

    def __init__(
        self,
        folder: Path,
        case: Case,
        machine: Machine,
        recorder: Recorder,
        monitor: Monitor,
        about: Callable[[], dict[str, Any]],
        world: Any,
    ) -> None:
        self._folder, self._monitor, self._about, self._world = folder, monitor, about, world
        self._case, self._particles = case, machine.solvers.particles
        self._members: dict[str, Restorable] = {**machine.members.by_name()}
        parts = {"material": machine.material, "scheme": machine.scheme.memory}
        self._parts: dict[str, Restorable] = {name: part for name, part in parts.items() if part is not None}
        self._parts |= {"recorder": recorder, "monitor": monitor}
        self._last = self._good = -1

    def save(self, state: State, done: int) -> None:
        """Write a checkpoint after ``done`` sync intervals, unless it is written already.

        The last checkpoint at which the monitor trusted the run is kept.  Raises OSError.
        """
        if done == self._last:
            return
        if self._monitor.pace.trusted:
            self._good = done
        about = self._about() | {"sync_points": done, "good": self._good}
        copies, bed = [self._folder / HISTORY], self._bed(done)
        checkpoints.write(self._folder, self._state(state), copies, about, self._world, bed)
        self._last = done

    def _bed(self, done: int) -> CarriedBed | None:
        """Return the particles of all ranks, on the first rank; None in a case without particles."""
        if self._particles is None:
            return None
        time_s = float(done * exact(self._case.coupling.sync_interval_s))
        coarse_graining = self._case.particles.coarse_graining
        return from_snapshot(
            self._particles.snapshot(), material_numbers(self._case), time_s, coarse_graining
        )

    def _state(self, state: State) -> Saved:
        """Return the state of this rank that decides how the run goes on."""
        members = {name: member.save() for name, member in self._members.items()}
        saved = {"members": members, "coupling": as_arrays(state)}
        return saved | {name: part.save() for name, part in self._parts.items()}

    def restore(self, checkpoint: Checkpoint, start: State) -> State:
        """Restore a machine that was opened in the state ``start``, and return the checkpoint's state.

        Raises ValueError if this run saves other arrays than the checkpoint has.
        """
        saved = checkpoint.state(self._world)
        for name, member in self._members.items():
            member.restore(saved["members"][name])
        for name, part in self._parts.items():
            part.restore(saved[name])
        self._last, self._good = checkpoint.sync_points, checkpoint.good
        state: State = like(start, saved["coupling"])
        # the monitor may have other items now: they do not decide how the run goes on
        then, now = (checkpoints.array_names(each | {"monitor": {}}) for each in (saved, self._state(state)))
        if differing := sorted(then ^ now):
            raise ValueError(f"only one of them has the arrays {', '.join(differing)}")
        return state
