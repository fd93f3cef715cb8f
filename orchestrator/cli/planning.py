"""``flipflow plan``: settings for a tolerance and a wall time, and remedies where they do not fit.

The time of a run is the time of its start (imports, and the opening of the solvers, which is the part "rest")
and a constant time for each simulated second, apart from the particles that feeds add.  The study's short run
is made again on this machine: it gives the time of the start and the speed of the machine relative to the
study's machine, under its present load.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from scipy.optimize import brentq

from orchestrator import workbench
from orchestrator.case.bed.grains import largest_length_m
from orchestrator.case.file.errors import CaseError, CaseProblem
from orchestrator.case.file.slice import ENOUGH_DIAMETERS, between_openings_m, full_width_m
from orchestrator.case.tables.case import Case, has_particles
from orchestrator.output.cycles import cycle_s
from orchestrator.output.records import trust
from orchestrator.ports.plans import SolverFailed
from orchestrator.preflight.cost import bed_cost, in_words, likely_transport_m_per_s, particles_at_start
from orchestrator.preflight.judge import load_judged
from orchestrator.run.trials.scratch import NoResult, run_in_scratch
from orchestrator.studies.accuracy.combinations import START, part_s
from orchestrator.studies.accuracy.stored import Candidate, StoredStudy


def filling(case: Case, study_s: float) -> Callable[[float], float]:
    """Return a function of a run's duration in s that gives the relative mean number of particles.

    The number is relative to the mean number in a run of ``study_s``.
    """
    if not case.bed.feeds:
        return lambda duration_s: 1.0
    at_start = particles_at_start(case)
    bed = likely_transport_m_per_s(case, at_start)

    def mean(duration_s: float) -> float:
        return bed_cost(case.model_copy(update={"duration_s": duration_s}), at_start, bed).mean

    of_study = mean(study_s)
    return lambda duration_s: mean(duration_s) / of_study if of_study else 1.0


PART = 8  # the number of parts of a run without a study, of which one is made to measure its speed


@dataclass(frozen=True)
class Timing:
    """The time that runs take on this machine.

    The study took ``study_start_s`` of processor time to start and simulated ``simulated_s``.  On this
    machine a start takes ``start_s`` of wall time, and a second of the study's processor time in stepping
    takes ``factor`` seconds of wall time.  ``particles`` is the particles' share of the study's stepping
    time, and ``filling`` gives their relative number in runs of other durations.
    """

    study_start_s: float
    simulated_s: float
    start_s: float
    factor: float
    particles: float = 0.0
    filling: Callable[[float], float] = lambda duration_s: 1.0

    def wall_s(self, processor_s: float, duration_s: float) -> float:
        """Return the wall time, on this machine, of a run of ``duration_s``.

        ``processor_s`` is the processor time of its settings in the study.
        """
        study_s = max(processor_s - self.study_start_s, 0.0)
        return self.start_s + self.factor * study_s * self._relative_stepping(duration_s)

    def duration_s(self, processor_s: float, wall_s: float, longest_s: float) -> float:
        """Return the longest duration of a run, at most ``longest_s``, that fits into a wall time.

        It is 0 if not even the start fits.
        """
        if self.wall_s(processor_s, longest_s) <= wall_s:
            return longest_s
        if wall_s <= self.start_s:
            return 0.0
        return float(brentq(lambda t: self.wall_s(processor_s, t) - wall_s, 0.0, longest_s))

    def affordable_s(self, wall_s: float, duration_s: float) -> float:
        """Return the processor time in the study of settings that take ``wall_s`` on this machine."""
        stepping_s = max(wall_s - self.start_s, 0.0) / self.factor
        return self.study_start_s + stepping_s / self._relative_stepping(duration_s)

    def _relative_stepping(self, duration_s: float) -> float:
        """Return the stepping time of a run of ``duration_s``, relative to the study's run."""
        more = 1.0 + self.particles * (self.filling(duration_s) - 1.0)
        return more * duration_s / self.simulated_s


def time_run(case: Path, level: str | None, sets: Sequence[str]) -> dict[str, Any]:
    """Make a run in a scratch folder, and return its summary.

    Only its times count, so the run may be doubtful.  Raises CaseError, and SolverFailed if the run does not
    come to its end.
    """
    try:
        summary = run_in_scratch(case, workbench.Case.load(case, level, sets).level, sets)
    except NoResult as why:
        raise SolverFailed(f"the calibration run {why}") from None
    if not trust.came_to_its_end(str(summary["status"])):
        raise SolverFailed(f"the calibration run failed: {summary.get('reason', '')}")
    return summary


