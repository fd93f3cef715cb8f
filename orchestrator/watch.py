"""The watch on a run: interruption, instability, progress with time left."""

from __future__ import annotations

import logging
import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

import numpy as np
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from orchestrator.coupling import State
from orchestrator.plans import SolverFailed

LOG = logging.getLogger("flipflow")
FASTEST_M_S = 300.0  # nothing on a screen moves at the speed of sound in air
SAY_EVERY_S = 5.0
# the last is what mpirun passes on without killing a second later, and what batch systems can send
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGUSR1)


class Interrupted(Exception):
    """The user asked to stop; raised at a sync point, with the ``state`` there."""

    def __init__(self, number: int, state: State) -> None:
        super().__init__(f"stopped by {signal.Signals(number).name}")
        self.signal, self.state = number, state


class Stop:
    """Remembers ``SIGNALS`` until the next sync point; the second one does not wait."""

    def __init__(self) -> None:
        self.signal: int | None = None

    @contextmanager
    def listening(self) -> Iterator[Stop]:
        before = {name: signal.signal(name, self._heard) for name in SIGNALS}
        try:
            yield self
        finally:
            for name, handler in before.items():
                signal.signal(name, handler)

    def _heard(self, number: int, _: FrameType | None) -> None:
        if self.signal is not None:  # asked twice: at once
            raise KeyboardInterrupt
        self.signal = number

    def check(self, world: Any, state: State) -> None:
        """Raises Interrupted on all ranks as soon as one of them heard a signal."""
        heard = self.signal
        if world is not None:
            heard = max(world.allgather(heard or 0)) or None
        if heard is not None:
            raise Interrupted(heard, state)


def check_stable(state: State, time_s: float) -> None:
    """Raises SolverFailed when a surface or frame point moves impossibly fast."""
    for member, motion in (("frames", state.clamps), ("panel", state.panel.surface)):
        fastest = float(np.abs(motion.velocity_m_s).max(initial=0.0))
        if fastest > FASTEST_M_S:
            raise SolverFailed(
                f"{member} became unstable at t = {time_s:.6g} s: a point moves at "
                f"{fastest:.3g} m/s (limit {FASTEST_M_S:g} m/s). "
                "A smaller coupling.sync_interval_s or solver step usually helps."
            )


class Say:
    """Progress with time left: a bar on a terminal, a line now and then elsewhere."""

    def __init__(self, first: int, intervals: int, interval_s: float, console: Console) -> None:
        """Of so many ``intervals``, the ``first`` were done before."""
        self._first, self._intervals, self._interval_s = first, intervals, interval_s
        self._bar = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            TextColumn("{task.percentage:>3.0f}%"),
            TimeRemainingColumn(),
            console=console,
            disable=not console.is_terminal,
        )
        self._console = console
        self._task = self._bar.add_task("simulating", total=intervals, completed=first)
        self._started = self._said = time.monotonic()

    def __enter__(self) -> Say:
        self._bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._bar.stop()

    def done(self, intervals: int) -> None:
        """``intervals`` of all are done."""
        self._bar.update(self._task, completed=intervals)
        now = time.monotonic()
        if now - self._said < SAY_EVERY_S:
            return
        self._said = now
        spent_s = now - self._started
        left_s = spent_s * (self._intervals - intervals) / (intervals - self._first)
        line = (
            f"t = {intervals * self._interval_s:.4f} of {self._intervals * self._interval_s:g} s, "
            f"{100 * intervals / self._intervals:.0f} %, {spent_s:.0f} s spent, "
            f"about {left_s:.0f} s left"
        )
        LOG.info(line)
        if not self._console.is_terminal:
            self._console.print(line, highlight=False)
