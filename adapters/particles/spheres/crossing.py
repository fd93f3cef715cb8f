"""Spheres whose centre goes through the surface.

A contact pushes a centre back to the side that it is on; one that is on the other side came there
by contacts too soft or steps too long.  The way of the centre in a step is held against the way of
the triangles, so that who goes through an opening, past a free edge or between two panels goes
through nothing.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from adapters.particles.spheres.state import Spheres
from adapters.particles.spheres.touch import Touching
from adapters.particles.surface.triangle_spin import cross
from orchestrator.ports import Array, Indices

HALVINGS = 50  # of the way: to rounding
ROUNDING = 1e-9  # of a barycentric weight: neighbouring triangles leave no gap between them

Way = tuple[Array, Array]
"""Places before and now, of things that move evenly from one to the other."""


def crossed(
    spheres: Spheres, touching: Touching, before_m: Array, triangles: Indices, surface_m: Way
) -> Indices:
    """Rows of the spheres whose centre went through a triangle since it was at ``before_m``
    (spheres, 3), while the surface points moved along ``surface_m``; ``touching`` are the contacts
    of now."""
    # who went through a triangle is no farther from it than both have moved
    moved_m = _farthest_m(before_m, spheres.position_m) + _farthest_m(*surface_m)
    first = touching.first[touching.pairs :]
    near = spheres.radius_m[first] - touching.overlap_m[touching.pairs :] <= moved_m
    far = spheres.radius_m <= moved_m
    if not (near.any() or far.any()):
        return np.empty(0, dtype=np.int64)
    rows = np.union1d(first[near], np.flatnonzero(far))
    corners_m = (surface_m[0][triangles], surface_m[1][triangles])
    center_m = (before_m[rows], spheres.position_m[rows])
    return np.asarray(rows[_through_any(center_m, corners_m)])


def _farthest_m(before_m: Array, now_m: Array) -> float:
    """No point moved farther."""
    return float(np.sqrt(3.0) * np.abs(now_m - before_m).max(initial=0.0))


def _through_any(center_m: Way, corners_m: Way) -> npt.NDArray[np.bool_]:
    """Which centres (n, 3) end on the other side of the plane of one of the triangles (m, 3, 3),
    and were inside of the triangle when they changed sides, (n,)."""
    through = np.zeros(len(center_m[0]), dtype=bool)
    for row, (before_m, now_m) in enumerate(zip(*center_m, strict=True)):
        was_in_front = _in_front(*_at(0.0, before_m, now_m, corners_m))
        other = np.flatnonzero(_in_front(*_at(1.0, before_m, now_m, corners_m)) != was_in_front)
        if not len(other):
            continue
        was_in_front, some_m = was_in_front[other], (corners_m[0][other], corners_m[1][other])
        low, high = np.zeros(len(other)), np.ones(len(other))
        for _ in range(HALVINGS):
            middle = (low + high) / 2.0
            same = _in_front(*_at(middle, before_m, now_m, some_m)) == was_in_front
            low, high = np.where(same, middle, low), np.where(same, high, middle)
        through[row] = _inside(*_at(high, before_m, now_m, some_m)).any()
    return through


def _at(fraction: float | Array, before_m: Array, now_m: Array, corners_m: Way) -> tuple[Array, Array]:
    """Corners (m, 3, 3), seen from the point, and normals (m, 3) of the triangles on the way."""
    share = np.broadcast_to(fraction, len(corners_m[0]))[:, None]
    point_m = before_m + share * (now_m - before_m)
    seen_m = corners_m[0] + share[:, :, None] * (corners_m[1] - corners_m[0]) - point_m[:, None]
    return seen_m, cross(seen_m[:, 1] - seen_m[:, 0], seen_m[:, 2] - seen_m[:, 0])


def _in_front(seen_m: Array, normal: Array) -> npt.NDArray[np.bool_]:
    return np.asarray(np.einsum("ij,ij->i", seen_m[:, 0], normal) < 0.0)


def _inside(seen_m: Array, normal: Array) -> npt.NDArray[np.bool_]:
    least = -ROUNDING * np.einsum("ij,ij->i", normal, normal)
    a, b, c = seen_m[:, 0], seen_m[:, 1], seen_m[:, 2]
    parts = [np.einsum("ij,ij->i", cross(*edge), normal) for edge in ((a, b), (b, c), (c, a))]
    return np.asarray(np.all(parts >= least, axis=0))