def time_by_study(study: StoredStudy, case: Path, level: str | None) -> Timing:
    """Make the study's short run on this machine, and return the time that runs take here."""
    base = study.table["base"]
    if not study.table["short"]:
        raise CaseError(
            [
                CaseProblem(
                    (), "has no times: its short run was not to be trusted", file=str(study.file), kind="file"
                )
            ]
        )
    (short,) = study.table["short"].values()
    here = time_run(case, level, [*study.table["sets"], *study.table["shared"], *short["sets"]])
    wall_s = here["wall_by_part_s"]
    simulated_s, in_parts_s = base["simulated_s"], base["processor_by_part_s"]
    return Timing(
        _start_s(in_parts_s),
        simulated_s,
        _start_s(wall_s),
        _stepping_s(wall_s) / _stepping_s(short["processor_by_part_s"]),
        in_parts_s.get("particles", 0.0) / _stepping_s(in_parts_s),
        filling(load_judged(case, level, study.table["sets"]).case, simulated_s),
    )


def predict_wall_s(path: Path, level: str | None, sets: Sequence[str], case: workbench.Case) -> float:
    """Return the wall time, on this machine, of a case without a study, predicted from a short run."""
    duration_s = part_s(case, PART)
    short = [*sets, f"duration_s={duration_s!r}", "output.pictures=false"]
    wall_s = time_run(path, level, short)["wall_by_part_s"]
    return _start_s(wall_s) + case.tables.duration_s / duration_s * _stepping_s(wall_s)


def _start_s(time_s: Mapping[str, float]) -> float:
    return sum(time_s.get(part, 0.0) for part in START)


def _stepping_s(time_s: Mapping[str, float]) -> float:
    return sum(part_s for part, part_s in time_s.items() if part not in START)


SHARED = ("particles", "panel")  # parts whose work the ranks share
MOST_RANKS = 64  # the cores of a workstation


@dataclass(frozen=True)
class Plan:
    """A plan for a case by its study: the choice of settings for a tolerance and a wall time ``budget_s``."""

    case: Case
    study: StoredStudy
    timing: Timing
    tolerance: float
    budget_s: float

    @cached_property
    def choice(self) -> Candidate | None:
        """The settings that are recommended for the tolerance, whether or not they fit the budget."""
        return self.study.recommend(self.tolerance)

    @property
    def wall_s(self) -> float:
        """The wall time of the chosen settings on this machine; infinite without a choice."""
        return math.inf if self.choice is None else self._wall_s(self.choice)

    @property
    def fits(self) -> bool:
        """Whether the wall time is within the budget."""
        return self.wall_s <= self.budget_s

    def _wall_s(self, candidate: Candidate) -> float:
        return self.timing.wall_s(candidate.processor_s, self.case.duration_s)

    def remedies(self) -> Iterator[str]:
        """Yield changes that would make the plan fit, in words for the console."""
        if self.choice is not None:
            yield from self._shorter(self.choice)
        coarser = self.study.best(self.timing.affordable_s(self.budget_s, self.case.duration_s))
        if coarser is not None:
            sets = " ".join(f"--set {each}" for each in coarser.sets) or "the case as it is"
            takes = in_words(self._wall_s(coarser))
            yield f"coarser: {sets} is off by {100 * coarser.error.at_most:.3g} % and takes {takes}"
        if self.choice is not None:
            yield from self._more_ranks_or_narrower()

    def _shorter(self, candidate: Candidate) -> Iterator[str]:
        longest_s, cycle = self.case.duration_s, cycle_s(self.case)
        duration_s = self.timing.duration_s(candidate.processor_s, self.budget_s, longest_s)
        if cycle < longest_s:
            cycles, every = math.floor(duration_s / cycle), round(longest_s / cycle)
            if cycles:
                yield f"fewer cycles: {cycles} of {every} (duration_s={cycles * cycle:.4g})"
        elif duration_s > 0:
            yield f"a shorter run: duration_s={duration_s:.3g}"

    def _more_ranks_or_narrower(self) -> Iterator[str]:
        """Yield the number of ranks and the width of a slice that would make the plan fit, in words."""
        case, parts_s = self.case, self.study.table["base"]["processor_by_part_s"]
        share = sum(parts_s.get(name, 0.0) for name in SHARED) / sum(parts_s.values())
        shared_s, left_s = share * self.wall_s, self.budget_s - (1 - share) * self.wall_s
        ranks = math.ceil(shared_s / left_s) if left_s > 0 else math.inf
        if ranks <= MOST_RANKS:
            yield f"more ranks: mpirun -n {max(2, ranks)}, if they share their work perfectly"
        else:
            yield "more ranks would not do: what they do not share takes too long"
        if not has_particles(case) or case.bed.particles or case.bed.is_carried or left_s <= 0:
            return
        try:
            low, high = full_width_m(case.whole_machine)
        except CaseError:
            return
        now_m = case.slice.width_m if case.slice else high - low
        width_m = between_openings_m(case.whole_machine, now_m * left_s / shared_s)
        if width_m >= ENOUGH_DIAMETERS * largest_length_m(case):
            yield f"a slice: slice.width_m={width_m:.3g} instead of {now_m:.3g} m"
