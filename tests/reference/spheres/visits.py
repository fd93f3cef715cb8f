"""The contacts of each sphere with the deck, panel by panel, and its time over and within reach of it.

``Removed`` has the definitions.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from orchestrator.ports import Array, Indices
from orchestrator.ports.plans import DeckPlan

if TYPE_CHECKING:
    from tests.reference.spheres.bodies import Bodies

Mask = npt.NDArray[np.bool_]
OVER = 0.25  # diameters of gap at which a contact is over


@dataclass
class Visits:
    """Counts of n spheres: (n,), or (n, panels).

    ``touched``: a panel since the last sync point; ``counted``: the contact that is going on.
    """

    touched: Mask
    counted: Mask
    last_panel: Indices
    contacts: Indices
    over_s: Array
    within_reach_s: Array

    @staticmethod
    def of(spheres: int, panels: int) -> Visits:
        """Return the visits of new spheres."""
        flags = np.zeros((2, spheres), dtype=bool)
        seconds = np.zeros((2, spheres, panels))
        return Visits(*flags, np.full(spheres, -1), np.zeros((spheres, panels), dtype=np.int64), *seconds)

    def part(self, rows: Mask) -> Visits:
        """Return the visits of some spheres."""
        return Visits(**{name: values[rows] for name, values in vars(self).items()})

    def renumbered(self, row: Indices, spheres: int) -> Visits:
        """Return the visits with sphere i in row ``row[i]`` of now ``spheres``, gone if negative."""
        new, stays = Visits.of(spheres, self.contacts.shape[1]), row >= 0
        for name, values in vars(self).items():
            getattr(new, name)[row[stays]] = values[stays]
        return new

    def observe(self, deck: DeckPlan, surface_m: Array, spheres: Bodies, length_s: float) -> None:
        """Look at the spheres at the end of an interval of ``length_s``."""
        panel, height_m, inside, is_open = _locate(deck, surface_m, spheres.position_m)
        half_m = deck.half_depths_m[panel]
        through = height_m < -half_m - spheres.radius_m
        gap_m = height_m - half_m - spheres.radius_m
        self._count(inside & (through | (self.touched & is_open)), panel)
        over = np.flatnonzero(inside & ~through)
        self.over_s[over, panel[over]] += length_s
        near = over[gap_m[over] < deck.reach_m]
        self.within_reach_s[near, panel[near]] += length_s
        self.counted &= self.touched | (gap_m < OVER * 2.0 * spheres.radius_m)
        self.touched[:] = False

    def passed(self, deck: DeckPlan, surface_m: Array, spheres: Bodies, passes: Mask) -> None:
        """Count a contact of those that leave through an exit below the deck without one that is going on."""
        panel, _, inside, _ = _locate(deck, surface_m, spheres.position_m)
        self._count(passes & inside, panel)

    def _count(self, begins: Mask, panel: Indices) -> None:
        new = np.flatnonzero(begins & ~self.counted)
        self.contacts[new, panel[new]] += 1
        self.last_panel[new] = panel[new]
        self.counted[new] = True


def _locate(deck: DeckPlan, surface_m: Array, position_m: Array) -> tuple[Indices, Array, Mask, Mask]:
    """Return panel and height over the line, and who is over the deck and over its perforated parts, (n,)."""
    line_m = surface_m[deck.points]
    u, z = np.maximum.accumulate(line_m @ deck.along), line_m[:, 2]
    at, y = position_m @ deck.along, position_m @ deck.across
    piece = np.clip(np.searchsorted(u, at) - 1, 0, len(u) - 2)
    slope = np.arctan2(np.diff(z), np.diff(u))[piece]
    height_m = (position_m[:, 2] - np.interp(at, u, z)) * np.cos(slope)
    panel, station_m = deck.panel[piece], np.interp(at, u, deck.station_m)
    low_m, high_m, left_m, right_m = deck.open_m[panel].T
    is_open = (station_m >= low_m) & (station_m <= high_m) & (y >= left_m) & (y <= right_m)
    return panel, height_m, (at >= u[0]) & (at <= u[-1]), is_open
