"""The formatting of numbers for readers: three digits, confidence intervals, and units of time."""

from __future__ import annotations

import math
from typing import Protocol

NONE = "–"
DIGITS = 3
MOST_DIGITS = 5  # of a value with a very narrow interval
LEAST = 1e-9  # smaller numbers are rounding


class HasInterval(Protocol):
    """A value with half the width of its interval, each None where it is not known."""

    @property
    def value(self) -> float | None:
        """The value."""

    @property
    def half_width(self) -> float | None:
        """Half the width of its interval."""


def number(value: float | None, scale: float = 1.0, digits: int = DIGITS) -> str:
    """Return a number with ``digits`` significant digits; very small or large numbers get an exponent."""
    if value is None or not math.isfinite(value):
        return NONE
    scaled = value * scale
    if abs(scaled) < LEAST:
        return "0"
    if not 1e-4 <= abs(scaled) < 1e7:
        return f"{scaled:.{digits - 1}e}".replace("-", "−")
    decimals = max(digits - 1 - math.floor(math.log10(abs(scaled))), 0)
    return f"{scaled:.{decimals}f}".replace("-", "−")


def whole_number(value: float) -> str:
    """Return a number without decimals."""
    return f"{value:.0f}".replace("-", "−")


def interval(estimate: HasInterval | None, scale: float = 1.0) -> str:
    """Return an estimate such as "82.31 ± 0.42", rounded to the second digit of its half width."""
    if estimate is None or estimate.value is None:
        return NONE
    width, size = estimate.half_width, abs(estimate.value * scale)
    if width is None or size < LEAST:
        return number(estimate.value, scale)
    half_width = max(abs(width * scale), LEAST)
    most = MOST_DIGITS - 1 - math.floor(math.log10(size))
    decimals = max(min(1 - math.floor(math.log10(half_width)), most), 0)
    text = f"{estimate.value * scale:.{decimals}f} ± {half_width:.{decimals}f}"
    return text.replace("-", "−")


def duration(seconds: float) -> str:
    """Return a duration in seconds, minutes or hours, with its unit."""
    if seconds < 120:
        return f"{number(seconds)} s"
    if seconds < 7200:
        return f"{seconds / 60:.0f} min"
    return f"{seconds / 3600:.1f} h"
