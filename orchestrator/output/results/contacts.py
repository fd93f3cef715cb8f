"""Why so much of the fines passes: time over the deck, contacts with the mat, and the chance of each.

Efficiency is residence times contacts times chance.  Each contact of a fine particle with the open mat was
counted, and the time that it spent over each panel, so that nothing here is a formula but the geometric
chance.  docs/theory/screening.md has the definitions.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
import numpy.typing as npt
from scipy.optimize import least_squares

from orchestrator.case.deck.openings import straight_passing
from orchestrator.figures.estimate import Estimate
from orchestrator.figures.material import Contacts, ContactSizes, PanelContacts, RateFit
from orchestrator.output.results.estimate import share
from orchestrator.output.results.events import UNDERSIZE, Events, EventTable, sums_by
from orchestrator.output.results.screening import size_classes
from orchestrator.ports import Array, Indices
from orchestrator.ports.geometry import AperturePattern

FEWEST = 100
"""Least number of fines that left, for a table of their contacts."""
OVER, CONTACTS, WITHIN, PASSED, GEOMETRIC = range(5)
"""The last axis of ``Fines.sums``."""


@dataclass(frozen=True)
class Fines:
    """The n fine particles that left, in the averaged cycles, over the panels of a deck.

    ``counted`` (removed,) is the mask of them among all particles that left.
    Each counts with the mass for which it stands (``Events.left_kg``), which is the mass of ``removed``.
    ``passed_at`` (n, panels) tells through which panel each one passed, which is that of its last contact.
    ``geometric`` (n, panels) is the chance that a sphere which falls straight onto a panel touches nothing.
    """

    removed: EventTable
    passed_at: npt.NDArray[np.bool_]
    geometric: Array
    counted: npt.NDArray[np.bool_]

    @staticmethod
    def of(events: Events, cut_m: float, openings: Sequence[AperturePattern | None]) -> Fines:
        """Return the fines that left through an exit; ``openings`` are those of the panels along the deck."""
        fine = events.left_in_window & (events.removed.sieve_size_m < cut_m)
        removed = replace(events.removed.part(fine), mass_kg=events.left_kg[fine])
        passed = np.isin(removed.exit, events.exits.of(UNDERSIZE))
        passed_at = passed[:, None] & (removed.last_panel[:, None] == np.arange(len(openings)))
        return Fines(removed, passed_at, geometric_chance(removed.sieve_size_m, openings), fine)

    def __len__(self) -> int:
        return len(self.removed.id)

    @cached_property
    def sums(self) -> Array:
        """The sums by mass (n, panels, 5): kg s over a panel, kg of contacts, kg s within reach, kg passed,
        and kg of contacts times their geometric chance."""
        own = self.removed
        counted = (
            own.over_s,
            own.contacts,
            own.within_reach_s,
            self.passed_at,
            own.contacts * self.geometric,
        )
        return np.asarray(own.mass_kg[:, None, None] * np.stack(counted, axis=2))

    @cached_property
    def came_kg(self) -> Array:
        """The mass of each particle at each panel to which, or beyond which, it came, (n, panels)."""
        there = (self.removed.over_s > 0) | (self.removed.contacts > 0)
        came = np.maximum.accumulate(there[:, ::-1], axis=1)[:, ::-1]
        return np.asarray(came * self.removed.mass_kg[:, None])

    @cached_property
    def stay_s(self) -> Array:
        """The mean time (panels,) over each panel, by mass, of those that came to it and went on; 0 where
        none did."""
        went_on_kg = self.came_kg * ~self.passed_at
        return ratio((went_on_kg * self.removed.over_s).sum(axis=0), went_on_kg.sum(axis=0), 0.0)


def ratio(part: Array, whole: Array, otherwise: float = np.nan) -> Array:
    """Return ``part`` over ``whole``, of the same shape, and ``otherwise`` where the latter is 0."""
    return np.divide(part, whole, out=np.full(np.shape(whole), otherwise), where=whole > 0)


def geometric_chance(size_m: Array, openings: Sequence[AperturePattern | None]) -> Array:
    """Return the chance (n, panels) that a sphere which falls straight onto a panel touches nothing."""
    chance = np.zeros((len(size_m), len(openings)))
    for panel, pattern in enumerate(openings):
        if pattern is not None:
            alike = openings.index(pattern)
            chance[:, panel] = (
                [straight_passing(pattern, float(d)) for d in size_m] if alike == panel else chance[:, alike]
            )
    return chance


def figures(sums: Array) -> dict[str, Array]:
    """Return the figures of sums (..., 5): contacts a second, the share of time within reach, the chance of a
    contact and its geometric one, and the rate of passing."""
    over, contacts, within, passed, geometric = np.moveaxis(sums, -1, 0)
    return {
        "contacts_per_s": ratio(contacts, over),
        "within_reach_percent": 100.0 * ratio(within, over),
        "chance_percent": 100.0 * ratio(passed, contacts),
        "geometric_percent": 100.0 * ratio(geometric, contacts),
        "rate_per_s": ratio(passed, over),
    }


def rebuilt(mass_kg: Array, chance: Array, contacts_per_s: Array, stay_s: Array) -> float:
    """Return the share by mass that passes if contacts come at random, as often on a panel for all sizes.

    ``mass_kg`` and ``chance`` (classes,) are of the sizes, ``contacts_per_s`` and ``stay_s`` (panels,) of the
    panels: of each size  exp(-chance sum(contacts_per_s stay_s))  stays above.
    """
    contacts = float(np.nan_to_num(contacts_per_s) @ stay_s)
    return share(float(mass_kg @ -np.expm1(-chance * contacts)), float(mass_kg.sum()))


def fit_rate(time_s: Array, passed: Array) -> tuple[float, float]:
    """Return the rate k of 1 - exp(-k t) that fits shares passed (n,) after times (n,) best,
    by least squares, and the root mean square of what is left."""

    def off(rate_per_s: float) -> Array:
        return np.asarray(-np.expm1(-rate_per_s * time_s) - passed)

    found = least_squares(lambda rate: off(rate[0]), [1.0 / float(np.mean(time_s))], bounds=(0.0, np.inf))
    return float(found.x[0]), float(np.sqrt(np.mean(off(found.x[0]) ** 2)))


def contacts(
    events: Events, cut_m: float, names: Sequence[str], openings: Sequence[AperturePattern | None]
) -> Contacts | str:
    """Return why so much of the fines passes; the reason if there is no such table.

    ``names`` and ``openings`` are those of the panels along the deck.
    """
    fines = Fines.of(events, cut_m, openings)
    if len(fines) < FEWEST:
        return f"{len(fines)} fine particles left; their contacts need {FEWEST}"
    by_panel = fines.sums.sum(axis=0)
    if not by_panel[:, PASSED].any():
        return "no fine particle passed after a contact"
    if not fines.stay_s.any():
        return "all fine particles that left had passed: nothing tells how long others stay"
    edges = size_classes(fines.removed.sieve_size_m, cut_m)
    size = np.clip(np.searchsorted(edges, fines.removed.sieve_size_m, side="right") - 1, 0, len(edges) - 2)
    fine_kg = float(fines.removed.mass_kg.sum())
    passed = by_panel[:, PASSED].cumsum() / fine_kg
    elapsed_s = fines.stay_s.cumsum()
    fitted_per_s, rms = fit_rate(elapsed_s, passed)
    along = {
        "came_percent": 100.0 * fines.came_kg.sum(axis=0) / fine_kg,
        "stay_s": fines.stay_s,
        **figures(by_panel),
        "passed_percent": 100.0 * passed,
    }
    return Contacts(
        particles=len(fines),
        counted_percent=float(100.0 * passed[-1]),
        rebuilt_percent=100.0 * _rebuilt(fines, size, len(edges) - 1),
        **_whole_deck(events, fines),
        along=[
            PanelContacts(panel=name, **{key: float(values[place]) for key, values in along.items()})
            for place, name in enumerate(names)
        ],
        fit=RateFit(
            rate_per_s=fitted_per_s,
            rms_percent=100.0 * rms,
            time_s=elapsed_s,
            passed_percent=100.0 * -np.expm1(-fitted_per_s * elapsed_s),
        ),
        sizes=_sizes(fines, size, len(edges) - 1),
    )


def _rebuilt(fines: Fines, size: Indices, classes: int) -> float:
    """Return the share by mass that passes, from the tables of panels and of sizes alone."""
    table = _sizes(fines, size, classes)
    mass_kg = np.bincount(size, fines.removed.mass_kg, classes).astype(float)
    chance = np.nan_to_num(table.chance_percent) / 100.0
    return rebuilt(mass_kg, chance, figures(fines.sums.sum(axis=0))["contacts_per_s"], fines.stay_s)


def _sizes(fines: Fines, size: Indices, classes: int) -> ContactSizes:
    """Return the figures of the size classes over the whole deck."""
    sums = np.zeros((classes, fines.sums.shape[2]))
    np.add.at(sums, size, fines.sums.sum(axis=1))
    number = np.bincount(size, minlength=classes).astype(float)
    summed_m = np.bincount(size, fines.removed.sieve_size_m, classes).astype(float)
    return ContactSizes(mean_m=ratio(summed_m, number), particles=number, **figures(sums))


def _whole_deck(events: Events, fines: Fines) -> dict[str, Estimate]:
    """Return the figures of all panels together, and the mean stay over them of the fines that did not pass,
    as estimates."""
    own, over = fines.removed, ~fines.passed_at.any(axis=1)
    sums = fines.sums.sum(axis=1)
    stay = np.where(over, own.mass_kg, 0.0)
    columns = np.column_stack([sums, stay * own.over_s.sum(axis=1), stay])
    part = events.part[fines.counted]
    cycles = np.hstack([sums_by(part, events.parts, column) for column in columns.T])

    def of_contacts(name: str, kg: Array) -> float:
        return float(figures(kg[: len(sums[0])])[name])

    estimates = {name: events.figure(partial(of_contacts, name), cycles) for name in figures(sums[0])}
    return estimates | {"stay_s": events.figure(lambda kg: share(kg[-2], kg[-1]), cycles)}
