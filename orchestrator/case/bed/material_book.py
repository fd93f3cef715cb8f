"""The book of all particles: how many were fed, are on the deck, left through an exit or were lost.

The balance  fed = on deck + through exits + lost  holds exactly for the number of particles, and the
book checks it.  It holds for their mass to rounding, because particles keep size and density.
"""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from orchestrator.case.bed.feed import Fed, Feeds, RateFeed
from orchestrator.case.tables.numerics import MonitorSettings
from orchestrator.ports import Crossings, Indices, Overlaps, ParticleSnapshot, Removed, Saved
from orchestrator.ports.plans import ExitPlan, SolverFailed
from orchestrator.ports.state import SavedAttributes, as_arrays, like

LOG = logging.getLogger("flipflow")
LEAST_SHARE = 0.5  # An inlet that takes less than this share of the mass due in ``jam_s`` is jammed.
FEW_PARTICLES = 5.0  # A backlog of no more than so many of the largest particles is no jam.


class MaterialMonitor:
    """A monitor of the particles' whereabouts, which works at output times on rank 0.

    It warns once about each event, or raises SolverFailed if the case wants to stop.  ``widest_m`` is
    the side of the largest square that fits into an opening; None if there are no openings.
    """

    def __init__(self, wanted: MonitorSettings, widest_m: float | None = None) -> None:
        self._wanted, self._widest_m = wanted, widest_m
        self._before: dict[str, deque[tuple[float, float, float]]] = {}
        self._warned: set[str] = set()

    def lost(self, removed: Removed) -> None:
        """Report particles that left the domain elsewhere than through an exit."""
        for row in (removed.exit < 0).nonzero()[0]:
            place = ", ".join(f"{x:.4g}" for x in removed.position_m[row])
            what = (
                f"particle {removed.id[row]} ({1e3 * removed.grains.sieve_size_m[row]:.3g} mm) is lost: it "
                f"left the domain at ({place}) m at t = {removed.time_s[row]:.6g} s, through the "
                "surface or past the exits"
            )
            self._report("lost", what, self._wanted.lost_particles)

    def too_large(self, removed: Removed, exits: Sequence[ExitPlan]) -> Indices:
        """Return the rows of the removed particles in the undersize that fit through no opening."""
        if self._widest_m is None:
            return np.empty(0, dtype=np.int64)
        # The last entry belongs to lost particles, whose exit is -1.
        undersize = np.array([*(plan.product == "undersize" for plan in exits), False])
        return np.flatnonzero(undersize[removed.exit] & (removed.grains.sieve_size_m > self._widest_m))

    def escaped(self, removed: Removed, exits: Sequence[ExitPlan]) -> None:
        """Report particles in the undersize that fit through no opening; the message names the first."""
        for row in self.too_large(removed, exits)[:1]:
            what = (
                f"particle {removed.id[row]} ({1e3 * removed.grains.sieve_size_m[row]:.3g} mm) came out "
                f'through exit "{exits[removed.exit[row]].name}" at t = {removed.time_s[row]:.6g} s'
                f", although no opening is wider than {1e3 * (self._widest_m or 0):.3g} mm: "
                "contacts so soft that it was squeezed through "
                "(particles.largest_youngs_modulus_Pa), or a way out beside the panels"
            )
            self._report("escaped", what, self._wanted.escaped_particles)

    def feed(self, time_s: float, feed: RateFeed) -> None:
        """Report a feed that takes too little of the mass due; a lag of a few particles is no jam."""
        name, largest_kg = feed.inlet.name, feed.inlet.largest_kg
        before = self._before.setdefault(name, deque())
        before.append((time_s, feed.due_kg, feed.fed_kg))
        while len(before) > 1 and before[1][0] <= time_s - self._wanted.jam_s:
            before.popleft()
        then_s, then_due_kg, then_fed_kg = before[0]
        due_kg, fed_kg = feed.due_kg - then_due_kg, feed.fed_kg - then_fed_kg
        long_enough = time_s - then_s >= self._wanted.jam_s * (1.0 - 1e-9)
        if long_enough and due_kg - fed_kg > max((1.0 - LEAST_SHARE) * due_kg, FEW_PARTICLES * largest_kg):
            what = (
                f'feed "{name}" is jammed: of {due_kg:.3g} kg due in the last '
                f"{time_s - then_s:.3g} s it took {fed_kg:.3g} kg, up to t = {time_s:.6g} s; "
                "something fills its box (bed.feeds), or the rate is too large for it"
            )
            self._report(f"jam {name}", what, self._wanted.jammed_feed)

    def save(self) -> Saved:
        """Return the state of the monitor for a checkpoint."""
        before = {name: np.array(rows) for name, rows in self._before.items()}
        return {"before": before, "said": np.array(sorted(self._warned), dtype=str)}

    def restore(self, saved: Saved) -> None:
        """Restore the state of the monitor from a checkpoint."""
        self._before = {
            name: deque((time_s, due_kg, fed_kg) for time_s, due_kg, fed_kg in rows.tolist())
            for name, rows in saved["before"].items()
        }
        self._warned = set(saved["said"].tolist())

    def _report(self, key: str, what: str, then: str) -> None:
        """Warn of an event, or raise SolverFailed if ``then`` is "stop"."""
        if then == "stop":
            raise SolverFailed(what)
        if key not in self._warned:  # One warning is enough, because the summary has the numbers.
            LOG.warning(what)
            self._warned.add(key)


