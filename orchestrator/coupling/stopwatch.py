"""Where the time goes: exclusive wall time by part."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager


class Stopwatch:
    """Entering a part pauses the one outside it, so the parts add up to the time inside any."""

    def __init__(self) -> None:
        self.wall_s: dict[str, float] = {}
        self._parts: list[str] = []
        self._since_s = 0.0

    @contextmanager
    def __call__(self, part: str) -> Iterator[None]:
        self._book()
        self._parts.append(part)
        try:
            yield
        finally:
            self._book()
            self._parts.pop()

    def _book(self) -> None:
        now = time.perf_counter()
        if self._parts:
            part = self._parts[-1]
            self.wall_s[part] = self.wall_s.get(part, 0.0) + now - self._since_s
        self._since_s = now
