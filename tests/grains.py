"""Grains of tests: spheres, and what a sphere weighs."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from orchestrator.case import solvers
from orchestrator.ports.grains import Grain, Grains, ShapeTable

SPHERE = solvers.shape("sphere")
SHAPES = ShapeTable.of([SPHERE])


def one_sphere(diameter_m: float, density_kg_per_m3: float = 1430.0, material: int = 0) -> Grain[float]:
    """A single sphere."""
    return Grain(diameter_m, density_kg_per_m3, material, 0, SHAPES)


def spheres(diameter_m: Any, density_kg_per_m3: Any = 1430.0, material: Any = 0) -> Grains:
    """Spheres of these diameters (n,), whose densities and materials may be one number for all."""
    diameter_m = np.array(diameter_m, dtype=float)
    density, number = (np.broadcast_to(each, diameter_m.shape) for each in (density_kg_per_m3, material))
    return Grain(diameter_m, density.astype(float), number.astype(np.int64), 0 * number, SHAPES)


def sphere_kg(diameter_m: Any, density_kg_per_m3: Any = 1430.0) -> Any:
    """The mass of spheres."""
    return density_kg_per_m3 * math.pi / 6 * diameter_m**3
