"""Young's modulus of rubber-like materials from their Shore hardness.

A hardness is measured by pressing a pin into the surface, and no formula is better than a factor of some
1.5: a measured modulus is always to be preferred.
"""

from __future__ import annotations

import math
import re

SHORE = re.compile(r"\s*(\d+(?:\.\d+)?)\s*(?:shore|sh)\s*([AD])\s*", re.IGNORECASE)
RANGES = {"A": (30.0, 95.0), "D": (30.0, 85.0)}
"""The hardness on each scale within which the formulas are used."""


def youngs_modulus_Pa(hardness: float, scale: str) -> float:
    """Return Young's modulus at small strain for a hardness on the Shore scale "A" or "D".

    On scale A, this is Gent's formula for a flat pin on an incompressible elastic half-space (Gent, A. N.,
    Rubber Chemistry and Technology 31, 1958, 896-906, doi 10.5254/1.3542351).  On scale D, it is the fit
    log10(E / MPa) = 0.0235 (S + 50) - 0.6403 (Qi, H. J., Joyce, K. and Boyce, M. C., Rubber Chemistry and
    Technology 76, 2003, 419-435, doi 10.5254/1.3547752).  Raises ValueError outside of ``RANGES``.
    """
    low, high = RANGES[scale]
    if not low <= hardness <= high:
        raise ValueError(f"is out of the range of the formula, {low:g} to {high:g} Shore {scale}")
    if scale == "D":
        return 1e6 * math.pow(10.0, 0.0235 * (hardness + 50.0) - 0.6403)
    return 1e6 * 0.0981 * (56.0 + 7.62336 * hardness) / (0.137505 * (254.0 - 2.54 * hardness))
