"""Convergence of series of settings, and predictions for settings taken together.

A series shows the order that is observed, and the error that remains in its finest setting.  The errors of
settings taken together add up, quantity by quantity; the processor time of each part of the program
(particles, panel, frames ...) is multiplied by the effect of each setting on it.  The study then runs the
proposed settings, so that a prediction stands beside the measurement.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, reduce
from statistics import median
from typing import Literal

import numpy as np

from orchestrator.ports import Array
from orchestrator.studies.accuracy.combinations import (
    ALONE,
    BASE,
    Combination,
    Error,
    Scatter,
    answer_errors,
    errors,
    folder_name,
)
from orchestrator.studies.accuracy.refinement import RefinementSeries, Setting
from orchestrator.studies.criteria import Criterion

LARGEST = 6.0
CLEAN = 0.25  # of a logarithm: what a straight line may be off
LEAST_SHARE = 0.01  # of the processor time, that a part must have to be compared


@dataclass(frozen=True)
class Order:
    """e(h) = constant * h^order; ``spread`` is the standard deviation of ln(e) from it, 0 where two
    points leave no freedom."""

    order: float
    constant: float
    spread: float

    @property
    def clean(self) -> bool:
        """Whether the points lie on a line."""
        return self.spread < CLEAN

    def error(self, h: float) -> float:
        """Return the error at a length."""
        return float(self.constant * h**self.order)


def fit_order(h: Sequence[float], error: Sequence[float], reference_h: float) -> Order | None:
    """Return the order by least squares in logarithms, of errors against a run of the same series at
    ``reference_h``, whose own error is not nothing: e_i = C (h_i^p - reference^p).

    With one halving this is Richardson's p = log2 of the ratio of successive differences (Roache, J.
    Fluids Eng. 116, 1994, 405-413, doi 10.1115/1.2910291).  Against an exact answer ``reference_h`` is
    0.  None with fewer than two errors, or where no order from 0 to 6 is the best.
    """
    at = [i for i, size in enumerate(error) if size > 0 and h[i] > reference_h]
    if len(at) < 2:
        return None
    unit = reference_h or min(h[i] for i in at)
    lengths, nothing = np.array([h[i] for i in at]) / unit, reference_h / unit
    size = np.log([error[i] for i in at])
    tried = np.arange(0.02, LARGEST + 0.005, 0.01)[:, None]
    off = size[None, :] - np.log(lengths[None, :] ** tried - nothing**tried)
    spread = off.std(axis=1)
    best = int(spread.argmin())
    if best in (0, len(tried) - 1):
        return None
    order = float(tried[best, 0])
    constant = float(np.exp(off[best].mean()) / unit**order)
    freedom = np.sqrt(len(at) / max(1, len(at) - 2))
    return Order(order, constant, float(spread[best] * freedom))


@dataclass(frozen=True)
class Converged:
    """A series of which something was measured.

    ``settings``, with their ``points``, from coarse to fine; ``errors`` against the finest of them,
    ``exact`` against what is known exactly; ``orders`` of both by name, where one was seen.
    """

    series: RefinementSeries
    settings: tuple[Setting, ...]
    points: tuple[Combination, ...]
    errors: tuple[dict[str, Error], ...]
    exact: tuple[dict[str, float], ...]

    @property
    def lengths(self) -> list[float]:
        """The length h of each setting; none where the series has no length."""
        lengths = [setting.h for setting in self.settings if setting.h is not None]
        return lengths if len(lengths) == len(self.settings) else []

    @cached_property
    def orders(self) -> dict[str, Order]:
        """The orders by quantity; errors that chance explains show no order."""
        h, orders = self.lengths, {}
        if len(h) < 3:
            return {}
        for name in self.errors[0]:
            seen = [each.get(name, Error(0.0)) for each in self.errors]
            orders[name] = fit_order(h, [one.value if one.certain else 0.0 for one in seen], h[-1])
        for name in self.exact[0]:
            orders[name] = fit_order(h, [each.get(name, 0.0) for each in self.exact], 0.0)
        return {name: order for name, order in orders.items() if order is not None}

    @property
    def observed(self) -> float | None:
        """The median order over the quantities that fall along a line."""
        clean = [one.order for one in self.orders.values() if one.clean]
        return median(clean) if clean else None

    def remaining(self, name: str) -> float:
        """Return the estimated error of the finest setting.

        It follows from the observed order, else from the expected order and the last difference (Roache's
        estimate); it is 0 where neither is known.
        """
        finest_h, order = self.settings[-1].h, self.orders.get(name)
        if order is not None and order.clean and finest_h:
            return order.error(finest_h)
        if self.series.expected is None or len(self.settings) < 2 or not finest_h:
            return 0.0
        last, before_h = self.errors[-2].get(name), self.settings[-2].h
        if last is None or not last.certain or not before_h:
            return 0.0
        return last.value / float((before_h / finest_h) ** self.series.expected - 1)


def measure_series(
    series: RefinementSeries, measured: Mapping[str, Combination], spread: Scatter, known: Sequence[Criterion]
) -> Converged | None:
    """Return a series with its measurements; None where nothing was measured."""
    names = {
        setting: folder_name(ALONE, {series.axis: setting}) if setting.sets else BASE
        for setting in series.settings
    }
    settings = tuple(setting for setting, name in names.items() if name in measured)
    if not settings:
        return None
    points = tuple(measured[names[setting]] for setting in settings)
    exact = []
    for point in points:
        created = point.mean("energy_defect") if series.axis == "coupling" else None
        of_coupling = {} if created is None else {"energy_defect": created}
        exact.append(answer_errors(point, known) | of_coupling)
    off = tuple(errors(point, points[-1], spread) for point in points)
    return Converged(series, settings, points, off, tuple(exact))


@dataclass(frozen=True)
class Option:
    """A setting that was measured: error by quantity against the best setting of its axis, and the ratio of
    the processor time of each part to that of the case as it is."""

    axis: str
    setting: Setting
    error: dict[str, float]
    ratio: dict[str, float]


def cost_ratio(point: Combination, base: Combination) -> dict[str, float]:
    """Return the ratio of processor times by part, and 1 for parts that hardly count."""
    ours, theirs = point.processor_by_part_s, base.processor_by_part_s
    return {
        part: ours.get(part, 0.0) / theirs[part] if theirs[part] > LEAST_SHARE * base.processor_s else 1.0
        for part in theirs
    }


@dataclass(frozen=True)
class Proposal:
    """A proposal with an option of each axis."""

    options: tuple[Option, ...]
    error: float
    processor_s: float

    @property
    def settings(self) -> dict[str, Setting]:
        """The settings that differ from the case as it is."""
        return {one.axis: one.setting for one in self.options if one.setting.sets}


class Model:
    """A model of error and cost.

    ``axes``: options by axis; ``parts_s``: processor time of the case as it is, by part; ``remaining``: error
    by quantity that even the best options have.
    """

    def __init__(
        self,
        axes: Mapping[str, list[Option]],
        parts_s: Mapping[str, float],
        remaining: Mapping[str, float],
        judged_by: Sequence[str],
    ) -> None:
        self._axes = list(axes.values())
        errors = [[_row(one.error, judged_by) for one in axis] for axis in self._axes]
        ratios = [[_row(one.ratio, parts_s, 1.0) for one in axis] for axis in self._axes]
        lengths = [[np.log([one.setting.h or 1.0]) for one in axis] for axis in self._axes]
        error = _combined(np.add, errors, len(judged_by)) + _row(remaining, judged_by)
        self._worst = error.max(axis=-1, initial=0.0)
        self._length = _combined(np.add, lengths, 1)[..., 0]
        self._cost_s = _combined(np.multiply, ratios, len(parts_s)) @ _row(parts_s, parts_s)

    def cheapest(self, tolerance: float) -> Proposal | None:
        """Return the cheapest proposal with an error of at most ``tolerance``; None where there is none."""
        if not (self._worst <= tolerance).any():
            return None
        return self._proposal(int(np.where(self._worst <= tolerance, self._cost_s, np.inf).argmin()))

    def best(self, budget_s: float, ties: Literal["cheapest", "finest"]) -> Proposal | None:
        """Return the proposal of the least error for at most so much processor time; None where none is so
        cheap.

        Times are measured, so the finest setting must not be chosen by them.
        """
        within = np.flatnonzero(self._cost_s <= budget_s)
        if not len(within):
            return None
        preferred = (self._cost_s if ties == "cheapest" else self._length).flat[within]
        return self._proposal(int(within[np.lexsort((preferred, self._worst.flat[within]))[0]]))

    def _proposal(self, flat: int) -> Proposal:
        at = np.unravel_index(flat, self._cost_s.shape)
        chosen = tuple(axis[number] for axis, number in zip(self._axes, at, strict=True))
        return Proposal(chosen, float(self._worst[at]), float(self._cost_s[at]))


def _row(
    values: Mapping[str, float], names: Sequence[str] | Mapping[str, float], otherwise: float = 0.0
) -> Array:
    return np.array([values.get(name, otherwise) for name in names])


def _combined(how: np.ufunc, axes: list[list[Array]], width: int) -> Array:
    """Return (n_1, n_2, ..., width) of every choice of one row from each axis."""
    start = np.full(width, how.identity, dtype=float)
    return reduce(lambda before, rows: how(before[..., None, :], np.array(rows)), axes, start)
