"""What limits the sync interval or a solver's step, and the card with all limits of a case."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class Bound:
    """The longest sync interval that one effect allows.

    "stability": beyond it something grows without end.  "accuracy": beyond it the answer is
    worse than the project's own rule, but bounded.  ``interval_s`` is infinite where the effect
    sets no limit and 0 where no interval is short enough; ``source`` is where the formula comes
    from, ``why`` the case's own numbers in it, ``where`` the particles and the surface that set it.
    """

    name: str
    interval_s: float
    source: str
    why: str
    kind: Literal["stability", "accuracy"] = "stability"
    where: str = ""


@dataclass(frozen=True)
class StepBound:
    """The longest step of one solver, against the one it takes."""

    name: str
    step_s: float
    limit_s: float
    source: str
    why: str


@dataclass(frozen=True)
class Card:
    """All bounds of a case; ``facts`` are the numbers behind them, name -> text; ``why`` the
    program took the scheme, "" where the case names it."""

    scheme: str
    interval_s: float
    bounds: tuple[Bound, ...]
    steps: tuple[StepBound, ...]
    facts: Mapping[str, str]
    why: str = ""

    @property
    def stable(self) -> Bound | None:
        """The bound on stability that allows least; None if nothing limits it."""
        return self._least("stability")

    @property
    def accurate(self) -> Bound | None:
        """The bound on accuracy that allows least; None if nothing limits it."""
        return self._least("accuracy")

    @property
    def safe_s(self) -> float:
        """The largest interval within all bounds on stability."""
        return self.stable.interval_s if self.stable else math.inf

    def _least(self, kind: str) -> Bound | None:
        found = [b for b in self.bounds if b.kind == kind and math.isfinite(b.interval_s)]
        return min(found, key=lambda bound: bound.interval_s, default=None)
