"""Factors at which measured targets are met, with intervals, by the surrogates of one study or of several.

Before, every setting within the ranges is as probable as any other.  A setting's likelihood is that of its
targets, which are normal with their own deviation and that of the surrogates' predictions.

Source: M. C. Kennedy, A. O'Hagan, J. R. Stat. Soc. B 63 (2001) 425, doi:10.1111/1467-9868.00294, without the
discrepancy of the model; C. E. Rasmussen, C. K. I. Williams, Gaussian Processes for Machine Learning, MIT
Press 2006, section 2.2 (predictions).
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import stats

from orchestrator.studies.design.campaign import Campaign
from orchestrator.studies.design.optimisers import predict_each
from orchestrator.studies.design.space import Space
from orchestrator.studies.design.study_file import StudyError
from orchestrator.workbench import CaseProblem
from orchestrator.workbench.vocabulary import Array, did_you_mean

SETTINGS = 4096  # at which the likelihood is computed, in each round
ROUNDS = 4  # each draws where the one before found the probable settings
UNLIKELY = 12.0  # below the largest logarithm of the likelihood: left out of the next round
FOUND = 0.5  # of the width that an interval would have without targets: a factor so narrow is found
BOUND = 0.7  # correlation from which two factors are known together rather than each by itself
IMPROBABLE = 0.01  # of targets so far from all settings by chance


@dataclass(frozen=True)
class Target:
    """A measured value on the scale of the surrogate of a response, by its number in a study."""

    name: str
    response: int
    value: float
    deviation: float


@dataclass(frozen=True)
class FactorFound:
    """A factor's most likely value and interval, in its own unit."""

    name: str
    unit: str
    low: float
    likeliest: float
    high: float
    is_found: bool


@dataclass(frozen=True)
class Calibration:
    """The probable settings of the factors of all studies together.

    ``ranges`` has the ends and the unit of each factor by name.  ``x`` (n, f) are settings in these units,
    ``weight`` (n,) their probabilities, ``misses`` (n, targets) the predictions less the targets, over the
    deviation of both.
    """

    ranges: Mapping[str, tuple[float, float, str]]
    targets: tuple[str, ...]
    confidence: float
    x: Array
    weight: Array
    misses: Array

    @property
    def likeliest(self) -> dict[str, float]:
        """The most likely setting, by the factors' names."""
        return dict(zip(self.ranges, map(float, self.x[self._best]), strict=True))

    @property
    def sought(self) -> list[str]:
        """The names of the factors that are not known."""
        return [name for name, (low, high, _) in self.ranges.items() if low < high]

    @cached_property
    def _best(self) -> int:
        return int(self.weight.argmax())

    def factors(self) -> Iterator[FactorFound]:
        """Yield each factor with its interval of the study's confidence."""
        ends = np.array([1 - self.confidence, 1 + self.confidence]) / 2
        for column, (name, (least, most, unit)) in enumerate(self.ranges.items()):
            if name not in self.sought:
                continue
            order = np.argsort(self.x[:, column])
            below = np.cumsum(self.weight[order])
            low, high = self.x[order[np.searchsorted(below, ends * below[-1])], column]
            is_found = bool(high - low <= FOUND * self.confidence * (most - least))
            yield FactorFound(name, unit, float(low), self.likeliest[name], float(high), is_found)

    def bound_pairs(self) -> Iterator[tuple[str, str, float]]:
        """Yield pairs of factors that the targets tell together rather than each, with their correlation."""
        columns = [list(self.ranges).index(name) for name in self.sought]
        covariance = np.atleast_2d(np.cov(self.x[:, columns].T, aweights=self.weight))
        deviation = np.sqrt(np.diag(covariance))
        for (i, first), (j, second) in itertools.combinations(enumerate(self.sought), 2):
            correlation = float(covariance[i, j] / (deviation[i] * deviation[j]))
            if abs(correlation) >= BOUND:
                yield first, second, correlation

    def missed(self) -> list[str]:
        """Return the targets that the most likely setting misses by more than two deviations, where chance
        does not explain all misses together (chi-square test); empty where it does."""
        misses = self.misses[self._best]
        if stats.chi2.sf((misses**2).sum(), len(misses)) > IMPROBABLE:
            return []
        return [name for name, miss in zip(self.targets, misses, strict=True) if abs(miss) > 2]


