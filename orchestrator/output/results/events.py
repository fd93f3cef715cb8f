"""What was fed and what left, particle by particle, and the same summed over cycles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from orchestrator.ports import Array, Indices

LOST = -1
UNDERSIZE, OVERSIZE = "undersize", "oversize"


@dataclass(frozen=True)
class Fed:
    """Particles of t = 0 (with time 0) and those fed since; arrays (n,)."""

    id: Indices
    time_s: Array
    diameter_m: Array
    mass_kg: Array


@dataclass(frozen=True)
class Removed:
    """Particles that left; ``position_m`` (n, 3), ``exit`` (n,) a number, ``LOST`` = -1."""

    id: Indices
    time_s: Array
    position_m: Array
    diameter_m: Array
    mass_kg: Array
    exit: Indices


@dataclass(frozen=True)
class Exits:
    """Names and products ("undersize" or "oversize") of the exits, by number."""

    names: tuple[str, ...]
    products: tuple[str, ...]

    def of(self, product: str) -> Indices:
        """Numbers of the exits of a product, in the case's order."""
        return np.array([i for i, own in enumerate(self.products) if own == product], dtype=int)


def read(history: Any) -> tuple[Fed, Removed, Exits] | None:
    """From an open ``history.h5``; None if the run counted no particles in and out."""
    if "fed/id" not in history or "removed/id" not in history:
        return None
    fed, removed = history["fed"], history["removed"]
    exits = Exits(*(tuple(map(str, removed.attrs[key])) for key in ("names", "products")))
    return (
        Fed(fed["id"][:], fed["time_s"][:], fed["diameter_m"][:], _mass_kg(fed)),
        Removed(
            removed["id"][:],
            removed["time_s"][:],
            removed["position_m"][:],
            removed["diameter_m"][:],
            _mass_kg(removed),
            removed["exit"][:].astype(int),
        ),
        exits,
    )


def _mass_kg(table: Any) -> Array:
    return np.asarray(np.pi / 6 * table["diameter_m"][:] ** 3 * table["density_kg_per_m3"][:])


def per_cycle(time_s: Array, mass_kg: Array, edges_s: Array, group: Indices, groups: int) -> Array:
    """(cycles, groups): mass by cycle and group (a number from 0; others are not counted).
    An event on an edge belongs to the cycle that ends there, at 0 to the first."""
    cycle = np.searchsorted(edges_s, time_s, side="left") - 1
    cycle[time_s == edges_s[0]] = 0
    counted = (cycle >= 0) & (cycle < len(edges_s) - 1) & (group >= 0) & (group < groups)
    table = np.zeros((len(edges_s) - 1, groups))
    np.add.at(table, (cycle[counted], group[counted]), mass_kg[counted])
    return table
