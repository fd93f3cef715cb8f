"""The shares of a feed that rules of screening ask for, by mass, of the whole feed as it is given."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from orchestrator.case.bed.size_distribution import share_between
from orchestrator.case.tables.bed import SizeClass

NEAR = (0.75, 1.25)  # of the aperture: what is between is near-mesh


@dataclass(frozen=True)
class FeedShares:
    """The shares of a feed's mass at an aperture: above it, below half of it, and near-mesh."""

    oversize: float
    half_size: float
    near_mesh: float

    @property
    def undersize(self) -> float:
        """The share below the aperture."""
        return 1.0 - self.oversize


def shares_at(rows: Sequence[SizeClass], aperture_m: float) -> FeedShares:
    """Return the shares of size classes, whose mass fractions add up to 1, at an aperture."""

    def between(low_m: float, high_m: float) -> float:
        return sum(row.mass_fraction * share_between(row, low_m, high_m) for row in rows)

    low, high = NEAR
    return FeedShares(
        oversize=1.0 - between(0.0, aperture_m),
        half_size=between(0.0, aperture_m / 2),
        near_mesh=between(low * aperture_m, high * aperture_m),
    )
