"""How series of settings converge: the order that is observed, and what is left of error in the finest."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from statistics import median

import numpy as np

from orchestrator.studies.accuracy.combinations import ALONE, BASE, named
from orchestrator.studies.accuracy.measured import Error, Measured, Scatter, against, errors
from orchestrator.studies.accuracy.model import Option
from orchestrator.studies.accuracy.refinement import Offer, RefinementSeries, Setting
from orchestrator.studies.criterion import Criterion

LARGEST = 6.0
CLEAN = 0.25  # of a logarithm: what a straight line may be off


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
        return float(self.constant * h**self.order)


def observed(h: Sequence[float], error: Sequence[float], reference_h: float) -> Order | None:
    """By least squares in logarithms, of errors against a run of the same family at
    ``reference_h``, whose own error is not nothing: e_i = C (h_i^p - reference^p).  With one
    halving this is Richardson's p = log2 of the ratio of successive differences (Roache, J. Fluids
    Eng. 116, 1994, 405-413, doi 10.1115/1.2910291).  Against an exact answer it is 0.

    None with fewer than two errors, or where no order from 0 to 6 is the best.
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


LEAST_SHARE = 0.01  # of the processor time, that a part must have to be compared


@dataclass(frozen=True)
class Converged:
    """``found``: what was measured of the family's settings, from coarse to fine; ``errors``
    against the finest of them, ``exact`` against what is known exactly; ``orders`` of both by
    name, where one was seen."""

    series: RefinementSeries
    found: tuple[tuple[Setting, Measured], ...]
    errors: tuple[dict[str, Error], ...]
    exact: tuple[dict[str, float], ...]
    orders: dict[str, Order]

    @property
    def finest(self) -> tuple[Setting, Measured]:
        return self.found[-1]

    @property
    def observed(self) -> float | None:
        """Median over the quantities that fall along a line."""
        clean = [one.order for one in self.orders.values() if one.clean]
        return median(clean) if clean else None

    def remaining(self, name: str) -> float:
        """Estimated error of the finest setting: from the order observed, else from the expected
        one and the last difference (Roache's estimate); 0 where neither is known."""
        setting, _ = self.finest
        order = self.orders.get(name)
        if order is not None and order.clean and setting.h:
            return order.error(setting.h)
        if self.series.expected is None or len(self.found) < 2 or not setting.h:
            return 0.0
        last, before = self.errors[-2].get(name), self.found[-2][0].h
        if last is None or not last.certain or not before:
            return 0.0
        return last.value / float((before / setting.h) ** self.series.expected - 1)


def converged(
    series: RefinementSeries, measured: Mapping[str, Measured], spread: Scatter, known: Sequence[Criterion]
) -> Converged | None:
    """None where nothing of it was measured."""
    names = ((each, named(ALONE, {series.axis: each}) if each.sets else BASE) for each in series.settings)
    found = tuple((setting, measured[name]) for setting, name in names if name in measured)
    if not found:
        return None
    _, best = found[-1]
    off = tuple(errors(there, best, spread) for _, there in found)
    exact = tuple(_exact(series, there, known) for _, there in found)
    return Converged(series, found, off, exact, _orders(found, off, exact))


def _orders(
    found: Sequence[tuple[Setting, Measured]],
    off: Sequence[dict[str, Error]],
    exact: Sequence[dict[str, float]],
) -> dict[str, Order]:
    """What chance explains is no error that an order can be seen in."""
    lengths = [one.h for one, _ in found if one.h is not None]
    if len(found) < 3 or len(lengths) < len(found):
        return {}
    orders = {}
    for name in off[0]:
        seen = [each.get(name, Error(0.0)) for each in off]
        sizes = [one.value if one.certain else 0.0 for one in seen]
        orders[name] = observed(lengths, sizes, lengths[-1])
    for name in exact[0]:
        orders[name] = observed(lengths, [each.get(name, 0.0) for each in exact], 0.0)
    return {name: order for name, order in orders.items() if order is not None}


def _exact(series: RefinementSeries, there: Measured, known: Sequence[Criterion]) -> dict[str, float]:
    """Errors against answers, and the energy that only a coupling creates."""
    found = against(there, known)
    created = there.mean("energy_defect") if series.axis == "coupling" else None
    return found if created is None else found | {"energy_defect": created}


def all_converged(
    offer: Offer, measured: Mapping[str, Measured], spread: Scatter, known: Sequence[Criterion]
) -> list[Converged]:
    """Of every family of which something was measured."""
    found = (converged(series, measured, spread, known) for series in offer.series)
    return [one for one in found if one is not None]


def best_of(axis: str, families: Sequence[Converged]) -> Converged | None:
    """The family on an axis that is nearest to the truth."""
    mine = [one for one in families if one.series.axis == axis]
    return max(mine, key=lambda one: one.series.rank, default=None)


@dataclass(frozen=True)
class Compared:
    """A setting of an axis with its ``errors`` against the best of all its settings; ``is_best``
    of that one itself."""

    series: RefinementSeries
    setting: Setting
    measured: Measured
    errors: dict[str, Error]
    is_best: bool


def compare_axis(axis: str, families: Sequence[Converged], spread: Scatter) -> list[Compared]:
    """Returns every setting of an axis that was measured, against the best of them."""
    best = best_of(axis, families)
    if best is None:
        return []
    finest, highest = best.finest
    return [
        Compared(one.series, setting, there, errors(there, highest, spread), setting is finest)
        for one in families
        if one.series.axis == axis
        for setting, there in one.found
    ]


def options(
    offer: Offer, families: Sequence[Converged], base: Measured, spread: Scatter
) -> dict[str, list[Option]]:
    """By axis; errors that chance explains count as none."""
    every: dict[str, list[Option]] = {}
    for axis in offer.axes:
        choices = {c.setting: c for c in compare_axis(axis, families, spread) if c.series.is_choice}
        if choices:
            every[axis] = [
                Option(axis, c.setting, _certain(c.errors), _ratio(c.measured, base))
                for c in choices.values()
            ]
    return every


def remaining(offer: Offer, families: Sequence[Converged], judged_by: Sequence[str]) -> dict[str, float]:
    """What errors add up to where every axis has its best setting."""
    best = [one for axis in offer.axes if (one := best_of(axis, families)) is not None]
    return {name: sum(one.remaining(name) for one in best) for name in judged_by}


def _certain(found: Mapping[str, Error]) -> dict[str, float]:
    return {name: one.value if one.certain else 0.0 for name, one in found.items()}


def _ratio(found: Measured, base: Measured) -> dict[str, float]:
    """Processor time by part; of parts that hardly count, that of the whole."""
    ours, theirs = found.processor_by_part_s, base.processor_by_part_s
    return {
        part: ours.get(part, 0.0) / theirs[part] if theirs[part] > LEAST_SHARE * base.processor_s else 1.0
        for part in theirs
    }
