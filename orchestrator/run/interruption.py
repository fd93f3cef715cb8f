"""Signals that ask a run to stop; the run stops at the next sync point."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # commands that run nothing import this file, and schemes take long to import
    from orchestrator.coupling.schemes.scheme import State

# SIGHUP comes when a terminal or a connection closes.  Batch systems can send SIGUSR1, and mpirun passes
# it on without killing the run a second later
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGUSR1)


class Interrupted(Exception):
    """A request of the user to stop, raised at a sync point; ``state`` is the state at this point."""

    def __init__(self, number: int, state: State) -> None:
        super().__init__(f"stopped by {signal.Signals(number).name}")
        self.signal, self.state = number, state


class ImmediateStop(KeyboardInterrupt):
    """A request of the user to stop that does not wait for a sync point; the message says why."""

    def __init__(self, number: int, why: str) -> None:
        super().__init__(why)
        self.signal = number


def find_immediate_stop(error: BaseException | None) -> KeyboardInterrupt | None:
    """Return the interrupt behind an error, or None if there is none.

    A library that an interrupt stops may raise an error of its own on top of it.
    """
    while error is not None:
        if isinstance(error, KeyboardInterrupt):
            return error
        error = error.__cause__ or error.__context__
    return None


class StopRequest:
    """A signal to stop, remembered until the next sync point.

    The second signal stops the run at once.  So does the first one while ``waits`` is False: in a single
    process before there is anything to save, since panels of many cells take minutes to open.
    SIGHUP stays ignored if it is ignored already, as under nohup.
    """

    def __init__(self, waits: bool = True) -> None:
        self.signal: int | None = None
        self.waits = waits

    @contextmanager
    def listen(self) -> Iterator[StopRequest]:
        """Handle the signals while inside, and restore the former handlers at the end."""
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
        """Raise Interrupted on all ranks if one of them has received a signal."""
        number = self.signal
        if world is not None:
            number = max(world.allgather(number or 0)) or None
        if number is not None:
            raise Interrupted(number, state)
