"""Where a sphere touches a triangulated surface, and which contact goes on from an instant ago.

Every triangle near a sphere offers its closest point (on its face, an edge or a corner).  On a
smooth surface neighbouring triangles offer nearly the same contact, so counting all of them would
make the surface stiffer at each edge.  Therefore an edge or a corner counts only where none of
its triangles comes nearer.  How those that are left share the force: smooth_patches.py.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from orchestrator.ports import Array, Indices

SAME_CONTACT = 0.5  # cosine between a contact's normals at two instants
SAME_PATCH = math.cos(math.radians(30.0))  # a new contact takes over the spring of a present one


def closest_on_triangle(point_m: Array, corners_m: Array) -> Array:
    """Barycentric weights (n, 3) of the point of triangle i closest to ``point_m`` i.

    ``point_m`` (n, 3), ``corners_m`` (n, 3, 3).  Ericson, C., Real-Time Collision Detection,
    Morgan Kaufmann 2005, section 5.1.5: the seven regions of a triangle, all points at once.
    """
    a = corners_m[:, 0]
    ab, ac, ap = corners_m[:, 1] - a, corners_m[:, 2] - a, point_m - a
    abab, abac, acac = _dot(ab, ab), _dot(ab, ac), _dot(ac, ac)
    d1, d2 = _dot(ab, ap), _dot(ac, ap)
    d3, d4, d5, d6 = d1 - abab, d2 - abac, d1 - abac, d2 - acac
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    inside = va + vb + vc  # four times the squared area
    on_ab, on_ac = d1 / abab, d2 / acac
    on_bc = (d4 - d3) / (abab - 2.0 * abac + acac)
    regions = [
        (d1 <= 0) & (d2 <= 0),  # corner a
        (d3 >= 0) & (d4 <= d3),  # corner b
        (d6 >= 0) & (d5 <= d6),  # corner c
        (vc <= 0) & (d1 >= 0) & (d3 <= 0),  # edge ab
        (vb <= 0) & (d2 >= 0) & (d6 <= 0),  # edge ac
        (va <= 0) & (d4 >= d3) & (d5 >= d6),  # edge bc
    ]
    weights = np.stack([va, vb, vc]) / inside
    places = [
        (1.0, 0.0, 0.0),
        (0.0, 1.0, 0.0),
        (0.0, 0.0, 1.0),
        (1.0 - on_ab, on_ab, 0.0),
        (1.0 - on_ac, 0.0, on_ac),
        (0.0, 1.0 - on_bc, on_bc),
    ]
    for region, place in zip(reversed(regions), reversed(places), strict=True):
        for weight, value in zip(weights, place, strict=True):
            np.copyto(weight, value, where=region)
    return np.asarray(weights.T)


def minima(sphere: Indices, corners: Indices, barycentric: Array, overlap_m: Array) -> Indices:
    """Rows of the candidates that are minima of the distance to the surface, deepest first.

    ``sphere`` (n,) whose candidate it is, ``corners`` (n, 3) points of the triangle,
    ``barycentric`` (n, 3) where on it, ``overlap_m`` (n,).
    """
    order = np.lexsort((-overlap_m, sphere))
    kept = _are_minima(sphere[order], corners[order], barycentric[order] > 0.0)
    return np.asarray(order[kept])


def _are_minima(
    sphere: Indices, corners: Indices, on_corner: npt.NDArray[np.bool_]
) -> npt.NDArray[np.bool_]:
    """Which candidates, sorted by sphere and depth, are minima of the distance to the surface.

    A triangle is convex, so the distance grows from its closest point in every direction.  A
    place on an edge or a corner is no minimum if a triangle that has that edge or corner comes
    nearer; if it comes as near, it is the same place.
    """
    minimum = np.ones(len(sphere), dtype=bool)
    for shift in range(1, len(sphere)):
        same = np.flatnonzero(sphere[shift:] == sphere[:-shift])
        if not len(same):
            break
        later = same + shift
        shared = np.any(corners[later, :, None] == corners[same, None, :], axis=2)
        minimum[later[np.all(shared | ~on_corner[later], axis=1)]] = False
    return minimum


def match_by_normal(
    now: tuple[Indices, Array], before: tuple[Indices, Array]
) -> tuple[Indices, Indices]:
    """For each contact now (n,) the row of the contact before that it continues, or -1, and the
    row of the one that it continues or comes from, or -1.

    Each side is (sphere (n,), normal (n, 3)).  Contacts of one sphere are paired by nearest
    normal, nearest first, each once, and only closer than 60 degrees.  One that is left over
    comes from the contact with the nearest normal closer than 30 degrees.
    """
    new, old = np.nonzero(now[0][:, None] == before[0][None, :])
    cosine = _dot(now[1][new], before[1][old])
    order = np.argsort(-cosine, kind="stable")
    order = order[cosine[order] > SAME_CONTACT]
    found, parent, taken = [-1] * len(now[0]), [-1] * len(now[0]), set()
    for n, o, c in zip(*(each[order].tolist() for each in (new, old, cosine)), strict=True):
        if parent[n] < 0 and c > SAME_PATCH:
            parent[n] = o
        if found[n] < 0 and o not in taken:
            found[n] = parent[n] = o
            taken.add(o)
    return np.array(found, dtype=np.int64), np.array(parent, dtype=np.int64)


def _dot(a: Array, b: Array) -> Array:
    return np.asarray(np.einsum("ij,ij->i", a, b))
