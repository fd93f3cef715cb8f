"""Where LIGGGHTS's box is cut into the parts of the ranks.

A rank owns the particles in its part, so the parts should hold equally many.  LIGGGHTS by itself cuts the
box into equal boxes of the least surface: a box that is higher than long is cut in height, and all
particles lie in its lowest part.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from orchestrator.ports import Array
from orchestrator.ports.decomposition import BORDER_COST, Grid, bordering_share, grids
from orchestrator.ports.geometry import area_vectors_m2
from orchestrator.ports.plans import ParticlesPlan

Cuts = list[list[float]]
"""The fractions of the box's sides at which parts begin and end, along x, y and z."""

UNEVEN = 1.3
"""Particles on the fullest rank over the mean above which the box is cut elsewhere."""
SLICES = 4096
"""Number of slices in which particles are counted along a side."""


@dataclass(frozen=True)
class Places:
    """Where particles are or will be: positions (n, 3), with the share (n,) of all particles at each."""

    position_m: Array
    share: Array

    @classmethod
    def of_particles(cls, position_m: Array) -> Places:
        """Return the places of particles (n, 3)."""
        return cls(position_m, np.full(len(position_m), 1.0 / max(len(position_m), 1)))

    @classmethod
    def on_deck(cls, plan: ParticlesPlan) -> Places:
        """Return the middles of the surface's triangles, with their shares of the area seen along gravity."""
        corners_m = plan.surface.corners_m
        area_m2 = area_vectors_m2(corners_m)
        seen = np.abs(area_m2 @ plan.gravity_m_per_s2)
        seen = seen if seen.sum() > 0.0 else np.linalg.norm(area_m2, axis=1)
        return cls(corners_m.mean(axis=1), seen / seen.sum() if len(seen) else seen)

    def in_slices(self, corners_m: Array) -> Array:
        """Return the shares (3, SLICES) in the slices of each side of the box ``corners_m`` (2, 3)."""
        low_m, high_m = corners_m
        slices = ((self.position_m - low_m) / (high_m - low_m) * SLICES).clip(0, SLICES - 1).astype(int)
        return np.array([np.bincount(slices[:, k], self.share, minlength=SLICES) for k in range(3)])


def processor_grid(plan: ParticlesPlan, corners_m: Array, ranks: int, cutoff_m: float) -> Grid:
    """Return the grid of parts of the box ``corners_m`` (2, 3) by which the fullest rank has the least to do.

    The work of a rank is that of its own particles and, in part, of those within ``cutoff_m`` of its borders.
    It is summed over the places of the particles at the start and those of the deck, where they will lie.
    """
    stages = [Places.of_particles(plan.particles.position_m), Places.on_deck(plan)]

    def work(grid: Grid) -> float:
        return sum(_largest_work(at, grid, corners_m, cutoff_m) for at in stages if len(at.share))

    return min(grids(ranks), key=work)


def first_cuts(plan: ParticlesPlan, grid: Grid, corners_m: Array, cutoff_m: float) -> Cuts:
    """Return the cuts by which parts hold equal shares of the particles at the start or, without any, of the
    deck."""
    start = Places.of_particles(plan.particles.position_m)
    at = start if len(start.share) else Places.on_deck(plan)
    return even_cuts(at.in_slices(corners_m), grid, corners_m, cutoff_m)


def even_cuts(shares: Array, grid: Grid, corners_m: Array, cutoff_m: float) -> Cuts:
    """Return cuts by which the parts along each side hold equal parts of ``shares`` (3, SLICES).

    Each part is at least as wide as ``cutoff_m`` where the side has room for that, so that no particle
    flies over one between two listings of neighbours.
    """
    cuts: Cuts = []
    fractions = np.linspace(0.0, 1.0, SLICES + 1)
    for parts, share, side_m in zip(grid, shares, corners_m[1] - corners_m[0], strict=True):
        below = np.concatenate(([0.0], np.cumsum(share)))
        below += 1e-9 * (below[-1] + 1.0) * fractions  # grows strictly
        number = np.arange(parts + 1)
        even = np.interp(number / parts * below[-1], below, fractions)
        narrowest = min(cutoff_m / side_m, 1.0 / parts)
        even = narrowest * number + np.maximum.accumulate(even - narrowest * number)
        from_end = narrowest * (parts - number)
        cuts.append(np.minimum(even, 1.0 - from_end).tolist())
        cuts[-1][0], cuts[-1][-1] = 0.0, 1.0
    return cuts


def cuts_on_the_way(now: Cuts, wanted: Cuts) -> Cuts:
    """Return the cuts nearest to ``wanted`` between the middles of the parts on either side of each cut
    ``now``: particles go to ranks side by side only."""
    steps = []
    for here, there in zip(now, wanted, strict=True):
        middle = 0.5 * (np.array(here[1:]) + np.array(here[:-1]))
        steps.append([0.0, *np.clip(there[1:-1], middle[:-1], middle[1:]).tolist(), 1.0])
    return steps


def _largest_work(at: Places, grid: Grid, corners_m: Array, cutoff_m: float) -> float:
    """Return the work of the fullest rank over that of a rank with the mean number of particles."""
    cuts = even_cuts(at.in_slices(corners_m), grid, corners_m, cutoff_m)
    fraction = ((at.position_m - corners_m[0]) / (corners_m[1] - corners_m[0])).clip(0.0, 1.0)
    share, _ = np.histogramdd(fraction, [np.array(cut) for cut in cuts], weights=at.share)
    part_m = (np.ptp(at.position_m, axis=0) + cutoff_m) / grid
    bordering = bordering_share(part_m, grid, cutoff_m)
    return float(share.max()) * math.prod(grid) * (1.0 + BORDER_COST * bordering)
