"""Spheres whose centre goes through the surface.

A contact pushes a centre back to the side that it is on; one that is on the other side came there
by contacts too soft or steps too long.  The way of the centre in a step is held against the way of
the triangles, so that who goes through an opening, past a free edge or between two panels goes
through nothing.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from orchestrator.ports import Array, Indices
from tests.reference.spheres.contacts import Contacts
from tests.reference.spheres.spheres import Spheres
from tests.reference.spheres.triangle_spin import cross

HALVINGS = 50  # of the way: to rounding
ROUNDING = 1e-9  # of a barycentric weight: neighbouring triangles leave no gap between them

Way = tuple[Array, Array]
"""Places before and now, of things that move evenly from one to the other."""


def find_crossings(
    spheres: Spheres, contacts: Contacts, before_m: Array, triangles: Indices, surface_m: Way
) -> Indices:
    """Find the rows of the spheres whose centre went through a triangle since it was at ``before_m``
    (spheres, 3), while the surface points moved along ``surface_m``; ``contacts`` are those of now."""
    # who went through a triangle is no farther from it than both have moved
    moved_m = _farthest_m(before_m, spheres.position_m) + _farthest_m(*surface_m)
    near = (contacts.second < 0) & (contacts.distance_m <= moved_m)
    far = spheres.radius_m <= moved_m
    if not (near.any() or far.any()):
        return np.empty(0, dtype=np.int64)
    rows = np.union1d(contacts.first[near], np.flatnonzero(far))
    corners_m = (surface_m[0][triangles], surface_m[1][triangles])
    through = [_goes_through(before_m[row], spheres.position_m[row], corners_m) for row in rows]
    return np.asarray(rows[np.array(through, dtype=bool)], dtype=np.int64)


def _farthest_m(before_m: Array, now_m: Array) -> float:
    """No point moved farther."""
    return float(np.sqrt(3.0) * np.abs(now_m - before_m).max(initial=0.0))


def _goes_through(before_m: Array, now_m: Array, corners_m: Way) -> bool:
    """Return whether a centre ends on the other side of the plane of one of the triangles (m, 3, 3), and
    was inside of the triangle when it changed sides."""
    was_in_front = _is_in_front(*_seen_at(0.0, before_m, now_m, corners_m))
    other = np.flatnonzero(_is_in_front(*_seen_at(1.0, before_m, now_m, corners_m)) != was_in_front)
    was_in_front, some_m = was_in_front[other], (corners_m[0][other], corners_m[1][other])
    low, high = np.zeros(len(other)), np.ones(len(other))
    for _ in range(HALVINGS if len(other) else 0):
        middle = (low + high) / 2.0
        same = _is_in_front(*_seen_at(middle, before_m, now_m, some_m)) == was_in_front
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return bool(_is_inside(*_seen_at(high, before_m, now_m, some_m)).any())


def _seen_at(fraction: float | Array, before_m: Array, now_m: Array, corners_m: Way) -> tuple[Array, Array]:
    """Corners (m, 3, 3), seen from the point, and normals (m, 3) of the triangles on the way."""
    share = np.broadcast_to(fraction, len(corners_m[0]))[:, None]
    point_m = before_m + share * (now_m - before_m)
    seen_m = corners_m[0] + share[:, :, None] * (corners_m[1] - corners_m[0]) - point_m[:, None]
    return seen_m, cross(seen_m[:, 1] - seen_m[:, 0], seen_m[:, 2] - seen_m[:, 0])


def _is_in_front(seen_m: Array, normal: Array) -> npt.NDArray[np.bool_]:
    return np.asarray(np.einsum("ij,ij->i", seen_m[:, 0], normal) < 0.0)


def _is_inside(seen_m: Array, normal: Array) -> npt.NDArray[np.bool_]:
    least = -ROUNDING * np.einsum("ij,ij->i", normal, normal)
    a, b, c = seen_m[:, 0], seen_m[:, 1], seen_m[:, 2]
    parts = [np.einsum("ij,ij->i", cross(*edge), normal) for edge in ((a, b), (b, c), (c, a))]
    return np.asarray(np.all(parts >= least, axis=0))
