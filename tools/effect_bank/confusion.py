"""The confusion table: verdicts before the run against the changes without the effect.

A change counts from 10 % of the value with the effect.  Where a scene has several seeds, means are compared,
and the whole interval of their difference must lie on one side of 10 %.  Half the width of the interval is
Student's t at 95 % times the standard error by Welch, Biometrika 34, 1947, 28-35,
doi 10.1093/biomet/34.1-2.28.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.stats import t as student

from orchestrator.figures.short_names import named
from orchestrator.output.records import trust
from orchestrator.preflight.judgement.pair import Change, compute_change
from orchestrator.preflight.judgement.weighing import weigh_effects, with_doubt
from orchestrator.preflight.scene.effect import Verdict, describe_verdict
from orchestrator.studies.points import is_random
from tools.effect_bank.trials import SceneTrials, Trial

CONFIDENCE = 0.95
CHANGED, UNCHANGED = "changed", "not changed"
BY_CHANCE = "open by chance"
NOT_RUN = "not run"
NOT_COMPARED = "nothing to compare"
OUTCOMES = (CHANGED, UNCHANGED, BY_CHANCE, NOT_COMPARED, NOT_RUN)
PREDICTIONS = tuple(describe_verdict(matters) for matters in (False, True, None))
MAY_GO, MATTERS, CANNOT_SAY = PREDICTIONS
MOST_FALSE_ALARMS = 0.2


@dataclass(frozen=True)
class Row:
    """A row of the table: an effect of a scene.

    ``verdict`` is the verdict before any run, or None if the scene has no such question.  ``changes`` has the
    change of every requested result by name, and ``remark`` a note for the reader.
    """

    scene: str
    effect: str
    verdict: Verdict | None
    changes: Mapping[str, Change]
    outcome: str
    remark: str = ""

    @property
    def predicted(self) -> str:
        """The verdict before the run, in words."""
        return describe_verdict(None if self.verdict is None else self.verdict.matters)

    @property
    def is_wrong(self) -> bool:
        """Whether the effect may be left out by its verdict, but changes a requested result."""
        return self.predicted == MAY_GO and self.outcome == CHANGED

    @property
    def is_false_alarm(self) -> bool:
        """Whether the effect matters by its verdict, but changes no requested result."""
        return self.predicted == MATTERS and self.outcome == UNCHANGED


@dataclass(frozen=True)
class Confusion:
    """The confusion table of verdicts and outcomes."""

    rows: Sequence[Row]

    def count(self, predicted: str, outcome: str) -> int:
        """Return the number of rows with a verdict and an outcome."""
        return Counter((row.predicted, row.outcome) for row in self.rows)[predicted, outcome]

    @property
    def wrong_rows(self) -> list[Row]:
        """The rows whose verdict is wrong."""
        return [row for row in self.rows if row.is_wrong]

    @property
    def false_alarms(self) -> float:
        """The share of false alarms in all verdicts "matters" that the runs decided; 0 without any."""
        alarms = self.count(MATTERS, UNCHANGED)
        decided = alarms + self.count(MATTERS, CHANGED)
        return alarms / decided if decided else 0.0

    @property
    def missing_runs(self) -> int:
        """The number of rows that lack a run."""
        return sum(row.outcome == NOT_RUN for row in self.rows)

    @property
    def is_good(self) -> bool:
        """Whether all runs are made, no verdict is wrong, and false alarms are below a fifth."""
        return not self.wrong_rows and not self.missing_runs and self.false_alarms < MOST_FALSE_ALARMS


def confusion(scenes: Sequence[SceneTrials]) -> Confusion:
    """Return the confusion table of all scenes; rows whose runs are not made have the outcome "not run"."""
    return Confusion([row for one in scenes for row in _rows(one)])


def _rows(one: SceneTrials) -> Iterator[Row]:
    judged = weigh_effects(one.loaded.described, asked=one.scene.asked)
    verdicts = {name: with_doubt(each).verdict for name, each in judged.items()}
    base, *others = one.trials
    for trial in others:
        verdict = verdicts.get(trial.without)
        yield Row(one.name, trial.without, verdict, *_compare(base, trial, one.scene.asked))


def _compare(base: Trial, trial: Trial, asked: Sequence[str]) -> tuple[dict[str, Change], str, str]:
    """Return the changes from the runs with an effect to the runs without it, the outcome, and a remark.

    A scene that fails without the effect counts as changed.
    """
    if trial.omitted:
        return {}, NOT_COMPARED, trial.omitted
    if unsound := base.statuses & {"failed", trust.DOUBTFUL}:
        return {}, NOT_COMPARED, f"the run as it is: {unsound.pop()}"
    if "failed" in trial.statuses:
        return {}, CHANGED, "the run without it failed"
    if not base.has_ended or not trial.has_ended:
        return {}, NOT_RUN, ""
    by_chance = is_random(base.runs[0].loaded)
    changes = {name: change(name, base.summaries, trial.summaries, by_chance=by_chance) for name in asked}
    doubtful = "the run without it is doubtful" if trust.DOUBTFUL in trial.statuses else ""
    return changes, outcome(changes), doubtful


def change(
    name: str, with_it: Sequence[Mapping[str, Any]], without: Sequence[Mapping[str, Any]], *, by_chance: bool
) -> Change:
    """Return the change of a result from the runs with an effect to the runs without it.

    ``with_it`` and ``without`` are the summaries of the runs.  The change is infinite if only one side has
    the result.  With a single run on each side, the interval is that of the runs themselves if random numbers
    place the particles (``by_chance``); otherwise the two runs differ by the effect alone.
    """
    asked = named(name)
    values = [[asked.of(summary) for summary in each] for each in (with_it, without)]
    if len(with_it) == len(without) == 1:
        single = compute_change(values[0][0], values[1][0], asked.figure.floor)
        return single if by_chance else replace(single, uncertain=None)
    one, two = (np.array([each.value for each in side if each is not None]) for side in values)
    if not one.size and not two.size:
        return Change(None, None, None)
    if not one.size or not two.size:
        mean, other = [float(side.mean()) if side.size else None for side in (one, two)]
        return Change(mean, other, math.inf)
    first, second = float(one.mean()), float(two.mean())
    if max(abs(first), abs(second)) < asked.figure.floor:
        return Change(first, second, None)
    by = max(abs(first), asked.figure.floor)
    return Change(first, second, abs(second - first) / by, half_width(one, two, by))


def half_width(one: Any, two: Any, by: float) -> float | None:
    """Return half the width of the interval of the difference of two means, divided by ``by``.

    Return None where a side has a single value.
    """
    if min(one.size, two.size) < 2:
        return None
    parts = np.array([side.var(ddof=1) / side.size for side in (one, two)])
    if not parts.sum():
        return 0.0
    freedom = parts.sum() ** 2 / np.sum(parts**2 / [one.size - 1, two.size - 1])
    return float(student.ppf((1 + CONFIDENCE) / 2, freedom) * math.sqrt(parts.sum()) / by)


def outcome(changes: Mapping[str, Change]) -> str:
    """Return the outcome of all results together: a single changed result makes it "changed"."""
    decided = [one.matters for one in changes.values() if one.relative is not None]
    if not decided:
        return NOT_COMPARED
    if any(one is True for one in decided):
        return CHANGED
    return BY_CHANCE if None in decided else UNCHANGED
