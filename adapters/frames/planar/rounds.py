"""When an iteration that converges linearly may end.

What is still wrong after a round is  q / (1 - q)  times its change, with q the last ratio of
changes; before there is one, that of the last step to the power 0.8, which forgets it slowly
(Hairer and Wanner, Solving Ordinary Differential Equations II, 2nd ed. 1996, section IV.8).
"""

from __future__ import annotations

import math

ROUNDING = 1e-15


class Rounds:
    """``begin`` before the first round of each step, ``settled`` after each round; ``ratio`` is
    all that is kept from step to step."""

    def __init__(self, tolerance: float) -> None:
        self._tolerance = tolerance
        self.ratio, self._before = 1.0, math.inf

    def begin(self) -> None:
        self.ratio, self._before = max(self.ratio, ROUNDING) ** 0.8, math.inf

    def settled(self, change: float, size: float) -> bool:
        """Whether less than the tolerance, a share of ``size``, is still wrong."""
        if self._before < math.inf and self._before > 0:
            self.ratio = change / self._before
        self._before = change
        left = change * self.ratio / (1 - self.ratio) if self.ratio < 1 else math.inf
        return change == 0 or left <= self._tolerance * size
