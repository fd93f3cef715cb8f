"""Convergence of series of settings, and predictions for settings taken together.

A series shows the observed order, and the error that remains in its finest setting.  The errors of joint
settings add up, quantity by quantity.  The processor time of each part of the program (particles, panel,
frames ...) is multiplied by the effect of each setting on it.  The study then runs the proposed settings, so
that the measurement stands beside the prediction.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, reduce
from typing import Literal

import numpy as np

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
from orchestrator.studies.criteria import Criterion
from orchestrator.workbench import RefinementSeries, Setting
from orchestrator.workbench.vocabulary import Array

LARGEST = 6.0  # the largest order that is tried
BY_CHANCE = 0.5  # an observed order that is so much above the expected one is none
MARGIN = 1.25  # of Richardson's estimate with an observed order
CLEAN = 0.25  # the largest deviation of logarithms from a straight line
LEAST_SHARE = 0.01  # the share of the processor time from which on a part is compared


@dataclass(frozen=True)
class Order:
    """The order of convergence of an error: e(h) = constant * h^order.

    ``spread`` is the standard deviation of ln(e) from this line; it is 0 with only two points.
    """

    order: float
    constant: float
    spread: float

    @property
    def is_clean(self) -> bool:
        """Whether the points lie on a line."""
        return self.spread < CLEAN

    def error(self, h: float) -> float:
        """Return the error at a length ``h``."""
        return float(self.constant * h**self.order)


def fit_order(h: Sequence[float], error: Sequence[float], reference_h: float) -> Order | None:
    """Return the order of errors, fitted by least squares in logarithms.

    The errors are differences from a run of the same series at ``reference_h``, which has an error of its
    own: e_i = C (h_i^p - reference^p).  With one halving this is Richardson's p = log2 of the ratio of
    successive differences (Roache, J. Fluids Eng. 116, 1994, 405-413, doi 10.1115/1.2910291).  Against an
    exact answer ``reference_h`` is 0.  Return None with fewer than two errors, or where the best order is not
    between 0 and 6.
    """
    at = [i for i, size in enumerate(error) if size > 0 and h[i] > reference_h]
    if len(at) < 2:
        return None
    unit = reference_h or min(h[i] for i in at)
    lengths, reference = np.array([h[i] for i in at]) / unit, reference_h / unit
    size = np.log([error[i] for i in at])
    tried = np.arange(0.02, LARGEST + 0.005, 0.01)[:, None]
    residual = size[None, :] - np.log(lengths[None, :] ** tried - reference**tried)
    spread = residual.std(axis=1)
    best = int(spread.argmin())
    if best in (0, len(tried) - 1):
        return None
    order = float(tried[best, 0])
    constant = float(np.exp(residual[best].mean()) / unit**order)
    freedom = np.sqrt(len(at) / max(1, len(at) - 2))
    return Order(order, constant, float(spread[best] * freedom))


@dataclass(frozen=True)
class MeasuredSeries:
    """A series with its measurements.

    ``settings`` are the measured settings from coarse to fine, and ``points`` their points.  ``errors`` are
    against the finest setting, and ``exact`` are errors against exact answers.
    """

    series: RefinementSeries
    settings: tuple[Setting, ...]
    points: tuple[Combination, ...]
    errors: tuple[dict[str, Error], ...]
    exact: tuple[dict[str, float], ...]

    @property
    def lengths(self) -> list[float]:
        """The length h of each setting; empty where the series has no length."""
        lengths = [setting.h for setting in self.settings if setting.h is not None]
        return lengths if len(lengths) == len(self.settings) else []

    @cached_property
    def orders(self) -> dict[str, Order]:
        """The orders by quantity, where an order is observed; errors that chance explains show no order."""
        h, orders = self.lengths, {}
        if len(h) < 3:
            return {}
        for name in self.errors[0]:
            if self._turns(name):
                continue
            seen = [each.get(name, Error(0.0)) for each in self.errors]
            orders[name] = fit_order(h, [one.value if one.is_certain else 0.0 for one in seen], h[-1])
        for name in self.exact[0]:
            orders[name] = fit_order(h, [each.get(name, 0.0) for each in self.exact], 0.0)
        return {name: order for name, order in orders.items() if order is not None}

    def _turns(self, name: str) -> bool:
        """Return whether a quantity comes to its finest value from both sides: then no order shows."""
        known = [
            (point.mean(name), each.get(name)) for point, each in zip(self.points, self.errors, strict=True)
        ]
        finest = known[-1][0]
        sides = {
            value > finest
            for value, error in known[:-1]
            if value is not None and finest is not None and error is not None and error.is_certain
        }
        return len(sides) > 1

    def is_clean(self, name: str) -> bool:
        """Return whether an order is observed of a quantity, on a line and not by chance.

        Between settings, an order far above the expected one is chance.
        """
        order, expected = self.orders.get(name), self.series.expected
        if order is None or not order.is_clean:
            return False
        return name in self.exact[0] or expected is None or order.order < expected + BY_CHANCE

    def remaining_error(self, name: str) -> float:
        """Return the estimated relative error of a quantity at the finest setting.

        With a clean order it is Richardson's, with the margin that Roache gives it (J. Fluids Eng. 116, 1994,
        405-413, doi 10.1115/1.2910291).  Else the finest setting may be off by as much as the last refinement
        changed, which is what his margin of 3 comes to for halvings of second order.  It is 0 where chance
        explains the change, and for models and statistics, which do not converge.
        """
        finest_h = self.settings[-1].h
        if self.series.layer != "numerics" or not finest_h:
            return 0.0
        if self.is_clean(name):
            return MARGIN * self.orders[name].error(finest_h)
        last = self.errors[-2].get(name) if len(self.settings) > 1 else None
        return last.value if last is not None and last.is_certain else 0.0


def measure_series(
    series: RefinementSeries, measured: Mapping[str, Combination], spread: Scatter, known: Sequence[Criterion]
) -> MeasuredSeries | None:
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
    differences = tuple(errors(point, points[-1], spread) for point in points)
    return MeasuredSeries(series, settings, points, differences, tuple(exact))


@dataclass(frozen=True)
class Option:
    """A measured setting of an axis, which may be chosen.

    ``error`` is by quantity, against the best setting of the axis.  ``ratio`` is the processor time of each
    part of the program over the time of this part in the unchanged case.
    """

    axis: str
    setting: Setting
    error: dict[str, float]
    ratio: dict[str, float]


def cost_ratio(point: Combination, base: Combination) -> dict[str, float]:
    """Return the ratio of processor times by part; it is 1 for parts that take hardly any time in both."""
    ours, theirs, least_s = (
        point.processor_by_part_s,
        base.processor_by_part_s,
        LEAST_SHARE * base.processor_s,
    )
    return {
        part: ours.get(part, 0.0) / time_s if time_s and max(time_s, ours.get(part, 0.0)) > least_s else 1.0
        for part, time_s in theirs.items()
    }


@dataclass(frozen=True)
class Proposal:
    """A proposal: one option of each axis, with the predicted error and the predicted processor time in s."""

    options: tuple[Option, ...]
    error: float
    processor_s: float

    @property
    def settings(self) -> dict[str, Setting]:
        """The settings that differ from the case as it is."""
        return {one.axis: one.setting for one in self.options if one.setting.sets}


class Model:
    """A model of the error and cost of joint settings.

    ``axes`` are the options by axis.  ``parts_s`` is the processor time of the unchanged case by part, and
    ``judged_by`` are the quantities that decide.  Errors are against the best options of all axes.
    """

    def __init__(
        self, axes: Mapping[str, list[Option]], parts_s: Mapping[str, float], judged_by: Sequence[str]
    ) -> None:
        self._axes = list(axes.values())
        errors = [[_row(one.error, judged_by) for one in axis] for axis in self._axes]
        ratios = [[_row(one.ratio, parts_s, 1.0) for one in axis] for axis in self._axes]
        lengths = [[np.log([one.setting.h or 1.0]) for one in axis] for axis in self._axes]
        error = _combined(np.add, errors, len(judged_by))
        self._worst = error.max(axis=-1, initial=0.0)
        self._length = _combined(np.add, lengths, 1)[..., 0]
        self._cost_s = _combined(np.multiply, ratios, len(parts_s)) @ _row(parts_s, parts_s)

    def cheapest(self, tolerance: float) -> Proposal | None:
        """Return the cheapest proposal with an error of at most ``tolerance``; None where there is none."""
        if not (self._worst <= tolerance).any():
            return None
        return self._proposal(int(np.where(self._worst <= tolerance, self._cost_s, np.inf).argmin()))

    def best(self, budget_s: float, ties: Literal["cheapest", "finest"]) -> Proposal | None:
        """Return the proposal with the least error within a budget; None where none is so cheap.

        ``ties`` selects among proposals of the same error.  Processor times are measured and so vary from
        run to run; the choice of the finest settings does not depend on them.
        """
        within = np.flatnonzero(self._cost_s <= budget_s)
        if not len(within):
            return None
        preferred = (self._cost_s if ties == "cheapest" else self._length).flat[within]
        return self._proposal(int(within[np.lexsort((preferred, self._worst.flat[within]))[0]]))

    def predict(self, settings: Mapping[str, Setting]) -> Proposal | None:
        """Return the proposal of these settings by axis; None where one of them is no option."""
        at = []
        for axis in self._axes:
            wanted = settings.get(axis[0].axis)
            fitting = (
                n for n, one in enumerate(axis) if (one.setting == wanted if wanted else not one.setting.sets)
            )
            at.append(next(fitting, None))
        if None in at:
            return None
        return self._proposal(int(np.arange(self._cost_s.size).reshape(self._cost_s.shape)[tuple(at)]))

    def _proposal(self, flat: int) -> Proposal:
        at = np.unravel_index(flat, self._cost_s.shape)
        chosen = tuple(axis[number] for axis, number in zip(self._axes, at, strict=True))
        return Proposal(chosen, float(self._worst[at]), float(self._cost_s[at]))


def _row(
    values: Mapping[str, float], names: Sequence[str] | Mapping[str, float], otherwise: float = 0.0
) -> Array:
    return np.array([values.get(name, otherwise) for name in names])


def _combined(how: np.ufunc, axes: list[list[Array]], width: int) -> Array:
    """Return the combined rows (n_1, n_2, ..., width) of every choice of one row from each axis."""
    start = np.full(width, how.identity, dtype=float)
    return reduce(lambda before, rows: how(before[..., None, :], np.array(rows)), axes, start)