def calibrate(campaigns: Sequence[Campaign], known: Mapping[str, float] | None = None) -> Calibration:
    """Find the settings at which all targets of some studies are probable; factors are one by their name.

    ``known`` has values of factors that are not sought.  Raises StudyError where no response has a target,
    ranges of one factor have nothing in common, a known value is not in its range, or nothing is sought, and
    TooFewPoints where a study has less data than its surrogate has terms.
    """
    targets = [_targets(each) for each in campaigns]
    if not any(targets):
        hint = "give target and target_deviation of what was measured"
        raise StudyError([CaseProblem(("responses",), "no response has a target", hint, kind="missing")])
    ranges = _common_ranges(campaigns)
    units: dict[str, str] = {}
    for each in campaigns:
        units |= {name: row.unit for name, row in each.study.file.factors.items()}
    for name, value in (known or {}).items():
        if name not in ranges:
            problem = CaseProblem((), f'no factor "{name}"', did_you_mean(name, ranges), file="--known")
            raise StudyError([problem])
        if not ranges[name][0] <= value <= ranges[name][1]:
            what = f"{name} = {value:g} is not between {ranges[name][0]:g} and {ranges[name][1]:g}"
            raise StudyError([CaseProblem((), what, file="--known", kind="out-of-range")])
        ranges[name] = value, value
    if all(low == high for low, high in ranges.values()):
        raise StudyError([CaseProblem((), "all factors are known: nothing is sought", file="--known")])
    low, high = np.array([*ranges.values()]).T
    space = Space(low, high)
    x, likelihood, misses = _Likelihood(campaigns, targets, tuple(ranges), space).explore()
    weight = np.exp(likelihood - likelihood.max())
    return Calibration(
        {name: (*ends, units[name]) for name, ends in ranges.items()},
        tuple(target.name for each in targets for target in each),
        campaigns[0].study.file.confidence,
        space.actual(x),
        weight / weight.sum(),
        misses,
    )


def _common_ranges(campaigns: Sequence[Campaign]) -> dict[str, tuple[float, float]]:
    """Return what the ranges of each factor have in common, by name, in the order of the studies."""
    ranges: dict[str, tuple[float, float]] = {}
    for campaign in campaigns:
        for name, row in campaign.study.file.factors.items():
            low, high = ranges.get(name, row.range)
            ranges[name] = low, high = max(low, row.range[0]), min(high, row.range[1])
            if low >= high:
                what = "the ranges of the studies have nothing in common"
                raise StudyError([CaseProblem(("factors", name, "range"), what)])
    return ranges


def _targets(campaign: Campaign) -> list[Target]:
    found = []
    for number, (name, table) in enumerate(campaign.study.file.responses.items()):
        if table.target is not None and table.target_deviation is not None:
            scale = campaign.scales[name]
            deviation = table.target_deviation * float(scale.slope(table.target))
            found.append(Target(name, number, float(scale.to_fit(table.target)), deviation))
    return found


@dataclass(frozen=True)
class _Likelihood:
    """The likelihood of settings in the common space of the factors ``names``."""

    campaigns: Sequence[Campaign]
    targets: Sequence[Sequence[Target]]
    names: tuple[str, ...]
    space: Space

    def explore(self) -> tuple[Array, Array, Array]:
        """Return settings, coded (n, f), the logarithms of their likelihoods (n,), and their misses.

        Each round draws in the box that holds all probable settings of the one before.
        """
        low, high = -np.ones(len(self.names)), np.ones(len(self.names))
        for round_number in range(ROUNDS):
            unit = self.space.sample(SETTINGS, round_number)
            x = low + (unit + 1) / 2 * (high - low)
            likelihood, misses = self.of(x)
            probable = x[likelihood > likelihood.max() - UNLIKELY]
            margin = 0.1 * np.ptp(probable, axis=0) + 1e-3 * (high - low)
            low, high = (
                np.maximum(-1, probable.min(axis=0) - margin),
                np.minimum(1, probable.max(axis=0) + margin),
            )
        return x, likelihood, misses

    def of(self, x: Array) -> tuple[Array, Array]:
        """Compute the logarithms, (n,), for coded settings (n, f), and the misses (n, targets)."""
        actual, total, misses = self.space.actual(x), np.zeros(len(x)), []
        for campaign, targets in zip(self.campaigns, self.targets, strict=True):
            if not targets:
                continue
            columns = [self.names.index(name) for name in campaign.study.file.factors]
            own = campaign.study.space.coded(actual[:, columns])
            mean, deviation = predict_each(campaign.fit_before_confirming(), own)
            for target in targets:
                both = np.hypot(deviation[target.response], target.deviation)
                miss = (mean[target.response] - target.value) / both
                total -= miss**2 / 2 + np.log(both)
                misses.append(miss)
        return total, np.array(misses).T
