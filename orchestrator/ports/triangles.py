"""Which spheres and boxes triangles reach into."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from orchestrator.ports import Array
from orchestrator.ports.geometry import closest_on_triangle

TOUCHING = 1e-9  # of a box's size: rounding where a triangle stands against its side


def overlap_m(position_m: Array, radius_m: Array, corners_m: Array) -> Array:
    """(n,): by how much spheres at ``position_m`` (n, 3) overlap the nearest of the triangles
    ``corners_m`` (m, 3, 3); no more than zero for those that overlap none."""
    from scipy.spatial import cKDTree

    deepest_m = np.zeros(len(position_m))
    if not len(position_m) or not len(corners_m):
        return deepest_m
    center_m = corners_m.mean(axis=1)
    reach_m = np.linalg.norm(corners_m - center_m[:, None], axis=2).max(axis=1) + radius_m.max()
    near = cKDTree(position_m).query_ball_point(center_m, reach_m)
    triangle = np.repeat(np.arange(len(corners_m)), [len(some) for some in near])
    sphere = np.concatenate([np.array(some, dtype=np.int64) for some in near])
    place_m, corners_m = position_m[sphere], corners_m[triangle]
    nearest_m = np.einsum("ij,ijk->ik", closest_on_triangle(place_m, corners_m), corners_m)
    distance_m = np.linalg.norm(place_m - nearest_m, axis=1)
    np.maximum.at(deepest_m, sphere, radius_m[sphere] - distance_m)
    return deepest_m


def reach_into(corners_m: Array, box_m: Array) -> npt.NDArray[np.bool_]:
    """(m,): which triangles ``corners_m`` (m, 3, 3) reach into the box ``box_m`` (2, 3: its lowest
    and highest corner).

    Two convex bodies are apart if one of these directions parts them: the normals of both and the
    products of their edges (Akenine-Moeller, T., Journal of Graphics Tools 6, 2001, 29-33,
    doi:10.1080/10867651.2001.10487535).
    """
    half_m = (box_m[1] - box_m[0]) / 2
    corners_m = (corners_m - box_m.mean(axis=0)) / half_m.max()  # sizes about one
    half = half_m / half_m.max()
    edges = np.roll(corners_m, -1, axis=1) - corners_m
    sides = np.broadcast_to(np.eye(3), (len(corners_m), 3, 3))
    normal = np.cross(edges[:, 0], edges[:, 1])[:, None]
    products = np.cross(edges[:, :, None], np.eye(3)).reshape(-1, 9, 3)
    directions = np.concatenate([sides, normal, products], axis=1)
    length = np.linalg.norm(directions, axis=2)
    reached = np.einsum("mdk,mck->mdc", directions, corners_m)
    box = np.abs(directions) @ half - TOUCHING * length
    apart = (reached.min(axis=2) > box) | (reached.max(axis=2) < -box)
    return np.asarray(~(apart & (length > 0.0)).any(axis=1))
