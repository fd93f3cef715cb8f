"""Constants and formulas of physics that every room shares."""

from __future__ import annotations

import math
from typing import TypeVar

import numpy as np
import numpy.typing as npt

Number = TypeVar("Number", float, npt.NDArray[np.float64])

STANDARD_GRAVITY_M_PER_S2 = 9.80665
"""The acceleration that is called 1 g (3rd General Conference on Weights and Measures, 1901)."""


def sphere_volume_m3(diameter_m: Number) -> Number:
    """Returns the volume of a sphere, or of each of several, from the diameter in m."""
    return math.pi / 6 * diameter_m**3


def sphere_mass_kg(diameter_m: Number, density_kg_per_m3: Number | float) -> Number:
    """Returns the mass of a sphere, or of each of several, from diameter in m and density in kg/m3."""
    return math.pi / 6 * density_kg_per_m3 * diameter_m**3
