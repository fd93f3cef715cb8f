"""Trials made as runs of the case, each in a process and a folder of its own."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from functools import cached_property, partial
from typing import Any

import numpy as np

from orchestrator.studies.design.formulas import BadFormula
from orchestrator.studies.design.scales import SCALES
from orchestrator.studies.design.study_file import Study
from orchestrator.studies.design.trials import Measured, Outcome, Stage, Trial
from orchestrator.studies.points import CaseStudy, Point, run_point, seed_sets
from orchestrator.studies.sweep_plan import check_names
from orchestrator.workbench import Case, CaseError, CaseProblem, Run
from orchestrator.workbench.vocabulary import NORMAL_95, Value

UNFINISHED = ("missing", "interrupted")
FROM_THE_BED = re.compile(
    r"wear|work_per_feed|results\.wear\..*|results\.power\.drives_J_per_kg|.*\.load_N\..*"
)
"""Results of panels and drives that the material makes."""
OF_THE_RUN = ("results.bulk.", "energy_ledger_J.")
"""The beginnings of results that a steady state does not define."""


def has_ended(run: Run) -> bool:
    """Return whether a run is over for good; a failed run would fail again."""
    return run.status not in UNFINISHED


class Runs:
    """The evaluator of a study of a case."""

    def __init__(self, study: Study, runs: CaseStudy) -> None:
        self._study, self._runs = study, runs

    @cached_property
    def side_by_side(self) -> int:
        """The number of runs at a time."""
        return self._runs.crew.size()

    @cached_property
    def centre(self) -> Case:
        """The case at the centre of the ranges.  Raises CaseError."""
        return self._runs.check(self._study.overlays(self._study.actual(np.zeros(self._study.space.factors))))

    def check(self) -> None:
        """Check the centre and the corners of the ranges as cases, the centre at the cheap level, too.

        Raises CaseError with the settings that no case can have, and why.
        """
        problems: list[CaseProblem] = []
        for corner in (np.zeros(self._study.space.factors), *self._study.corners()):
            setting = self._study.actual(corner)
            named = ", ".join(f"{name} = {value:g}" for name, value in setting.items())
            try:
                self._study.check_simpler(corner)
                self._runs.check(self._study.overlays(setting))
            except BadFormula as error:
                problems.append(CaseProblem(("set",), f"{named}: {error}"))
            except CaseError as error:
                problems.append(replace(error.problems[0], what=f"{named}: {error.problems[0].what}"))
                if len(problems) == 1:
                    self._raise_if_never_a_case(error)
        if problems:
            raise CaseError(problems)
        check_names(replace(self._runs, sets=self._study.file.overrides), self._study.file.set, "[set]")
        if self._study.file.cheap is not None:
            runs, overlays = self._at_stage("cheap", self._study.actual(np.zeros(self._study.space.factors)))
            runs.check(overlays)

    def _raise_if_never_a_case(self, error: CaseError) -> None:
        """Raise the problems of the case without the formulas where ``error`` is one of them."""
        try:
            self._runs.check(self._study.file.overrides)
        except CaseError as own:
            if error.problems[0] in own.problems:
                raise own from None

    def outcomes(self, wanted: Iterable[Trial]) -> Iterator[Outcome]:
        """Run the trials that are not done, and yield the outcome of each."""
        beside = self.side_by_side  # asked here: a worker may not reach the scheduler
        yield from self._runs.crew.each(partial(self._make, trial, beside) for trial in wanted)

    def finished(self, trials: Iterable[Trial]) -> list[Outcome]:
        """Return the outcomes of the trials that have been run to their end; nothing is run.

        Raises FolderUnusable where a run is of another case than the study's.
        """
        outcomes = (self._make(trial) for trial in trials)
        return [outcome for outcome in outcomes if outcome.status not in UNFINISHED]

    def points(self, trials: Iterable[Trial]) -> list[Point]:
        """Return the runs of trials, without those that no case can have."""
        points = []
        for trial in trials:
            with suppress(CaseError, BadFormula):
                points.append(self._point(trial))
        return points

    def _make(self, trial: Trial, beside: int = 0) -> Outcome:
        """Return the outcome of a trial, which is run if ``beside``, the number of runs at a time, is above
        0."""
        try:
            point = self._point(trial)
        except (CaseError, BadFormula) as error:
            why = str(error.problems[0]) if isinstance(error, CaseError) else str(error)
            return Outcome(trial, "refused", why)
        if not point.done() and beside:
            run_point(point, beside)
        return self._outcome(trial, point)

    def _point(self, trial: Trial) -> Point:
        runs, overlays = self._at_stage(trial.stage, trial.values)
        seeds = seed_sets(self.centre, trial.seed)
        steady = all(table.steady for table in self._study.file.responses.values())
        free = ("duration_s",) if steady else ()  # short and long runs tell the same, each with its noise
        return replace(runs.point(trial.name, [*overlays, *seeds]), ended=has_ended, free=free)

    def _at_stage(self, stage: Stage, setting: Mapping[str, float]) -> tuple[CaseStudy, list[str]]:
        """Return the runs of a stage, and the overlays of a setting there; without a cheap level, the
        study's."""
        overlays, cheap = self._study.overlays(setting), self._study.file.cheap
        if stage != "cheap" or cheap is None:
            return self._runs, overlays
        return replace(self._runs, level=cheap.level), [*overlays, *cheap.overrides]

    def _outcome(self, trial: Trial, point: Point) -> Outcome:
        run = point.run
        summary, state, cost = run.summary, run.status, _cost(run)
        if not run.is_trusted:
            why = str(summary.get("reason") or "; ".join(summary.get("doubts", ())) or state)
            return Outcome(trial, state, why, **cost)
        responses, unsteady = {}, not run.entry("results.steady.is_steady")  # of the material
        for name, table in self._study.file.responses.items():
            if table.steady and unsteady:
                continue
            if (result := run.result(table.result or name)) is not None:
                responses[name] = Measured(result.value, _deviation(result) or table.noise)
        why = self._why_off_scale(responses) if responses else self._why_nothing(unsteady)
        return Outcome(trial, state, why, responses, **cost, not_steady=self._not_steady(run, responses))

    def _not_steady(self, run: Run, responses: Iterable[str]) -> str:
        """Say why the bed, of which frames and panels tell nothing, or the machine is not steady."""
        results = [self._study.file.responses[name].result or name for name in responses]
        if all(result.startswith(OF_THE_RUN) for result in results):
            return ""
        bed, motion = run.why_transient
        bed = bed if any(map(self._is_of_the_bed, results)) else ""
        return "; ".join(filter(None, (bed, motion and f"the machine has not settled: {motion}")))

    def _is_of_the_bed(self, result: str) -> bool:
        """Tell whether a result may depend on the material; the own probes of frames are in no table."""
        if FROM_THE_BED.fullmatch(result):
            return True
        part = self.centre.part_of(result)
        return part == "particles" or not (part or result.startswith(("results.motion.", "probes.")))

    def _why_off_scale(self, responses: Mapping[str, Measured]) -> str:
        """Say which responses are not on their scales; empty where all are."""
        scales = {name: self._study.file.responses[name].scale for name in responses}
        return "; ".join(
            f'{name} = {each.value:g} is not on the scale "{scales[name]}"'
            for name, each in responses.items()
            if not SCALES[scales[name]].has(each.value)
        )

    def _why_nothing(self, unsteady: bool) -> str:
        """Say why a run tells none of the responses."""
        if unsteady and any(table.steady for table in self._study.file.responses.values()):
            return "the run did not become steady"
        return f"the run does not tell {', '.join(self._study.file.responses)}"


def _deviation(result: Value) -> float | None:
    """Return the standard deviation of a run's value; None if the run tells nothing of it.

    A result without a standard error has the width of its interval alone, by which it is rather too large.
    """
    if result.standard_error or not result.half_width:
        return result.standard_error or result.counting
    return result.half_width / NORMAL_95


def _cost(run: Run) -> dict[str, Any]:
    """Return what a run cost, as ``Outcome`` has it."""
    summary = run.summary
    particles_s = run.worked_by_part_s["particles"] if "wall_by_part_s" in summary else 0.0
    return {
        "wall_s": float(summary.get("wall_s") or 0.0),
        "processor_s": float(summary.get("processor_s") or 0.0),
        "particle_steps": round((summary.get("particle_steps_per_s") or 0.0) * particles_s),
    }
