"""Coupled machines for the tests of the whole chain: a case as text, opened, and run by hand."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from orchestrator.coupling.build import build
from orchestrator.coupling.ledger import Ledger
from orchestrator.coupling.machine import Machine
from orchestrator.coupling.metered import Stopwatch
from orchestrator.coupling.schemes import scheme as coupling
from orchestrator.coupling.schemes.scheme import State
from orchestrator.ports import ParticleSnapshot
from orchestrator.ports.clock import Interval
from orchestrator.preflight.judge import JudgedCase


@dataclass
class Coupled:
    """An open machine with its books, at a sync point."""

    machine: Machine
    interval_s: float
    state: State
    ledger: Ledger
    done: int = 0

    def advance(self, intervals: int) -> State:
        """The state ``intervals`` later."""
        for _ in range(intervals):
            self.state = self.machine.scheme.advance(self.machine.solvers, self._interval(), self.state)
            self.done += 1
        return self.state

    def _interval(self) -> Interval:
        return Interval(self.done, self.interval_s)

    def particles(self) -> ParticleSnapshot:
        assert self.machine.solvers.particles is not None
        return self.machine.solvers.particles.snapshot()

    def momentum_residual(self) -> dict[str, float]:
        return self.ledger.momentum_residual(self.machine.scheme.pending(self.state, self._interval()))

    def angular_momentum_residual(self) -> dict[str, float]:
        return self.ledger.angular_momentum_residual(
            self.machine.scheme.pending(self.state, self._interval())
        )

    def energy_J(self, book: str = "") -> dict[str, float]:
        """The ledger's terms, or those of one ``book`` ("stored", "lost", "created" ...)."""
        return {name: value for name, value in self.ledger.energy_J().items() if name.startswith(book)}


@contextmanager
def opened(loaded: JudgedCase) -> Iterator[Coupled]:
    """The machine of a case, before anything has moved."""
    machine = build(loaded, loaded.folder, None, Stopwatch())
    try:
        interval_s = loaded.case.coupling.sync_interval_s
        state = coupling.initial_state(machine.solvers)
        pending = machine.scheme.pending(state, Interval(0, interval_s))
        yield Coupled(machine, interval_s, state, Ledger(machine.members, pending))
    finally:
        machine.close()
