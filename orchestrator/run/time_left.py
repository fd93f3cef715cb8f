"""How far a run is and how long it will take, for those who wait for it."""

from __future__ import annotations

import logging
import time

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

LOG = logging.getLogger("flipflow")
SAY_EVERY_S = 5.0


class Say:
    """Progress with time left: a bar on a terminal, a line now and then elsewhere."""

    def __init__(self, first: int, intervals: int, interval_s: float, console: Console) -> None:
        """Of so many ``intervals``, the ``first`` were done before."""
        self._first, self._intervals, self._interval_s = first, intervals, interval_s
        self._console = console
        self._draws = console.is_terminal and not console.is_dumb_terminal
        self._bar = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            TextColumn("{task.percentage:>3.0f}%"),
            TimeRemainingColumn(),
            console=console,
            disable=not self._draws,
        )
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
        if not self._draws:
            self._console.print(line, highlight=False)
