"""The typical size distribution of a feed of which only the smallest and the largest size are known.

The share finer than a size d of a feed from 0 to D is (d / D)^n (Schuhmann, AIME Technical Publication
1189, 1940), with the exponent n of the material in the library; n = 0.5 is the curve of Fuller and Thompson
(Transactions of the American Society of Civil Engineers 59, 1907, 67-143).  A feed from which sizes below a
size were removed has what is left of it.
"""

from __future__ import annotations

import numpy as np

from orchestrator.case.file.sieve_analysis import OPEN_END

FINEST = 0.01
"""Smallest point of a curve from 0, over the largest size."""
POINTS = 11

Points = tuple[tuple[float, float], ...]
"""Diameters in m, from fine to coarse, and the shares of the mass that are finer."""


def typical_feed(smallest_m: float, largest_m: float, exponent: float) -> Points:
    """Return the points of the typical curve between two sizes, from a share of 0 to one of 1.

    A ``smallest_m`` below ``FINEST`` of the largest counts as 0: what is finer than ``FINEST`` of the largest
    is then spread as below the finest sieve of a sieve analysis.
    """
    open_m = FINEST * largest_m
    is_open = smallest_m < open_m
    sizes_m = np.geomspace(open_m if is_open else smallest_m, largest_m, POINTS)
    least = 0.0 if is_open else (smallest_m / largest_m) ** exponent
    shares = ((sizes_m / largest_m) ** exponent - least) / (1.0 - least)
    points = [
        (float(f"{size_m:.4g}"), round(float(share), 4))
        for size_m, share in zip(sizes_m, shares, strict=True)
    ]
    lowest = [(float(f"{OPEN_END * open_m:.4g}"), 0.0)] if is_open else []
    return (*lowest, *points)


def finer_share(points: Points, size_m: float) -> float:
    """Return the share of the mass that is finer than a size."""
    sizes_m, shares = zip(*points, strict=True)
    return float(np.interp(size_m, sizes_m, shares))
