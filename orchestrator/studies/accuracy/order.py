"""The order with which an error goes to zero."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

LARGEST = 6.0
CLEAN = 0.25  # of a logarithm: what a straight line may be off


@dataclass(frozen=True)
class Order:
    """e(h) = constant * h^order; ``spread`` is the standard deviation of ln(e) from it, 0 where two
    points leave no freedom."""

    order: float
    constant: float
    spread: float

    @property
    def clean(self) -> bool:
        """Whether the points lie on a line."""
        return self.spread < CLEAN

    def error(self, h: float) -> float:
        return float(self.constant * h**self.order)


def observed(h: Sequence[float], error: Sequence[float], reference_h: float) -> Order | None:
    """By least squares in logarithms, of errors against a run of the same family at
    ``reference_h``, whose own error is not nothing: e_i = C (h_i^p - reference^p).  With one
    halving this is Richardson's p = log2 of the ratio of successive differences (Roache, J. Fluids
    Eng. 116, 1994, 405-413, doi 10.1115/1.2910291).  Against an exact answer it is 0.

    None with fewer than two errors, or where no order from 0 to 6 is the best.
    """
    at = [i for i, size in enumerate(error) if size > 0 and h[i] > reference_h]
    if len(at) < 2:
        return None
    unit = reference_h or min(h[i] for i in at)
    lengths, nothing = np.array([h[i] for i in at]) / unit, reference_h / unit
    size = np.log([error[i] for i in at])
    tried = np.arange(0.02, LARGEST + 0.005, 0.01)[:, None]
    off = size[None, :] - np.log(lengths[None, :] ** tried - nothing**tried)
    spread = off.std(axis=1)
    best = int(spread.argmin())
    if best in (0, len(tried) - 1):
        return None
    order = float(tried[best, 0])
    constant = float(np.exp(off[best].mean()) / unit**order)
    freedom = np.sqrt(len(at) / max(1, len(at) - 2))
    return Order(order, constant, float(spread[best] * freedom))
