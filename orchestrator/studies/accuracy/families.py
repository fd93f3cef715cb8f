"""How each family of settings converges, and what that makes of each of its settings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from statistics import median

from orchestrator.studies.accuracy.knobs import Offer
from orchestrator.studies.accuracy.measured import Error, Measured, Scatter, against, errors
from orchestrator.studies.accuracy.model import Option
from orchestrator.studies.accuracy.order import Order, observed
from orchestrator.studies.accuracy.points import BASE, KNOB, named
from orchestrator.studies.accuracy.setting import Family, Setting
from orchestrator.studies.criteria import Criterion

LEAST_SHARE = 0.01  # of the processor time, that a part must have to be compared


@dataclass(frozen=True)
class Converged:
    """``found``: what was measured of the family's settings, from coarse to fine; ``errors``
    against the finest of them, ``exact`` against what is known exactly; ``orders`` of both by
    name, where one was seen."""

    family: Family
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
        if self.family.expected is None or len(self.found) < 2 or not setting.h:
            return 0.0
        last, before = self.errors[-2].get(name), self.found[-2][0].h
        if last is None or not last.certain or not before:
            return 0.0
        return last.value / float((before / setting.h) ** self.family.expected - 1)


def measured_at(axis: str, setting: Setting, measured: Mapping[str, Measured]) -> Measured | None:
    """The point at which one axis has this setting and the others the case's own."""
    name = named(KNOB, {axis: setting}) if setting.sets else BASE
    return measured.get(name)


def converged(
    family: Family, measured: Mapping[str, Measured], spread: Scatter, known: Sequence[Criterion]
) -> Converged | None:
    """None where nothing of it was measured."""
    every = [(one, measured_at(family.axis, one, measured)) for one in family.settings]
    found = tuple((one, there) for one, there in every if there is not None)
    if not found:
        return None
    _, best = found[-1]
    off = tuple(errors(there, best, spread) for _, there in found)
    exact = tuple(_exact(family, there, known) for _, there in found)
    return Converged(family, found, off, exact, _orders(found, off, exact))


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


def _exact(family: Family, there: Measured, known: Sequence[Criterion]) -> dict[str, float]:
    """Errors against answers, and the energy that only a coupling creates."""
    found = against(there, known)
    created = there.mean("energy_defect") if family.axis == "coupling" else None
    return found if created is None else found | {"energy_defect": created}


def all_converged(
    offer: Offer, measured: Mapping[str, Measured], spread: Scatter, known: Sequence[Criterion]
) -> list[Converged]:
    """Of every family of which something was measured."""
    found = (converged(family, measured, spread, known) for family in offer.families)
    return [one for one in found if one is not None]


def best_of(axis: str, families: Sequence[Converged]) -> Converged | None:
    """The family on an axis that is nearest to the truth."""
    mine = [one for one in families if one.family.axis == axis]
    return max(mine, key=lambda one: one.family.rank, default=None)


def options(
    offer: Offer, families: Sequence[Converged], base: Measured, spread: Scatter
) -> dict[str, list[Option]]:
    """By axis; errors that chance explains count as none."""
    found: dict[str, list[Option]] = {}
    for axis in offer.axes:
        best = best_of(axis, families)
        if best is None:
            continue
        _, highest = best.finest
        settings = {
            setting: there for one in families if one.family.axis == axis for setting, there in one.found
        }
        found[axis] = [
            Option(axis, setting, _certain(errors(there, highest, spread)), _ratio(there, base))
            for setting, there in settings.items()
        ]
    return found


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
