"""Where a sphere touches a triangulated surface: at most one contact per smooth patch.

Every triangle near a sphere offers its closest point (on its face, an edge or a corner).  On a
smooth surface neighbouring triangles offer nearly the same contact, so counting all of them would
make the surface stiffer at each edge.  Therefore the deepest is taken first, and a further one
counts by how much its normal differs from those taken: not at all up to 15 degrees, fully from
45 degrees on, with a smooth step between.  Limits: docs/theory/spheres.md.
"""

from __future__ import annotations

import math

import numpy as np

from orchestrator.ports import Array, Indices

SAME_PATCH_RAD = math.radians(15.0)
OTHER_PATCH_RAD = math.radians(45.0)


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
    zero, one = np.zeros_like(d1), np.ones_like(d1)
    to_b = np.select(regions, [zero, one, zero, on_ab, zero, 1.0 - on_bc], vb / inside)
    to_c = np.select(regions, [zero, zero, one, zero, on_ac, on_bc], vc / inside)
    return np.stack([1.0 - to_b - to_c, to_b, to_c], axis=1)


def one_per_patch(sphere: Indices, overlap_m: Array, normal: Array) -> Array:
    """Weight (n,), 0 ... 1, of each candidate contact.

    ``sphere`` (n,) whose candidate it is, ``overlap_m`` (n,) > 0, ``normal`` (n, 3) unit vectors
    from the surface to the sphere's centre.
    """
    weight = np.ones(len(sphere))
    order = np.lexsort((-overlap_m, sphere))
    while len(order):
        _, start = np.unique(sphere[order], return_index=True)
        deepest, further = order[start], np.delete(order, start)
        if not len(further):
            break
        taken = deepest[np.searchsorted(sphere[deepest], sphere[further])]
        weight[further] = np.minimum(weight[further], _otherness(normal[further], normal[taken]))
        order = further[weight[further] > 0.0]
    return weight


def _otherness(normal: Array, taken: Array) -> Array:
    """0 where two normals belong to one smooth patch, 1 where they do not."""
    angle_rad = 2.0 * np.arcsin(np.clip(np.linalg.norm(normal - taken, axis=1) / 2.0, 0.0, 1.0))
    t = np.clip((angle_rad - SAME_PATCH_RAD) / (OTHER_PATCH_RAD - SAME_PATCH_RAD), 0.0, 1.0)
    return np.asarray(t * t * (3.0 - 2.0 * t))


def match_by_normal(now: tuple[Indices, Array], before: tuple[Indices, Array]) -> Indices:
    """For each contact now the row of the contact before that it continues, or -1: (n,).

    Each side is (sphere (n,), normal (n, 3)).  Contacts of one sphere are paired by nearest
    normal, nearest first, each once, and only within ``OTHER_PATCH_RAD``.
    """
    found = np.full(len(now[0]), -1)
    new, old = np.nonzero(now[0][:, None] == before[0][None, :])
    cosine = _dot(now[1][new], before[1][old])
    order = np.argsort(-cosine, kind="stable")
    order = order[cosine[order] > math.cos(OTHER_PATCH_RAD)]
    new, old = new[order], old[order]
    while len(new):
        _, first_new = np.unique(new, return_index=True)
        _, first_old = np.unique(old, return_index=True)
        nearest = np.intersect1d(first_new, first_old)
        found[new[nearest]] = old[nearest]
        left = ~(np.isin(new, new[nearest]) | np.isin(old, old[nearest]))
        new, old = new[left], old[left]
    return found


def _dot(a: Array, b: Array) -> Array:
    return np.asarray(np.einsum("ij,ij->i", a, b))
