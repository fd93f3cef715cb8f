"""Which spheres and triangles can touch: lists with a skin, made anew when something moved far."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from adapters.particles.spheres.state import Spheres
from orchestrator.ports import Array, Indices
from orchestrator.ports.geometry import TriangleSurface, closest_on_triangle

SKIN = 0.2  # of the largest radius


@dataclass(frozen=True)
class Neighbours:
    """Candidates: pairs of spheres (rows i < j) and of a sphere and a triangle."""

    i: Indices
    j: Indices
    sphere: Indices
    triangle: Indices
    sphere_m: Array  # positions when the lists were made
    surface_m: Array
    skin_m: float

    def outdated(self, sphere_m: Array, surface_m: Array) -> bool:
        """Whether a pair outside the lists could touch by now."""
        moved_m = _farthest(sphere_m, self.sphere_m)
        return moved_m + max(moved_m, _farthest(surface_m, self.surface_m)) >= self.skin_m


def neighbours(spheres: Spheres, surface: TriangleSurface, surface_m: Array) -> Neighbours:
    largest_m = float(np.max(spheres.radius_m, initial=0.0))
    skin_m = SKIN * largest_m
    i, j = _pairs(spheres, 2.0 * largest_m + skin_m)
    gap_m = np.linalg.norm(spheres.position_m[i] - spheres.position_m[j], axis=1)
    near = gap_m < spheres.radius_m[i] + spheres.radius_m[j] + skin_m
    sphere, triangle = near_surface(spheres, skin_m, surface_m[surface.triangles])
    return Neighbours(i[near], j[near], sphere, triangle, spheres.position_m.copy(), surface_m.copy(), skin_m)


def near_surface(spheres: Spheres, skin_m: float, corners_m: Array) -> tuple[Indices, Indices]:
    """Spheres and triangles (corners (m, 3, 3)) with a gap below ``skin_m``."""
    sphere, triangle = _boxes_near(spheres, skin_m, corners_m)
    center_m, corners_m = spheres.position_m[sphere], corners_m[triangle]
    nearest_m = np.einsum("ij,ijk->ik", closest_on_triangle(center_m, corners_m), corners_m)
    distance_m = np.linalg.norm(center_m - nearest_m, axis=1)
    near = distance_m < spheres.radius_m[sphere] + skin_m
    return sphere[near], triangle[near]


def _boxes_near(spheres: Spheres, skin_m: float, corners_m: Array) -> tuple[Indices, Indices]:
    """Those whose bounding boxes are closer than the skin."""
    reach_m = (spheres.radius_m + skin_m)[:, None]
    near = np.ones((len(spheres), len(corners_m)), dtype=bool)
    for axis in range(3):
        x = spheres.position_m[:, axis, None]
        near &= (corners_m[:, :, axis].min(axis=1) <= x + reach_m) & (
            x - reach_m <= corners_m[:, :, axis].max(axis=1)
        )
    sphere, triangle = np.nonzero(near)
    return sphere, triangle


def _pairs(spheres: Spheres, reach_m: float) -> tuple[Indices, Indices]:
    if len(spheres) < 2:
        return np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)
    found = cKDTree(spheres.position_m).query_pairs(reach_m, output_type="ndarray")
    found = found[np.lexsort((found[:, 1], found[:, 0]))].astype(np.int64)
    return found[:, 0], found[:, 1]


def _farthest(now_m: Array, then_m: Array) -> float:
    return float(np.sqrt(np.max(np.sum((now_m - then_m) ** 2, axis=1), initial=0.0)))
