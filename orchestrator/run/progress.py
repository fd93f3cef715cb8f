"""The progress of a run: how far it is, how much time it has taken, and how much is left."""

from __future__ import annotations

import logging
import re
import time
from dataclasses import dataclass
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, TextColumn, TimeRemainingColumn
from rich.progress import Progress as RichProgress

from orchestrator.coupling.metered import Stopwatch

LOG = logging.getLogger("flipflow")
LINE_EVERY_S = 5.0
BAR_EVERY_S = 0.1


class Progress:
    """The progress of a run and its cost; a resumed run goes on counting.

    ``figures`` go to ``summary.json``.
    """

    def __init__(self) -> None:
        self.stopwatch = Stopwatch()
        self.particle_steps = 0
        self.figures: dict[str, Any] = {"sync_intervals": 0, "simulated_s": 0.0, "particles": 0}
        self._started_s, self._before_s, self._processor_earlier_s = time.perf_counter(), 0.0, 0.0
        self.processor_before_s = time.process_time()  # for imports, which the wall time leaves out

    @property
    def wall_s(self) -> float:
        """The wall time of this process and of earlier ones up to their last checkpoints."""
        return self._before_s + time.perf_counter() - self._started_s

    @property
    def processor_s(self) -> float:
        """The processor time of these processes, from the start of each."""
        return self._processor_earlier_s + time.process_time()

    @property
    def done(self) -> int:
        """The number of completed sync intervals."""
        return int(self.figures["sync_intervals"])

    @property
    def simulated_s(self) -> float:
        """The simulated time so far."""
        return float(self.figures["simulated_s"])

    def count_sync_point(self, done: int, time_s: float, particle_steps: int) -> None:
        """Count sync point ``done``, before which each particle took ``particle_steps`` steps."""
        self.particle_steps += particle_steps * self.figures["particles"]
        self.figures |= {"sync_intervals": done, "simulated_s": time_s}

    def as_json(self) -> dict[str, Any]:
        """Return the progress as a table for a checkpoint."""
        return {
            "figures": self.figures,
            "particle_steps": self.particle_steps,
            "wall_s": self.wall_s,
            "processor_s": self.processor_s,
            "processor_before_s": self.processor_before_s,
            "wall_by_part_s": self.stopwatch.wall_s,
            "repeated_by_part_s": self.stopwatch.repeated_s,
        }

    def restore(self, saved: dict[str, Any]) -> None:
        """Restore the progress from the table that ``as_json`` returned."""
        self.figures = dict(saved["figures"])
        self.particle_steps = saved["particle_steps"]
        self._before_s = saved["wall_s"]
        self._processor_earlier_s = saved["processor_s"]
        self.processor_before_s += saved["processor_before_s"]
        books = {"wall_by_part_s": self.stopwatch.wall_s, "repeated_by_part_s": self.stopwatch.repeated_s}
        for name, book in books.items():
            for part, time_s in saved[name].items():
                book[part] = book.get(part, 0.0) + time_s


@dataclass(frozen=True)
class ProgressReport:
    """How far a run is: the simulated time and its end, the wall time spent since the start, and an
    estimate of the wall time left.
    """

    simulated_s: float
    end_s: float
    spent_s: float
    left_s: float

    @property
    def share(self) -> float:
        """The simulated share of the run, from 0 to 1."""
        return self.simulated_s / self.end_s

    @property
    def line(self) -> str:
        """The report as a line of a run's output; ``parse_report`` reads it."""
        return (
            f"t = {self.simulated_s:.4f} of {self.end_s:g} s, {100 * self.share:.0f} %, "
            f"{self.spent_s:.0f} s spent, about {self.left_s:.0f} s left"
        )


_LINE = re.compile(r"t = (\S+) of (\S+) s, \d+ %, (\d+) s spent, about (\d+) s left")


def parse_report(line: str) -> ProgressReport | None:
    """Return the report in a line of a run's output; None if the line is no report."""
    found = _LINE.fullmatch(line.strip())
    return ProgressReport(*map(float, found.groups())) if found else None


class ProgressBar:
    """The display of the progress and the time left: a bar on a terminal, elsewhere lines at intervals."""

    def __init__(self, first: int, intervals: int, interval_s: float, console: Console) -> None:
        """Begin at ``first``, the number of the ``intervals`` that an earlier process completed."""
        self._first, self._intervals, self._interval_s = first, intervals, interval_s
        self._console = console
        self._draws = console.is_terminal and not console.is_dumb_terminal
        self._bar = RichProgress(
            TextColumn("{task.description}"),
            BarColumn(),
            TextColumn("{task.percentage:>3.0f}%"),
            TimeRemainingColumn(),
            console=console,
            disable=not self._draws,
        )
        self._task = self._bar.add_task("simulating", total=intervals, completed=first)
        self._started = self._last_line = self._last_update = time.monotonic()

    def __enter__(self) -> ProgressBar:
        self._bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._bar.stop()

    def update(self, done: int) -> None:
        """Show that ``done`` of all intervals are complete."""
        now = time.monotonic()
        if now - self._last_update > BAR_EVERY_S or done == self._intervals:
            self._bar.update(self._task, completed=done)
            self._last_update = now
        if now - self._last_line < LINE_EVERY_S:
            return
        self._last_line = now
        spent_s = now - self._started
        left_s = spent_s * (self._intervals - done) / (done - self._first)
        line = ProgressReport(
            done * self._interval_s, self._intervals * self._interval_s, spent_s, left_s
        ).line
        LOG.info(line)
        if not self._draws:
            self._console.print(line, highlight=False)
