"""Combinations of settings, the runs that measure them, and their differences from each other."""

from __future__ import annotations

import math
import re
import zlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property
from statistics import median

import numpy as np
from scipy.stats import t as student

from orchestrator.studies.criteria import Criterion, answer_error
from orchestrator.studies.points import CaseStudy, Point, sampling_sets
from orchestrator.workbench import Case, Metrics, Setting
from orchestrator.workbench.vocabulary import CONFIDENCE, exact, sample_s

COMPARED = tuple(name for name, quantity in Metrics.quantities.items() if not quantity.is_defect)
DECISIVE = tuple(name for name, quantity in Metrics.quantities.items() if quantity.is_decisive)
MOVING = tuple(name for name in DECISIVE if name != "clamp_rms_N")
"""The quantities that show motion.  Clamps pull while nothing happens, too, so that only a change of their
pull counts (``happens``)."""
STEADY = 1e-6
"""The share of its peak by which a pull may exceed its root mean square and still count as constant."""
BASE, ALONE, TOGETHER, REFERENCE, CALIBRATION = "base", "parameter", "diagonal", "reference", "short"
START = ("start", "rest")
"""The parts of a run's time that do not depend on the simulated time."""


def stepping_s_per_s(parts_s: Mapping[str, float], simulated_s: float) -> float:
    """Return the processor time per simulated second in s, without the start.

    ``parts_s`` is the processor time in s by part of the program.
    """
    return sum(time_s for part, time_s in parts_s.items() if part not in START) / simulated_s


def joint_sets(settings: Mapping[str, Setting]) -> tuple[str, ...]:
    """Return the ``--set`` overlays of joint settings by axis, in the order of the axes."""
    return tuple(overlay for setting in settings.values() for overlay in setting.sets)


def joint_label(settings: Mapping[str, Setting]) -> str:
    """Return joint settings by axis in words."""
    return "; ".join(f"{axis}: {setting.label}" for axis, setting in settings.items())


@dataclass(frozen=True)
class StudyRequest:
    """A user's request for a study of accuracy.

    ``values`` is the number of values of each parameter, ``seeds`` the number of runs of each point with
    different random numbers, and ``budget_s`` the largest processor time of a single run.  ``judged_by`` are
    the quantities whose errors decide.  ``keeps_model`` says whether other models are only compared, and not
    recommended.
    """

    study: CaseStudy
    parameters: tuple[str, ...]
    values: int
    seeds: int
    budget_s: float
    judged_by: tuple[str, ...]
    keeps_model: bool = False


@dataclass(frozen=True)
class Combination:
    """A combination of settings: the case with ``settings`` by axis.

    ``runs`` has a run for each seed, or ``omitted`` says why there are none.  ``metrics`` are the metrics of
    the runs, once all runs are done.
    """

    kind: str
    name: str
    settings: dict[str, Setting] = field(default_factory=dict)
    runs: tuple[Point, ...] = ()
    predicted_s: float = 0.0
    omitted: str = ""
    metrics: tuple[Metrics, ...] = ()

    @property
    def sets(self) -> tuple[str, ...]:
        """The ``--set`` overlays of the settings."""
        return joint_sets(self.settings)

    @property
    def label(self) -> str:
        """The settings, in words."""
        as_it_is = self.kind in (BASE, CALIBRATION)
        return "the case as it is" if as_it_is else joint_label(self.settings)

    @property
    def has_ended(self) -> bool:
        """Whether all runs have ended, successfully or not."""
        return bool(self.runs) and all(run.run.is_over() for run in self.runs)

    def with_metrics(self) -> Combination:
        """Return the combination with the metrics of its runs, if all runs are done."""
        if self.metrics or not self.runs or not all(run.run.is_trusted for run in self.runs):
            return self
        return replace(self, metrics=tuple(run.run.metrics() for run in self.runs))

    def values(self, name: str) -> list[float]:
        """Return the values of a quantity, one for each seed with a defined value."""
        return [of_run.values[name] for of_run in self.metrics if name in of_run.values]

    def mean(self, name: str) -> float | None:
        """Return the mean of a quantity over the seeds; None where it is not defined."""
        values = self.values(name)
        return float(np.mean(values)) if values else None

    @property
    def processor_s(self) -> float:
        """The processor time of a single run in s."""
        return self.cost["processor_s"]

    @cached_property
    def cost(self) -> dict[str, float]:
        """The times of a single run, the number of runs side by side, and the largest memory of a run.

        ``stepping_s_per_s`` is the processor time per simulated second, without the start, which takes
        ``start_s``.
        """
        summaries, parts_s = [of_run.summary for of_run in self.metrics], self.processor_by_part_s
        return {
            "stepping_s_per_s": stepping_s_per_s(parts_s, summaries[0]["simulated_s"]),
            "start_s": sum(parts_s.get(part, 0.0) for part in START),
            "processor_s": float(np.mean([summary["processor_s"] for summary in summaries])),
            "wall_s": float(np.mean([summary["wall_s"] for summary in summaries])),
            "side_by_side": max(run.side_by_side() for run in self.runs),
            "peak_memory_MiB": max(summary["peak_memory_MiB"] for summary in summaries),
        }

    @property
    def processor_by_part_s(self) -> dict[str, float]:
        """The processor time in s by part of the program, as the mean over the seeds."""
        every = [of_run.processor_by_part_s for of_run in self.metrics]
        return {part: float(np.mean([parts[part] for parts in every])) for part in every[0]}


