"""Verdicts before the run against what leaving the effect out did: the confusion table.

A change counts from 10 % of the value with the effect.  Where a scene has several seeds, means are
compared, and the interval of their difference must lie on one side of 10 % as a whole: half its
width is Student's t at 95 % times the standard error by Welch, Biometrika 34, 1947, 28-35,
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

from orchestrator.case.scalars import scalar
from orchestrator.output.records import trust
from orchestrator.preflight.judgement.pair import Change, compute_change
from orchestrator.preflight.judgement.weighing import weigh_effects, with_doubt
from orchestrator.preflight.scene.effect import Verdict, describe_verdict
from orchestrator.studies.points import is_random
from tools.effect_bank.trials import Trial, Tried

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
    """An effect of a scene: the verdict before any run (None: the scene has no such question), and
    the change of every result asked for, by name; ``remark`` says what else is to be known."""

    scene: str
    effect: str
    verdict: Verdict | None
    changes: Mapping[str, Change]
    outcome: str
    remark: str = ""

    @property
    def predicted(self) -> str:
        return describe_verdict(None if self.verdict is None else self.verdict.matters)

    @property
    def wrong(self) -> bool:
        """It was said that it may be left out, and it changes what was asked for."""
        return self.predicted == MAY_GO and self.outcome == CHANGED

    @property
    def false_alarm(self) -> bool:
        """It was said to matter, and it changes nothing of what was asked for."""
        return self.predicted == MATTERS and self.outcome == UNCHANGED


@dataclass(frozen=True)
class Confusion:
    """How many rows have which verdict and which outcome."""

    rows: Sequence[Row]

    def count(self, predicted: str, outcome: str) -> int:
        return Counter((row.predicted, row.outcome) for row in self.rows)[predicted, outcome]

    @property
    def wrong(self) -> list[Row]:
        return [row for row in self.rows if row.wrong]

    @property
    def false_alarms(self) -> float:
        """Share of "matters" that changed nothing, of all "matters" that the runs decided; 0
        without any."""
        alarms = self.count(MATTERS, UNCHANGED)
        decided = alarms + self.count(MATTERS, CHANGED)
        return alarms / decided if decided else 0.0

    @property
    def missing(self) -> int:
        return sum(row.outcome == NOT_RUN for row in self.rows)

    @property
    def good(self) -> bool:
        """Whether all was run, no verdict is wrong, and false alarms are below a fifth."""
        return not self.wrong and not self.missing and self.false_alarms < MOST_FALSE_ALARMS


def confusion(scenes: Sequence[Tried]) -> Confusion:
    """Return the rows of all scenes, as far as their runs are made."""
    return Confusion([row for one in scenes for row in _rows(one)])


def _rows(one: Tried) -> Iterator[Row]:
    judged = weigh_effects(one.loaded.described, asked=one.scene.asked)
    verdicts = {name: with_doubt(each).verdict for name, each in judged.items()}
    base, *others = one.trials
    for trial in others:
        verdict = verdicts.get(trial.without)
        yield Row(one.name, trial.without, verdict, *_compared(base, trial, one.scene.asked))


def _compared(base: Trial, trial: Trial, asked: Sequence[str]) -> tuple[dict[str, Change], str, str]:
    """The changes from the runs with an effect to those without, their outcome, and a remark.  What
    fails without the effect cannot do without it."""
    if trial.omitted:
        return {}, NOT_COMPARED, trial.omitted
    if unsound := base.statuses & {"failed", trust.DOUBTFUL}:
        return {}, NOT_COMPARED, f"the run as it is: {unsound.pop()}"
    if "failed" in trial.statuses:
        return {}, CHANGED, "the run without it failed"
    if not base.ended or not trial.ended:
        return {}, NOT_RUN, ""
    by_chance = is_random(base.runs[0].loaded.case)
    changes = {name: change(name, base.summaries, trial.summaries, by_chance=by_chance) for name in asked}
    doubtful = "the run without it is doubtful" if trust.DOUBTFUL in trial.statuses else ""
    return changes, outcome(changes), doubtful


def change(
    name: str, with_it: Sequence[Mapping[str, Any]], without: Sequence[Mapping[str, Any]], *, by_chance: bool
) -> Change:
    """Return how a result changes from the runs with an effect to those without, given their
    summaries; a result that only one side has has changed by all of it.  Of one run a side, the
    interval is what the runs themselves give, if ``by_chance`` particles lie where random numbers
    put them; else two runs differ by the effect alone."""
    asked = scalar(name)
    found = [[asked.of(summary) for summary in each] for each in (with_it, without)]
    if len(with_it) == len(without) == 1:
        single = compute_change(found[0][0], found[1][0], asked.floor)
        return single if by_chance else replace(single, uncertain=None)
    one, two = (np.array([each.value for each in side if each is not None]) for side in found)
    if not one.size and not two.size:
        return Change(None, None, None)
    if not one.size or not two.size:
        mean, other = [float(side.mean()) if side.size else None for side in (one, two)]
        return Change(mean, other, math.inf)
    first, second = float(one.mean()), float(two.mean())
    if max(abs(first), abs(second)) < asked.floor:
        return Change(first, second, None)
    by = max(abs(first), asked.floor)
    return Change(first, second, abs(second - first) / by, half_width(one, two, by))


def half_width(one: Any, two: Any, by: float) -> float | None:
    """Return half the width of the interval of the difference of two means, over ``by``; None
    where a side has one value only."""
    if min(one.size, two.size) < 2:
        return None
    parts = np.array([side.var(ddof=1) / side.size for side in (one, two)])
    if not parts.sum():
        return 0.0
    freedom = parts.sum() ** 2 / np.sum(parts**2 / [one.size - 1, two.size - 1])
    return float(student.ppf((1 + CONFIDENCE) / 2, freedom) * math.sqrt(parts.sum()) / by)


def outcome(changes: Mapping[str, Change]) -> str:
    """Return what all results together say: one that has changed is enough."""
    decided = [one.matters for one in changes.values() if one.relative is not None]
    if not decided:
        return NOT_COMPARED
    if any(one is True for one in decided):
        return CHANGED
    return BY_CHANCE if None in decided else UNCHANGED
