"""The screening area that the factors of the Vibrating Screen Manufacturers Association ask for.

    area = undersize in the feed / (A B C F G H J)

A is the basic capacity of square openings for a feed with 25 % oversize and 40 % half-size, of 100 lb/ft3,
at an efficiency of 95 %; B, C, F, G, H and J stand for oversize, half-size, bulk density, open area, shape
of the openings and efficiency.  The factors D (lower decks) and E (sprays) are 1 here.  VSMA, Vibrating
Screen Handbook, "Factors for calculating screen area"; docs/designers-sheet.md says which copies of its
tables could be read.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from orchestrator.ports import Array
from orchestrator.preflight.sheet.feed_shares import FeedShares

INCH_M = 0.0254
SHORT_TON_PER_FT2_H = 2000 * 0.45359237 / 0.3048**2 / 3600  # in kg/m2 s
STANDARD_KG_PER_M3 = 100 * 0.45359237 / 0.3048**3
OPENING_INCH = (
    1 / 32, 1 / 16, 3 / 32, 1 / 8, 3 / 16, 1 / 4, 3 / 8, 1 / 2, 5 / 8, 3 / 4,
    7 / 8, 1.0, 1.25, 1.5, 1.75, 2.0, 2.5, 2.75, 3.0, 3.5, 4.0,
)  # fmt: skip
CAPACITY = (
    0.39, 0.58, 0.76, 0.95, 1.27, 1.60, 2.08, 2.47, 2.82, 3.08,
    3.38, 3.56, 3.89, 4.20, 4.51, 4.90, 5.52, 5.85, 6.17, 7.03, 7.69,
)  # fmt: skip
"""Factor A in short tons per hour and square foot, at ``OPENING_INCH``."""
OPEN_AREA = (
    0.41, 0.37, 0.45, 0.40, 0.45, 0.46, 0.51, 0.54, 0.59, 0.61,
    0.63, 0.64, 0.66, 0.69, 0.68, 0.71, 0.72, 0.74, 0.74, 0.77, 0.75,
)  # fmt: skip
"""Open area of the cloth of factor A."""
OVERSIZE = (
    1.21, 1.13, 1.08, 1.02, 1.00, 0.96, 0.92, 0.88, 0.84, 0.79,
    0.75, 0.70, 0.66, 0.62, 0.58, 0.53, 0.50, 0.46, 0.33,
)  # fmt: skip
"""Factor B at 5 to 95 % of oversize, in steps of 5 %."""
HALF_SIZE = (
    0.40, 0.45, 0.50, 0.55, 0.60, 0.70, 0.80, 0.90, 1.00, 1.10,
    1.20, 1.30, 1.40, 1.55, 1.70, 1.85, 2.00, 2.20, 2.40,
)  # fmt: skip
"""Factor C at 0 to 90 % of half-size, in steps of 5 %."""
EFFICIENCY = (1.90, 1.70, 1.50, 1.35, 1.15, 1.00)
"""Factor J at an efficiency of 70 to 95 %, in steps of 5 %."""
SLOT, LONG_SLOT = (3.0, 1.15), (4.0, 1.25)
"""Factor H of openings that are longer than wide by this ratio; it is 1 below."""


@dataclass(frozen=True)
class Openings:
    """The openings of a deck: their sides, and the open share of the field that has them."""

    across_m: float
    along_m: float
    open_share: float

    @property
    def smaller_m(self) -> float:
        """The smaller side, which decides what passes."""
        return min(self.across_m, self.along_m)

    @property
    def slenderness(self) -> float:
        """The larger side over the smaller one."""
        return max(self.across_m, self.along_m) / self.smaller_m


def undersize_capacity_kg_per_m2_s(
    openings: Openings, shares: FeedShares, bulk_kg_per_m3: float, efficiency: float
) -> float | None:
    """Return the mass rate of the undersize in the feed for which an area is enough, per area.

    ``efficiency`` is the share of the undersize that shall pass.  Factors beyond the ends of their tables are
    those at the ends.  The result is None for openings beyond the table.
    """
    inch = openings.smaller_m / INCH_M
    if not OPENING_INCH[0] <= inch <= OPENING_INCH[-1]:
        return None
    slot, long_slot = SLOT[0] * (1 - 1e-9), LONG_SLOT[0] * (1 + 1e-9)
    ratio = openings.slenderness
    shape = LONG_SLOT[1] if ratio > long_slot else SLOT[1] if ratio >= slot else 1.0
    factors = (
        _between(inch, OPENING_INCH, CAPACITY),
        _between(shares.oversize, np.linspace(0.05, 0.95, len(OVERSIZE)), OVERSIZE),
        _between(shares.half_size, np.linspace(0.0, 0.9, len(HALF_SIZE)), HALF_SIZE),
        bulk_kg_per_m3 / STANDARD_KG_PER_M3,
        openings.open_share / _between(inch, OPENING_INCH, OPEN_AREA),
        shape,
        _between(efficiency, np.linspace(0.70, 0.95, len(EFFICIENCY)), EFFICIENCY),
    )
    return math.prod(factors) * SHORT_TON_PER_FT2_H


def _between(at: float, points: Array | tuple[float, ...], values: tuple[float, ...]) -> float:
    """Return a table's value between its points, and beyond them that of its nearer end."""
    return float(np.interp(at, points, values))


def required_m2(
    fed_kg_per_s: float, openings: Openings, shares: FeedShares, bulk_kg_per_m3: float, efficiency: float
) -> float | None:
    """Return the area for a feed; None for openings beyond the table (``undersize_capacity_kg_per_m2_s``)."""
    capacity = undersize_capacity_kg_per_m2_s(openings, shares, bulk_kg_per_m3, efficiency)
    return None if capacity is None else fed_kg_per_s * shares.undersize / capacity
