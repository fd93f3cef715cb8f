"""How well the deck separates, from the masses that leave it.

``out_kg`` is always (exits, 2): the mass that left through each exit, fine (below the cut size)
and coarse.  Feed means the sum over all exits: what a steady deck gets is what leaves it.
Definitions: docs/theory/screening.md.
"""

from __future__ import annotations

import numpy as np

from orchestrator.output.results.events import OVERSIZE, UNDERSIZE, Exits
from orchestrator.ports import Array, Indices

FINE, COARSE = 0, 1


def fine_or_coarse(diameter_m: Array, cut_m: float) -> Indices:
    """``FINE`` below the cut size, else ``COARSE``."""
    return np.where(diameter_m < cut_m, FINE, COARSE)


def products_kg(out_kg: Array, exits: Exits) -> tuple[Array, Array]:
    """Undersize and oversize, each (2,): fine, coarse."""
    return (
        np.asarray(out_kg[exits.of(UNDERSIZE)].sum(axis=0)),
        np.asarray(out_kg[exits.of(OVERSIZE)].sum(axis=0)),
    )


def fine_placement(out_kg: Array, exits: Exits) -> float:
    """Share of the feed's fines that pass: the recovery of undersize."""
    under, over = products_kg(out_kg, exits)
    return share(under[FINE], under[FINE] + over[FINE])


def coarse_placement(out_kg: Array, exits: Exits) -> float:
    """Share of the feed's coarse that is held back."""
    under, over = products_kg(out_kg, exits)
    return share(over[COARSE], under[COARSE] + over[COARSE])


def efficiency(out_kg: Array, exits: Exits) -> float:
    """Fine plus coarse placement less one: 1 for a perfect screen, 0 for a mere splitter."""
    return fine_placement(out_kg, exits) + coarse_placement(out_kg, exits) - 1.0


def misplaced(out_kg: Array, exits: Exits) -> float:
    """Fines in the oversize and coarse in the undersize, over the feed."""
    under, over = products_kg(out_kg, exits)
    return share(over[FINE] + under[COARSE], float(out_kg.sum()))


def fines_in_oversize(out_kg: Array, exits: Exits) -> float:
    """Share of the oversize that is fine."""
    over = products_kg(out_kg, exits)[1]
    return share(over[FINE], float(over.sum()))


def oversize_yield(out_kg: Array, exits: Exits) -> float:
    """Oversize over feed."""
    return share(float(products_kg(out_kg, exits)[1].sum()), float(out_kg.sum()))


def section_yield(out_kg: Array, section: int) -> float:
    """What passes in a section (the number of its exit) over the feed."""
    return share(float(out_kg[section].sum()), float(out_kg.sum()))


def cumulative_efficiency(out_kg: Array, sections: Indices, last: int) -> float:
    """Fines passed in sections 0 to ``last`` (included) over the feed's fines."""
    return share(float(out_kg[sections[: last + 1], FINE].sum()), float(out_kg[:, FINE].sum()))


def local_efficiency(out_kg: Array, sections: Indices, section: int) -> float:
    """Fines passed in a section over the fines that arrive there."""
    before = float(out_kg[sections[:section], FINE].sum())
    return share(float(out_kg[sections[section], FINE]), float(out_kg[:, FINE].sum()) - before)


def share(part: float, whole: float) -> float:
    """NaN where there is nothing to share."""
    return float(part) / float(whole) if whole > 0 else float("nan")
