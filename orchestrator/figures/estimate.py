"""An estimate: a value with the half width of its interval."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any


@dataclass(frozen=True)
class Estimate:
    """A value with the half width of its 95 % confidence interval.

    ``value`` is None if it is not defined, and ``half_width`` if it cannot be estimated; ``reason`` then says
    why.  ``batches`` is the number of batches behind it.  ``counting`` is the standard deviation of a share
    that its number of particles alone explains; it is None for what is no share.  ``standard_error`` is the
    standard deviation of the value; it is None where nothing is left to chance.
    """

    value: float | None
    half_width: float | None = None
    batches: int = 0
    counting: float | None = None
    standard_error: float | None = None
    reason: str = ""

    def as_json(self) -> dict[str, Any]:
        """Return the estimate as a table, without what it does not tell."""
        table = {"value": self.value, "half_width": self.half_width, "batches": self.batches}
        told = {
            "counting": self.counting,
            "standard_error": self.standard_error,
            "reason": self.reason or None,
        }
        return table | {name: value for name, value in told.items() if value is not None}

    def times(self, factor: float) -> Estimate:
        """Return the estimate of a multiple."""
        names = ("value", "half_width", "counting", "standard_error")
        sizes = {name: getattr(self, name) for name in names}
        return replace(self, **{name: size and factor * size for name, size in sizes.items()})
