"""The watch on the material: particles that get lost, and feeds that find no room."""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Sequence

import numpy as np

from orchestrator.case.bed.feed import RateFeed
from orchestrator.case.tables.numerics import MonitorSettings
from orchestrator.ports import Indices, Removed, Saved
from orchestrator.ports.plans import ExitPlan, SolverFailed

LOG = logging.getLogger("flipflow")
LEAST_SHARE = 0.5  # of what is due, that an inlet must take in ``jam_s`` or it counts as jammed
FEW_PARTICLES = 5.0  # a backlog of so many of the largest particles is none yet


class MaterialWatch:
    """Looks at output times, on rank 0.  Raises SolverFailed where the case wants that.

    ``widest_m``: the largest sphere that fits through an opening; None if there are no openings.
    """

    def __init__(self, wanted: MonitorSettings, widest_m: float | None = None) -> None:
        self._wanted, self._widest_m = wanted, widest_m
        self._before: dict[str, deque[tuple[float, float, float]]] = {}
        self._said: set[str] = set()

    def lost(self, removed: Removed) -> None:
        """Particles that left the domain elsewhere than through an exit."""
        for row in (removed.exit < 0).nonzero()[0]:
            place = ", ".join(f"{x:.4g}" for x in removed.position_m[row])
            what = (
                f"particle {removed.id[row]} ({1e3 * removed.diameter_m[row]:.3g} mm) is lost: it "
                f"left the domain at ({place}) m at t = {removed.time_s[row]:.6g} s, through the "
                "surface or past the exits"
            )
            self._say("lost", what, self._wanted.lost_particles)

    def too_large(self, removed: Removed, exits: Sequence[ExitPlan]) -> Indices:
        """Rows of the particles in the undersize that fit through no opening."""
        if self._widest_m is None:
            return np.empty(0, dtype=np.int64)
        undersize = np.array([*(one.product == "undersize" for one in exits), False])  # -1: lost
        return np.flatnonzero(undersize[removed.exit] & (removed.diameter_m > self._widest_m))

    def escaped(self, removed: Removed, exits: Sequence[ExitPlan]) -> None:
        """Particles in the undersize that fit through no opening; the first is named."""
        for row in self.too_large(removed, exits)[:1]:
            what = (
                f"particle {removed.id[row]} ({1e3 * removed.diameter_m[row]:.3g} mm) came out "
                f'through exit "{exits[removed.exit[row]].name}" at t = {removed.time_s[row]:.6g} s'
                f", although no opening is wider than {1e3 * (self._widest_m or 0):.3g} mm: "
                "contacts so soft that it was squeezed through "
                "(particles.largest_youngs_modulus_Pa), or a way out beside the panels"
            )
            self._say("escaped", what, self._wanted.escaped_particles)

    def feed(self, time_s: float, feed: RateFeed) -> None:
        """Is what is due going in?  A feed that lags by a few particles does no harm."""
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
            self._say(f"jam {name}", what, self._wanted.jammed_feed)

    def save(self) -> Saved:
        before = {name: np.array(rows) for name, rows in self._before.items()}
        return {"before": before, "said": np.array(sorted(self._said), dtype=str)}

    def restore(self, saved: Saved) -> None:
        self._before = {
            name: deque((time_s, due_kg, fed_kg) for time_s, due_kg, fed_kg in rows.tolist())
            for name, rows in saved["before"].items()
        }
        self._said = set(saved["said"].tolist())

    def _say(self, key: str, what: str, then: str) -> None:
        if then == "stop":
            raise SolverFailed(what)
        if key not in self._said:  # once; the summary has the numbers
            LOG.warning(what)
            self._said.add(key)
