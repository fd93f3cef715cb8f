"""How a box of particles is divided into the parts of MPI ranks, and what its borders cost."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

Grid = tuple[int, int, int]
"""Numbers of parts along x, y and z."""

BORDER_COST = 0.5
"""Cost of a particle of another rank near the border over that of an own one: its place comes in every step,
and its contacts with own particles are computed on both ranks.  It is an estimate."""


def grids(ranks: int) -> Iterator[Grid]:
    """Yield all grids of so many parts.

    Examples
    --------
    >>> list(grids(2))
    [(1, 1, 2), (1, 2, 1), (2, 1, 1)]
    """
    for x in range(1, ranks + 1):
        for y in range(1, ranks // x + 1):
            if ranks % (x * y) == 0:
                yield x, y, ranks // (x * y)


def bordering_share(part_m: Sequence[float], grid: Grid, reach_m: float) -> float:
    """Return the volume within ``reach_m`` of a part's borders with others, over the part's own volume.

    ``part_m`` are the sides of a part, and parts at the ends of the grid have one border less along a side.

    Examples
    --------
    >>> bordering_share((1.0, 1.0, 1.0), (2, 1, 1), 0.1)  # one border
    0.1
    """
    parts = np.array(grid)
    borders = 2.0 * (parts - 1) / parts
    return round(float(np.prod(1.0 + borders * reach_m / np.array(part_m))) - 1.0, 12)