@dataclass
class Amount:
    """The number of particles and their mass, as ``summary.json`` has them."""

    number: int = 0
    mass_kg: float = 0.0

    def add(self, particles: Fed | Removed | ParticleSnapshot, rows: Any = slice(None)) -> None:
        """Add these rows of the particles, by default all."""
        grains = particles.grains.part(rows)
        self.number += len(grains)
        self.mass_kg += float(np.sum(grains.mass_kg))


class MaterialBook(SavedAttributes):
    """The totals since t = 0, which are updated at output times on rank 0.

    The state of the ``feed`` is saved with the particles that it feeds.
    """

    STATE = ("fed", "on_deck", "lost", "escaped", "deepest", "crossings")
    PARTS = ("_monitor",)

    def __init__(self, feed: Feeds, exits: tuple[ExitPlan, ...], monitor: MaterialMonitor) -> None:
        self.feed, self.exits, self._monitor = feed, exits, monitor
        self.fed, self.on_deck, self.lost = Amount(), Amount(), Amount()
        self.escaped = Amount()  # These particles are also counted at their exits.
        self.through = [Amount() for _ in exits]
        self.deepest, self.crossings = Overlaps(), Crossings.none()

    def add(self, time_s: float, fed: Fed, removed: Removed, present: ParticleSnapshot) -> None:
        """Add the particles that were fed and removed since the last output time, and count those present.

        Raises SolverFailed if a particle is not accounted for, or if the monitor stops the run.
        """
        self.fed.add(fed)
        self.lost.add(removed, removed.exit < 0)
        self.escaped.add(removed, self._monitor.too_large(removed, self.exits))
        for number, amount in enumerate(self.through):
            amount.add(removed, removed.exit == number)
        self.on_deck = Amount()
        self.on_deck.add(present)
        gone = self.lost.number + sum(amount.number for amount in self.through)
        missing = self.fed.number - gone - self.on_deck.number
        if missing:
            raise SolverFailed(
                f"{missing} of {self.fed.number} particles are not accounted for at t = "
                f"{time_s:.6g} s: {self.on_deck.number} are there and {gone} were removed"
            )
        self._monitor.lost(removed)
        self._monitor.escaped(removed, self.exits)
        for feed in self.feed.feeds:
            self._monitor.feed(time_s, feed)

    def look_at_contacts(self, overlaps: Overlaps, crossings: Crossings) -> None:
        """Take in the deepest overlaps since the last call, and all crossings of the surface since t = 0."""
        self.deepest, self.crossings = self.deepest.deepest(overlaps), crossings

    def save(self) -> Saved:
        """Return the totals and the monitor's state for a checkpoint."""
        through = {str(number): as_arrays(amount) for number, amount in enumerate(self.through)}
        return super().save() | {"through": through}

    def restore(self, saved: Saved) -> None:
        """Restore the totals and the monitor's state from a checkpoint."""
        super().restore(saved)
        self.through = [like(amount, saved["through"][str(n)]) for n, amount in enumerate(self.through)]

    def figures(self) -> dict[str, Any]:
        """Return the totals as a table of ``summary.json``."""
        return {
            "fed": asdict(self.fed),
            "on_deck": asdict(self.on_deck),
            "lost": asdict(self.lost),
            "escaped": asdict(self.escaped),
            "deepest_overlaps": self.deepest.figures(),
            "crossings": self.crossings.figures(),
            "feeds": {
                feed.inlet.name: {"due_kg": feed.due_kg, "fed_kg": feed.fed_kg} for feed in self.feed.feeds
            },
            "exits": {
                plan.name: {"product": plan.product, **asdict(amount)}
                for plan, amount in zip(self.exits, self.through, strict=True)
            },
        }
