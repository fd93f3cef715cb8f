"""Signals that ask a run to stop, which it does at the next sync point."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

from orchestrator.coupling.schemes.scheme import State

# SIGHUP comes when a terminal or a connection closes; SIGUSR1 is what mpirun passes on without
# killing a second later, and what batch systems can send
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGUSR1)


class Interrupted(Exception):
    """The user asked to stop; raised at a sync point, with the ``state`` there."""

    def __init__(self, number: int, state: State) -> None:
        super().__init__(f"stopped by {signal.Signals(number).name}")
        self.signal, self.state = number, state


class ImmediateStop(KeyboardInterrupt):
    """The user asked to stop, and nothing is waited for; the message says why not."""

    def __init__(self, number: int, why: str) -> None:
        super().__init__(why)
        self.signal = number


def immediate_stop(error: BaseException | None) -> KeyboardInterrupt | None:
    """Return the signal behind an error that did not wait for a sync point, if any.  Libraries that it
    interrupts may raise another error on top of it."""
    while error is not None:
        if isinstance(error, KeyboardInterrupt):
            return error
        error = error.__cause__ or error.__context__
    return None


class StopRequest:
    """A signal to stop, remembered until the next sync point.

    The second signal does not wait, nor does one in a single process before there is anything to be
    saved (``waits`` is False): panels of many cells take minutes to open.  SIGHUP stays ignored
    where it is ignored already: that is what nohup does.
    """

    def __init__(self, waits: bool = True) -> None:
        self.signal: int | None = None
        self.waits = waits

    @contextmanager
    def listening(self) -> Iterator[StopRequest]:
        nohup = signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
        handled = [name for name in SIGNALS if not (nohup and name == signal.SIGHUP)]
        before = {name: signal.signal(name, self._handle) for name in handled}
        try:
            yield self
        finally:
            for name, handler in before.items():
                signal.signal(name, handler)

    def _handle(self, number: int, _: FrameType | None) -> None:
        if self.signal is not None:
            raise ImmediateStop(number, "stopped at once")
        if not self.waits:
            raise ImmediateStop(number, f"stopped by {signal.Signals(number).name} before the start")
        self.signal = number

    def check(self, world: Any, state: State) -> None:
        """Raise Interrupted on all ranks as soon as one of them got a signal."""
        number = self.signal
        if world is not None:
            number = max(world.allgather(number or 0)) or None
        if number is not None:
            raise Interrupted(number, state)
