"""Places of a triangulated surface that a sphere touches, and how they share its force.

Every triangle near a sphere offers its closest point (on its face, an edge or a corner).  On a
smooth surface neighbouring triangles offer nearly the same contact, so counting all of them would
make the surface stiffer at each edge.  Therefore an edge or a corner counts only where none of its
triangles comes nearer (``find_minima``).

Of those that are left, two contacts i, j whose normals differ by little are one contact, seen twice;
at a sharp fold they are two.  Their elastic energies U_i ~ overlap^(5/2) are therefore joined by a
p-norm,

    U = (U_i^(1/s) + U_j^(1/s))^s,     s = 0 (one contact) ... 1 (two contacts),

and the weight of a contact is dU/dU_i, so that the force has a potential and turns without a jump
from one contact to the other (``share_force``).  Where normals turn (on edges and corners) s changes
along the way; -dU/ds grad s is then a force, too.  Theory and limits:
docs/theory/particle_surface_contact.md.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from orchestrator.ports import Array, Indices

SMOOTH = math.cos(math.radians(15.0))
SHARP = math.cos(math.radians(45.0))
SHARPEST = 1e7  # power in the p-norm: on folds below 0.04 degrees rounding would set weights
NEGLIGIBLE = 1e-12  # a weight that rounding would swallow


def find_minima(sphere: Indices, corners: Indices, barycentric: Array, overlap_m: Array) -> Indices:
    """Find the rows of the candidates that are minima of the distance to the surface, deepest first.

    ``sphere`` (n,) whose candidate it is, ``corners`` (n, 3) points of the triangle, ``barycentric``
    (n, 3) where on it, ``overlap_m`` (n,).  A triangle is convex, so the distance grows from its
    closest point in every direction.  A place on an edge or a corner is no minimum if a triangle that
    has that edge or corner comes nearer; if it comes as near, it is the same place.
    """
    order = np.lexsort((-overlap_m, sphere))
    sphere, corners, on_corner = sphere[order], corners[order], barycentric[order] > 0.0
    minimum = np.ones(len(sphere), dtype=bool)
    for shift in range(1, len(sphere)):
        same = np.flatnonzero(sphere[shift:] == sphere[:-shift])
        if not len(same):
            break
        later = same + shift
        shared = np.any(corners[later, :, None] == corners[same, None, :], axis=2)
        minimum[later[np.all(shared | ~on_corner[later], axis=1)]] = False
    return np.asarray(order[minimum])


@dataclass(frozen=True)
class Places:
    """Places of spheres next to the surface, one row each, sorted by sphere and depth.

    ``sphere`` (n,) whose place it is, ``overlap_m`` (n,), ``distance_m`` (n,) of the sphere's
    centre, ``normal`` (n, 3) unit vectors to it, ``corners_m`` (n, 3, 3) of the triangle,
    ``inside`` (n, 3): which corners carry the place (three: its face, two: an edge).
    """

    sphere: Indices
    overlap_m: Array
    distance_m: Array
    normal: Array
    corners_m: Array
    inside: npt.NDArray[np.bool_]


def share_force(places: Places) -> tuple[Array, Array]:
    """Return the weight (n,), 0 ... 1, of each place, and the force (n, 3) of its turning normal.

    That force goes through the sphere's centre and is meant for an energy of overlap^(5/2): its
    unit is m^(3/2).
    """
    weight, turning = np.ones(len(places.sphere)), np.zeros((len(places.sphere), 3))
    if not np.any(places.sphere[1:] == places.sphere[:-1]):
        return weight, turning
    _, first, count = np.unique(places.sphere, return_index=True, return_counts=True)
    slot, crowded = np.arange(count.max()), np.flatnonzero(count > 1)
    filled = slot < count[crowded, None]
    row = np.where(filled, first[crowded, None] + slot, first[crowded, None])
    some_weight, toward = _share(places.overlap_m[row], places.normal[row], filled)
    weight[row[filled]] = some_weight[filled]
    turning[row[filled]] = toward[filled]
    weight[weight < NEGLIGIBLE] = 0.0
    return weight, _turning(places, turning)


def _share(overlap_m: Array, normal: Array, filled: npt.NDArray[np.bool_]) -> tuple[Array, Array]:
    """Weights (m, c) of c places of m spheres, and dU/d(normal) of the energy by s, (m, c, 3).

    ``overlap_m`` (m, c), deepest first, ``normal`` (m, c, 3), ``filled`` (m, c): is there a place?
    """
    pair = filled[:, :, None] & filled[:, None, :] & ~np.eye(filled.shape[1], dtype=bool)
    s, slope = _separation(normal)
    power = 1.0 / np.maximum(s, 1.0 / SHARPEST)
    # log (U_j / U_i)^(1/s); beyond contact only the nearest counts
    beyond = -1e4 * np.arange(1, filled.shape[1] + 1)
    log_m = np.where(overlap_m > 0.0, np.log(np.maximum(overlap_m, 1e-300)), beyond)
    log_y = np.clip(2.5 * power * (log_m[:, None, :] - log_m[:, :, None]), -600.0, 600.0)
    y = np.exp(log_y)
    alone = np.where(pair, (1.0 + y) ** (s - 1.0), 1.0)  # weight of i if there is only j
    lost = np.where(pair, -np.expm1((s - 1.0) * np.log1p(y)), 0.0)  # 1 - alone
    heard = _heard(alone)
    first = (1.0 - heard * lost).prod(axis=2)
    # what i lost to j is a part of j's weight: with it, what each contact sees adds up to one
    seen = first + np.einsum("mij,mj->mi", lost / alone.transpose(0, 2, 1), first)
    weight = first / np.maximum(seen, 1e-300)
    energy = weight * np.maximum(overlap_m, 0.0) ** 2.5
    entropy = np.log1p(y) - y / (1.0 + y) * log_y  # dU/ds = U * entropy
    push = (energy[:, :, None] + energy[:, None, :]) * entropy * slope
    push *= np.where(pair, heard * heard.transpose(0, 2, 1), 0.0)
    return weight, np.einsum("mij,mjk->mik", push, normal)


def _heard(alone: Array) -> Array:
    """Return how much j counts for i, (m, c, c): less if a third one has more of j's force than j."""
    mine = np.where(alone < 0.5, 4.0 * alone * (1.0 - alone), 1.0)
    third = ~np.eye(alone.shape[1], dtype=bool)[:, None, :]  # k may be all but i
    return np.asarray(np.where(third, mine[:, None, :, :], 1.0).prod(axis=3))


