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


def minima(sphere: Indices, corners: Indices, barycentric: Array, overlap_m: Array) -> Indices:
    """Rows of the candidates that are minima of the distance to the surface, deepest first.

    ``sphere`` (n,) whose candidate it is, ``corners`` (n, 3) points of the triangle,
    ``barycentric`` (n, 3) where on it, ``overlap_m`` (n,).
    """
    order = np.lexsort((-overlap_m, sphere))
    kept = _are_minima(sphere[order], corners[order], barycentric[order] > 0.0)
    return np.asarray(order[kept])


def _are_minima(sphere: Indices, corners: Indices, on_corner: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
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


def match_by_normal(now: tuple[Indices, Array], before: tuple[Indices, Array]) -> tuple[Indices, Indices]:
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
