"""How far a run is, and what that has cost."""

from __future__ import annotations

import time
from typing import Any

from orchestrator.coupling.stopwatch import Stopwatch


class Progress:
    """``figures`` go to ``summary.json``; a run that is resumed counts on."""

    def __init__(self) -> None:
        self.stopwatch = Stopwatch()
        self.particle_steps = 0
        self.figures: dict[str, Any] = {"sync_intervals": 0, "simulated_s": 0.0, "particles": 0}
        self._started_s, self._before_s = time.perf_counter(), 0.0
        self.processor_before_s = time.process_time()  # importing, which no wall time counts

    @property
    def wall_s(self) -> float:
        """Of the processes before this one, too, up to what they saved."""
        return self._before_s + time.perf_counter() - self._started_s

    def sync_point(self, done: int, time_s: float, particle_steps: int) -> None:
        """``done`` of them, after so many steps of each particle."""
        self.particle_steps += particle_steps * self.figures["particles"]
        self.figures |= {"sync_intervals": done, "simulated_s": time_s}

    def as_json(self) -> dict[str, Any]:
        return {
            "figures": self.figures,
            "particle_steps": self.particle_steps,
            "wall_s": self.wall_s,
            "wall_by_part_s": self.stopwatch.wall_s,
        }

    def restore(self, saved: dict[str, Any]) -> None:
        """What ``as_json`` gave."""
        self.figures = dict(saved["figures"])
        self.particle_steps = saved["particle_steps"]
        self._before_s = saved["wall_s"]
        for part, wall_s in saved["wall_by_part_s"].items():
            self.stopwatch.wall_s[part] = self.stopwatch.wall_s.get(part, 0.0) + wall_s
