"""A run that is asked to stop: signals are heard, and heeded at the next sync point."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

from orchestrator.coupling.schemes.exchange import State

# SIGHUP comes when a terminal or a connection closes; SIGUSR1 is what mpirun passes on without
# killing a second later, and what batch systems can send
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGUSR1)


class Interrupted(Exception):
    """The user asked to stop; raised at a sync point, with the ``state`` there."""

    def __init__(self, number: int, state: State) -> None:
        super().__init__(f"stopped by {signal.Signals(number).name}")
        self.signal, self.state = number, state


class AtOnce(KeyboardInterrupt):
    """The user asked to stop, and nothing is waited for; the message says why not."""

    def __init__(self, number: int, why: str) -> None:
        super().__init__(why)
        self.signal = number


def told_at_once(error: BaseException | None) -> KeyboardInterrupt | None:
    """The signal that is behind this error and did not wait: libraries that it interrupts may raise
    another error on top of it."""
    while error is not None:
        if isinstance(error, KeyboardInterrupt):
            return error
        error = error.__cause__ or error.__context__
    return None


class Stop:
    """Remembers ``SIGNALS`` until the next sync point; the second one does not wait, nor does one
    in a single process before there is anything to be saved (``waits``): panels of many cells take
    minutes to open.  SIGHUP stays ignored where it is: that is what nohup does."""

    def __init__(self, waits: bool = True) -> None:
        self.signal: int | None = None
        self.waits = waits

    @contextmanager
    def listening(self) -> Iterator[Stop]:
        nohup = signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
        heeded = [name for name in SIGNALS if not (nohup and name == signal.SIGHUP)]
        before = {name: signal.signal(name, self._heard) for name in heeded}
        try:
            yield self
        finally:
            for name, handler in before.items():
                signal.signal(name, handler)

    def _heard(self, number: int, _: FrameType | None) -> None:
        if self.signal is not None:
            raise AtOnce(number, "stopped at once")
        if not self.waits:
            raise AtOnce(number, f"stopped by {signal.Signals(number).name} before the start")
        self.signal = number

    def check(self, world: Any, state: State) -> None:
        """Raises Interrupted on all ranks as soon as one of them heard a signal."""
        heard = self.signal
        if world is not None:
            heard = max(world.allgather(heard or 0)) or None
        if heard is not None:
            raise Interrupted(heard, state)
