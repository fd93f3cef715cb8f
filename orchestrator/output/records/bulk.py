"""What the grains in a box are as a bulk: mass, density, and the slope of their free surface."""

from __future__ import annotations

import math

import numpy as np

from orchestrator.case.tables.case import Bulk
from orchestrator.ports import Array, ParticleSnapshot
from orchestrator.ports.grains import placed_spheres

POINTS = 256  # that stand for the volume of a grain
FEWEST_COLUMNS = 4  # with grains, of which a plane is fitted


def measure_bulk(bulk: Bulk, particles: ParticleSnapshot) -> dict[str, float]:
    """Return ``mass_kg`` and ``density_kg_per_m3`` in a box in world axes, and ``slope_deg`` there.

    A grain that the box cuts counts with the share of its volume inside, as a sphere of equal volume.  The
    slope is that of the plane through the highest points of columns as wide as the largest grain, by least
    squares, without grains that touch no other; NaN where fewer than four columns have grains.
    """
    low_m, high_m = np.array(bulk.box_m)
    reach_m = particles.grains.bounding_radius_m[:, None]
    near = ((particles.position_m > low_m - reach_m) & (particles.position_m < high_m + reach_m)).all(axis=1)
    radius_m = particles.grains.equivalent_diameter_m[near] / 2
    place_m = particles.position_m[near, None] + radius_m[:, None, None] * _points_in_a_ball()
    inside = ((place_m >= low_m) & (place_m <= high_m)).all(axis=2).mean(axis=1)
    mass_kg = float(particles.grains.mass_kg[near] @ inside)
    return {
        "mass_kg": mass_kg,
        "density_kg_per_m3": mass_kg / float(np.prod(high_m - low_m)),
        "slope_deg": _slope_deg(particles, low_m, high_m),
    }


def _points_in_a_ball() -> Array:
    """Return points (n, 3) spread evenly in the unit ball: a spiral over the sphere, of equal volumes."""
    number = np.arange(POINTS) + 0.5
    height = 1 - 2 * number / POINTS
    turn = math.pi * (1 + math.sqrt(5)) * number
    level = np.sqrt(1 - height**2)
    outwards = np.cbrt((number * (math.sqrt(5) - 1) / 2) % 1)  # a sequence that covers each part alike
    return np.asarray(
        outwards[:, None] * np.column_stack([level * np.cos(turn), level * np.sin(turn), height])
    )


def _slope_deg(particles: ParticleSnapshot, low_m: Array, high_m: Array) -> float:
    grain, center_m, radius_m = placed_spheres(particles.grains, particles.position_m, particles.orientation)
    within = ((center_m >= low_m) & (center_m <= high_m)).all(axis=1)
    if particles.contacts is not None:
        within &= particles.contacts[grain] > 0
    if not within.any():
        return math.nan
    side_m = 2 * float(particles.grains.bounding_radius_m.max())
    place_m, top_m = center_m[within], center_m[within, 2] + radius_m[within]
    column = np.floor((place_m[:, :2] - low_m[:2]) / side_m).astype(np.int64)
    order = np.lexsort((top_m, column[:, 1], column[:, 0]))
    highest = order[np.append(np.any(np.diff(column[order], axis=0), axis=1), True)]
    if len(highest) < FEWEST_COLUMNS:
        return math.nan
    matrix = np.column_stack([place_m[highest, :2], np.ones(len(highest))])
    rise = np.linalg.lstsq(matrix, top_m[highest], rcond=None)[0]
    return math.degrees(math.atan(math.hypot(rise[0], rise[1])))
