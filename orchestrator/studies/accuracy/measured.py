"""What the runs of points say: values, errors with confidence, cost."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.stats import t as student

from orchestrator.output.results.estimate import CONFIDENCE
from orchestrator.studies.accuracy.combinations import Combination
from orchestrator.studies.criteria import answer_error
from orchestrator.studies.criterion import Criterion
from orchestrator.studies.metrics import QUANTITIES, Metrics, measure, relative


@dataclass(frozen=True)
class Measured:
    """A point with what its runs were measured by, one for each seed."""

    point: Combination
    metrics: tuple[Metrics, ...]

    def values(self, name: str) -> list[float]:
        """Of a quantity or defect, by seed, as far as it is defined."""
        found = ((one.values | one.defects).get(name) for one in self.metrics)
        return [value for value in found if value is not None]

    def mean(self, name: str) -> float | None:
        values = self.values(name)
        return float(np.mean(values)) if values else None

    @property
    def processor_s(self) -> float:
        """Of one run."""
        return float(np.mean([one.summary["processor_s"] for one in self.metrics]))

    @property
    def wall_s(self) -> float:
        return float(np.mean([one.summary["wall_s"] for one in self.metrics]))

    @property
    def memory_MiB(self) -> float:
        largest_MiB: float = max(one.summary["peak_memory_MiB"] for one in self.metrics)
        return largest_MiB

    @property
    def side_by_side(self) -> int:
        """How many runs were at work at a time when these were."""
        return max(one.side_by_side() for one in self.point.runs)

    @property
    def processor_by_part_s(self) -> dict[str, float]:
        """Processor time by part of the program, mean over the seeds."""
        every = [parts_s(one.summary) for one in self.metrics]
        return {part: float(np.mean([one[part] for one in every])) for part in every[0]}


def parts_s(summary: Mapping[str, Any]) -> dict[str, float]:
    """Returns the processor time of a run by part: "start" is before its wall time counts, the rest
    is divided as that is."""
    before_s = summary.get("processor_before_s", 0.0)  # runs of older versions do not tell
    rate = (summary["processor_s"] - before_s) / summary["wall_s"]
    return {"start": before_s} | {part: rate * time_s for part, time_s in summary["wall_by_part_s"].items()}


@dataclass(frozen=True)
class Error:
    """A relative error, and half the width of its 95 % confidence interval: 0 where nothing is
    random, None where a single seed tells nothing."""

    value: float
    half_width: float | None = 0.0

    @property
    def certain(self) -> bool:
        """It is more than chance."""
        return self.half_width is None or self.value > self.half_width

    @property
    def at_most(self) -> float:
        return self.value + (self.half_width or 0.0)


@dataclass(frozen=True)
class Scatter:
    """Relative standard deviation from seed to seed, apart from what a seed does to all points, and
    its degrees of freedom; none where nothing is random."""

    random: bool
    deviation: Mapping[str, float]
    freedom: int

    def half_width(self, name: str, seeds: Sequence[int]) -> float | None:
        """Of the difference of means over so many seeds each."""
        if not self.random:
            return 0.0
        if self.freedom == 0 or name not in self.deviation:
            return None
        quantile = float(student.ppf((1 + CONFIDENCE) / 2, self.freedom))
        return quantile * self.deviation[name] * math.sqrt(sum(1 / n for n in seeds))


EXACT = Scatter(False, {}, 0)
"""No chance: every difference counts."""


def read(points: Sequence[Combination]) -> dict[str, Measured]:
    """By name, of those that are done."""
    return {
        one.name: Measured(one, tuple(measure(run.folder) for run in one.runs)) for one in points if one.done
    }


def scatter(every: Sequence[Measured], random: bool) -> Scatter:
    """Every point has the same random numbers, so that what a seed does to all of them alike is no
    scatter between them: the residual of points and seeds (randomised blocks).  Points are taken to
    scatter alike, so that two or three seeds each are enough."""
    seeds = max((len(one.metrics) for one in every), default=0)
    freedom, found = 0, {}
    for name in QUANTITIES:
        rows = [v for one in every if len(v := one.values(name)) == seeds and np.mean(v)]
        if seeds < 2 or len(rows) < 2:
            continue
        values = np.array(rows)
        relative_to_mean = values / values.mean(axis=1, keepdims=True)
        left = relative_to_mean - relative_to_mean.mean(axis=0)
        own = (len(values) - 1) * (seeds - 1)
        freedom = max(freedom, own)
        found[name] = math.sqrt(float((left**2).sum()) / own)
    return Scatter(random, found, freedom)


def errors(found: Measured, reference: Measured, spread: Scatter) -> dict[str, Error]:
    """Of every quantity that both have, relative to the reference; shapes seed by seed."""
    seeds = (len(found.metrics), len(reference.metrics))
    differences = {}
    for name in QUANTITIES:
        ours, theirs = found.mean(name), reference.mean(name)
        if ours is not None and theirs:
            off = abs(ours - theirs) / abs(theirs)
            differences[name] = Error(off, spread.half_width(name, seeds))
    pairs = [
        relative(a.shapes_m, b.shapes_m)
        for a, b in zip(found.metrics, reference.metrics, strict=True)
        if a.shapes_m.size and a.shapes_m.shape == b.shapes_m.shape
    ]
    if pairs and np.isfinite(pairs).all():  # else nothing is bent
        differences["shape"] = Error(float(np.mean(pairs)))
    return differences


def against(found: Measured, known: Sequence[Criterion]) -> dict[str, float]:
    """Relative errors against known answers, mean over the seeds."""
    wrong = {row.what: [answer_error(row, run.folder) for run in found.point.runs] for row in known}
    told = {name: [x for x in each if x is not None] for name, each in wrong.items()}
    return {name: float(np.mean(each)) for name, each in told.items() if each}


def worst(found: Mapping[str, Error], judged_by: Sequence[str]) -> tuple[str, Error] | None:
    """The largest of those that decide."""
    deciding = [(name, found[name]) for name in judged_by if name in found]
    return max(deciding, key=lambda pair: pair[1].value, default=None)
