"""A run that is asked to stop: signals are heard, and heeded at the next sync point."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

from orchestrator.coupling import State

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
