"""The basic rating life of an exciter's roller bearings (ISO 281:2007, as SKF and NSK give it)."""

from __future__ import annotations

import math

ROLLERS = 10 / 3
"""The exponent of roller bearings; that of ball bearings is 3."""


def rating_life_h(
    dynamic_rating_N: float, load_N: float, speed_rad_per_s: float, exponent: float = ROLLERS
) -> float:
    """Return the hours at a constant load and speed that nine in ten bearings reach, L10h.

    ``load_N`` is the equivalent load of one bearing, and ``dynamic_rating_N`` its basic dynamic load rating.
    """
    per_h = 60 * speed_rad_per_s * 60 / (2 * math.pi)
    return float(1e6 / per_h * (dynamic_rating_N / load_N) ** exponent)