def _separation(normal: Array) -> tuple[Array, Array]:
    """s between normals i and j of each sphere, and -ds / d(cosine of their angle): (m, c, c).

    Below 15 degrees s = -log2 cos(angle / 2): in the middle of a valley the force of both contacts
    together, 2^s cos(angle / 2), is then that of one.  From 15 to 45 degrees it grows to 1 with a
    smooth step in the cosine.
    """
    between = normal[:, :, None] - normal[:, None, :]
    half_sine2 = np.minimum((between**2).sum(axis=3) / 4.0, (1.0 - SHARP) / 2.0)
    even = -np.log1p(-half_sine2) / math.log(4.0)
    t = np.clip((SMOOTH - 1.0 + 2.0 * half_sine2) / (SMOOTH - SHARP), 0.0, 1.0)
    left = 1.0 - t * t * (3.0 - 2.0 * t)
    slope = left / ((1.0 - half_sine2) * math.log(16.0))
    slope += (1.0 - even) * 6.0 * t * (1.0 - t) / (SMOOTH - SHARP)
    return 1.0 - (1.0 - even) * left, slope


def _turning(places: Places, toward: Array) -> Array:
    """Gradient (n, 3), by the sphere's centre, of normal . ``toward``: 0 on a face, and along an
    edge the normal does not turn."""
    free = toward - np.einsum("ij,ij->i", toward, places.normal)[:, None] * places.normal
    on_edge = np.flatnonzero(places.inside.sum(axis=1) == 2)
    ends_m = places.corners_m[on_edge][places.inside[on_edge]].reshape(-1, 2, 3)
    along = ends_m[:, 1] - ends_m[:, 0]
    along /= np.linalg.norm(along, axis=1)[:, None]
    free[on_edge] -= np.einsum("ij,ij->i", free[on_edge], along)[:, None] * along
    free[places.inside.all(axis=1)] = 0.0
    return np.asarray(free / places.distance_m[:, None])
