"""A short run on this machine, and what a long one takes by it.

A run takes its start (importing, and part "rest" of its time: opening the solvers), and then the
same for each simulated second, but for what feeds add to the particles' share.  The study's short
run, made again here, tells the start here, and how much faster or slower this machine steps, with
whatever else it is busy with.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from scipy.optimize import brentq

from orchestrator.case.tables.case import Case
from orchestrator.output.records import trust
from orchestrator.output.results.run_reader import RunReader
from orchestrator.ports.plans import SolverFailed
from orchestrator.preflight.levels import load
from orchestrator.studies import points as sweep
from orchestrator.studies.accuracy.filling import filling
from orchestrator.studies.accuracy.measured import parts_s
from orchestrator.studies.accuracy.stored import Stored
from orchestrator.studies.workers import Crew

START = ("start", "rest")
PART = 8  # of a run that has no study: of so many parts, one is made


@dataclass(frozen=True)
class Clock:
    """Of one kind of time: what a start takes here, and what one second of the study's processor
    time in stepping takes here."""

    start_s: float
    factor: float


@dataclass(frozen=True)
class Timing:
    """The study took ``study_start_s`` of processor time to start and simulated ``simulated_s``;
    ``particles`` is their share of its stepping, ``filling`` how many there are in runs of other
    lengths (filling.py)."""

    study_start_s: float
    simulated_s: float
    wall: Clock
    processor: Clock
    particles: float = 0.0
    filling: Callable[[float], float] = lambda duration_s: 1.0

    def wall_s(self, processor_s: float, duration_s: float) -> float:
        """Wall time here of a run of ``duration_s`` with settings that took ``processor_s`` in the
        study."""
        return self._on(self.wall, processor_s, duration_s)

    def processor_s(self, processor_s: float, duration_s: float) -> float:
        """Processor time of it."""
        return self._on(self.processor, processor_s, duration_s)

    def _on(self, clock: Clock, processor_s: float, duration_s: float) -> float:
        study_s = max(processor_s - self.study_start_s, 0.0)
        return clock.start_s + clock.factor * study_s * self._lasts(duration_s)

    def duration_s(self, processor_s: float, wall_s: float, longest_s: float) -> float:
        """How long a run may last, at most ``longest_s``, to take so much wall time; 0 if not even
        its start fits."""
        if self.wall_s(processor_s, longest_s) <= wall_s:
            return longest_s
        if wall_s <= self.wall.start_s:
            return 0.0
        return float(brentq(lambda t: self.wall_s(processor_s, t) - wall_s, 0.0, longest_s))

    def affordable_s(self, wall_s: float, duration_s: float) -> float:
        """The study's processor time of settings that take so much wall time here."""
        stepping_s = max(wall_s - self.wall.start_s, 0.0) / self.wall.factor
        return self.study_start_s + stepping_s / self._lasts(duration_s)

    def _lasts(self, duration_s: float) -> float:
        """The stepping of a run of ``duration_s``, relative to the study's."""
        more = 1.0 + self.particles * (self.filling(duration_s) - 1.0)
        return more * duration_s / self.simulated_s


def timed(case: Path, level: str | None, sets: Sequence[str]) -> dict[str, Any]:
    """The summary of a run that nobody keeps; only its times are asked for, so that it may be a
    doubtful one.  Raises CaseError, and SolverFailed if it does not come to its end."""
    with tempfile.TemporaryDirectory(prefix="flipflow-plan-") as scratch:
        one = sweep.point(case, level, sets, "short", Path(scratch) / "short")
        list(sweep.run_points([one], Crew(1)))
        if not trust.came_to_its_end(one.status()):
            said = (Path(scratch) / "short.log").read_text(encoding="utf-8").strip()
            raise SolverFailed(f"the calibration run failed: {said.splitlines()[-1:]}")
        return RunReader(one.folder).summary


def by_study(study: Stored, case: Path, level: str | None) -> Timing:
    """From the study's short run, made again here."""
    base = study.found["base"]
    (short,) = study.found["short"].values()
    here = timed(case, level, [*study.found["sets"], *study.found["shared"], *short["sets"]])
    study_s = _stepping_s(short["processor_by_part_s"])
    wall, processor = (
        Clock(_start_s(each), _stepping_s(each) / study_s) for each in (here["wall_by_part_s"], parts_s(here))
    )
    simulated_s, in_parts_s = base["simulated_s"], base["processor_by_part_s"]
    return Timing(
        _start_s(in_parts_s),
        simulated_s,
        wall,
        processor,
        in_parts_s.get("particles", 0.0) / _stepping_s(in_parts_s),
        filling(load(case, level, study.found["sets"]).case, simulated_s),
    )


def as_it_is_s(path: Path, level: str | None, sets: Sequence[str], case: Case) -> float:
    """Wall time here of a case without a study, from a short run."""
    duration_s = part_s(case, PART)
    short = [*sets, f"duration_s={duration_s!r}", "output.pictures=false"]
    wall_s = timed(path, level, short)["wall_by_part_s"]
    return _start_s(wall_s) + case.duration_s / duration_s * _stepping_s(wall_s)


def part_s(case: Case, parts: int) -> float:
    """How long a short run lasts: one of ``parts`` of the time in which all feeds run.  A case in
    which a feed does not begin is refused."""
    begun_s = max((feed.start_s for feed in case.bed.feeds.values()), default=0.0)
    return begun_s + (case.duration_s - begun_s) / parts


def _start_s(time_s: Mapping[str, float]) -> float:
    return sum(time_s.get(part, 0.0) for part in START)


def _stepping_s(time_s: Mapping[str, float]) -> float:
    return sum(part_s for part, part_s in time_s.items() if part not in START)