def shared_sets(case: Case, coarsest_s: float) -> tuple[str, ...]:
    """Return the ``--set`` overlays that all points share.

    All points write at the same times, which are whole multiples of all sync intervals down from
    ``coarsest_s``, and last for a whole number of samples.  A monitor that would shorten intervals only
    warns, so that an interval has the length in its label.
    """
    every = sample_s(coarsest_s)
    shortens = [name for name, then in case.tables.monitor.model_dump().items() if then == "shorten"]
    return (
        *(f"monitor.{name}=warn" for name in shortens),
        *sampling_sets(coarsest_s),
        f"output.interval_s={_whole(exact(case.tables.output.interval_s), every)!r}",
        f"duration_s={_whole(exact(case.tables.duration_s), every)!r}",
        "checkpoint.wall_min=0.0",
    )


def _whole(time_s: Fraction, every: Fraction) -> float:
    return float(max(1, round(time_s / every)) * every)


def folder_name(kind: str, settings: dict[str, Setting]) -> str:
    """Return the name of a point's folder; the name of joint settings is a checksum."""
    if kind == ALONE:
        ((axis, setting),) = settings.items()
        return re.sub(r"[^\w.+-]+", "-", f"{axis}-{setting.label}").strip("-")
    if kind in (TOGETHER, REFERENCE):
        return f"together-{zlib.crc32(chr(10).join(joint_sets(settings)).encode()):08x}"
    return kind


def afford(points: Sequence[Combination], budget_s: float) -> list[Combination]:
    """Return the points with predicted times that are scaled by the points measured on this machine.

    A point that would take more than the budget loses its runs, unless they have ended.
    """
    factor = median([one.processor_s / one.predicted_s for one in points if one.metrics] or [1.0])
    affordable = []
    for one in points:
        scaled = replace(one, predicted_s=factor * one.predicted_s)
        spared = one.kind in (BASE, CALIBRATION) or one.omitted or one.has_ended
        if not spared and scaled.predicted_s > budget_s:
            why = f"predicted {scaled.predicted_s:.0f} s of processor time, more than --budget {budget_s:g}"
            scaled = replace(scaled, runs=(), omitted=why)
        affordable.append(scaled)
    return affordable


def part_s(case: Case, parts: int) -> float:
    """Return the duration in s of a short run.

    It lasts until all feeds have started, and then for one of ``parts`` equal parts of the remaining time.
    """
    begun_s = max((feed.start_s for feed in case.tables.bed.feeds.values()), default=0.0)
    return begun_s + (case.tables.duration_s - begun_s) / parts


@dataclass(frozen=True)
class Error:
    """A relative error, and half the width of its 95 % confidence interval.

    ``half_width`` is 0 where nothing is random, and None where it is unknown, as it is of a single seed.
    """

    value: float
    half_width: float | None = 0.0

    @property
    def is_certain(self) -> bool:
        """Whether the error is larger than chance explains; True where the interval is unknown."""
        return self.half_width is None or self.value > self.half_width

    @property
    def at_most(self) -> float:
        """The upper end of the confidence interval."""
        return self.value + (self.half_width or 0.0)


@dataclass(frozen=True)
class Scatter:
    """The scatter from seed to seed.

    ``deviation`` is the relative standard deviation by quantity, without a seed's effect on all points, and
    ``freedom`` its degrees of freedom.  Both are empty where nothing is ``random``.
    """

    random: bool
    deviation: Mapping[str, float]
    freedom: Mapping[str, int]

    def half_width(self, name: str, seeds: Sequence[int]) -> float | None:
        """Return half the width of the interval of a difference of means over these numbers of ``seeds``."""
        if not self.random:
            return 0.0
        if name not in self.deviation:
            return None
        quantile = float(student.ppf((1 + CONFIDENCE) / 2, self.freedom[name]))
        return quantile * self.deviation[name] * math.sqrt(sum(1 / n for n in seeds))


EXACT = Scatter(False, {}, {})
"""The scatter without chance: every difference counts."""


def scatter(every: Iterable[Combination], random: bool) -> Scatter:
    """Return the scatter of the points.

    Every point has the same random numbers, so that a seed's common effect on all points is no scatter
    between them: the scatter is the residual of points and seeds (randomised blocks).  All points are assumed
    to have the same scatter, so that two or three seeds each are enough.
    """
    every = list(every)
    seeds = max((len(point.metrics) for point in every), default=0)
    freedom: dict[str, int] = {}
    deviation: dict[str, float] = {}
    for name in COMPARED:
        rows = [v for point in every if len(v := point.values(name)) == seeds and np.mean(v)]
        if seeds < 2 or len(rows) < 2:
            continue
        values = np.array(rows)
        relative_to_mean = values / values.mean(axis=1, keepdims=True)
        residual = relative_to_mean - relative_to_mean.mean(axis=0)
        freedom[name] = (len(values) - 1) * (seeds - 1)
        deviation[name] = math.sqrt(float((residual**2).sum()) / freedom[name])
    return Scatter(random, deviation, freedom)


def errors(point: Combination, reference: Combination, spread: Scatter) -> dict[str, Error]:
    """Return the errors, relative to the reference, of every quantity that both points have.

    Shapes are compared seed by seed; how much of their difference is chance is not known.
    """
    seeds = (len(point.metrics), len(reference.metrics))
    differences = {}
    for name in COMPARED:
        ours, theirs = point.mean(name), reference.mean(name)
        if ours is not None and theirs:
            difference = abs(ours - theirs) / abs(theirs)
            differences[name] = Error(difference, spread.half_width(name, seeds))
    pairs = [
        a.shape_error(b)
        for a, b in zip(point.metrics, reference.metrics, strict=True)
        if a.shapes_m.size and a.shapes_m.shape == b.shapes_m.shape
    ]
    if pairs and np.isfinite(pairs).all():  # they are infinite where no panel bends
        differences["shape"] = Error(float(np.mean(pairs)), None if spread.random else 0.0)
    return differences


def happens(values: Mapping[str, float | None]) -> bool:
    """Return whether anything resolvable happens in a run with these ``values`` by name.

    Something happens if anything moves, or if the pull of a clamp changes, as it does under a particle on a
    rigid panel.
    """
    if any(
        (value := values.get(name)) is not None and abs(value) > Metrics.quantities[name].floor
        for name in MOVING
    ):
        return True
    peak_N, rms_N = values.get("clamp_peak_N"), values.get("clamp_rms_N")
    if peak_N is None or rms_N is None:
        return False
    return peak_N - rms_N > max(Metrics.quantities["clamp_peak_N"].floor, STEADY * peak_N)


def answer_errors(point: Combination, known: Sequence[Criterion]) -> dict[str, float]:
    """Return the relative errors against known answers, as means over the seeds."""
    every = {row.what: [answer_error(row, run.folder) for run in point.runs] for row in known}
    defined = {name: [x for x in each if x is not None] for name, each in every.items()}
    return {name: float(np.mean(each)) for name, each in defined.items() if each}


def worst_error(errors: Mapping[str, Error], judged_by: Sequence[str]) -> tuple[str, Error] | None:
    """Return the error that decides whose interval reaches highest, with the name of its quantity.

    Return None where one of the errors is unknown, since it may be the largest, or where none decides.
    """
    if not all(name in errors for name in judged_by):
        return None
    return max(((name, errors[name]) for name in judged_by), key=lambda pair: pair[1].at_most, default=None)
