"""The step that moves carried particles out of surfaces, and apart where they lie too deep in each other.

A bed that settled on one deck does not fit another one exactly, and an overlap of a millimetre would throw
a particle out with some metres per second.  Particles are therefore displaced without a velocity.  In each
round, a particle in a surface is moved out of the surface, and of two particles that overlap too much
the upper one is moved, so that a whole layer is lifted in as many rounds as it has particles above each
other.  The method is position-based dynamics with a mass that falls with the height (Macklin, M., Mueller,
M., Chentanez, N. and Kim, T.-Y., ACM Transactions on Graphics 33(4), 2014, 153, section 5.2).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from orchestrator.ports import Array, Indices
from orchestrator.ports.geometry import contact_points
from orchestrator.ports.grains import placed_spheres
from orchestrator.ports.plans import ParticleList

SETTLED = 0.05
"""The largest overlap of particles taken over, as a share of the (smaller) particle's diameter."""
WANTED = SETTLED / 5  # the overlap with which a particle is left after it has been moved
ROUNDS = 1000
LEVEL = 0.3  # Pairs whose direction rises by less are beside each other, and both are moved.


def push_out(particles: ParticleList, corners_m: Array, up: Array, period_m: float = 0.0) -> ParticleList:
    """Return the particles with places at which none overlaps another or a triangle by more than ``SETTLED``.

    ``corners_m`` (m, 3, 3) are the surface's triangles, and ``up`` (3,) is the unit vector against gravity.
    Particles repeat themselves after ``period_m`` along y, unless it is 0.
    Where there is no room, overlaps remain after ``ROUNDS`` rounds; the checks of places report them.
    """
    place_m = particles.position_m.copy()
    of, center_m, radius_m = placed_spheres(particles.grains, place_m, particles.orientation)
    arm_m = center_m - place_m[of]
    for _ in range(ROUNDS):
        center_m = place_m[of] + arm_m
        moved_m = _out_of_surface(len(place_m), of, center_m, radius_m, corners_m, up)
        moved_m += _apart(len(place_m), of, center_m, radius_m, up, period_m)
        if not moved_m.any():
            break
        place_m += moved_m
    return replace(particles, position_m=place_m)


def _out_of_surface(
    count: int, of: Indices, center_m: Array, radius_m: Array, corners_m: Array, up: Array
) -> Array:
    """Return the displacement (n, 3) of each of n particles out of the triangle in which one of its spheres
    lies deepest; ``of`` (m,) has the spheres' particles."""
    moved_m = np.zeros((count, 3))
    sphere, from_surface_m = contact_points(center_m, radius_m, corners_m)
    distance_m = np.linalg.norm(from_surface_m, axis=1)
    depth_m = radius_m[sphere] - distance_m
    order = np.argsort(depth_m)  # the deepest contact of a particle is written last
    order = order[depth_m[order] > SETTLED * 2 * radius_m[sphere[order]]]
    out_m = (depth_m - WANTED * 2 * radius_m[sphere])[:, None] * _directions(from_surface_m, up)
    moved_m[of[sphere[order]]] = out_m[order]
    return moved_m


def _apart(count: int, of: Indices, center_m: Array, radius_m: Array, up: Array, period_m: float) -> Array:
    """Return the mean displacement (n, 3) of each of n particles away from those that it overlaps."""
    one, two, overlap_m = overlapping_pairs(center_m, radius_m, period_m)
    smaller_m = 2 * np.minimum(radius_m[one], radius_m[two])
    deep = (overlap_m > SETTLED * smaller_m) & (of[one] != of[two])
    one, two, overlap_m, smaller_m = one[deep], two[deep], overlap_m[deep], smaller_m[deep]
    between_m = _nearest(center_m[two] - center_m[one], period_m)
    one, two = of[one], of[two]
    direction = _directions(between_m, up)
    rise = direction @ up
    share_of_two = np.where(rise > LEVEL, 1.0, np.where(rise < -LEVEL, 0.0, 0.5))
    apart_m = (overlap_m - WANTED * smaller_m)[:, None] * direction
    moved_m, pushes = np.zeros((count, 3)), np.zeros(count)
    np.add.at(moved_m, two, share_of_two[:, None] * apart_m)
    np.add.at(moved_m, one, (share_of_two - 1.0)[:, None] * apart_m)
    np.add.at(pushes, two, share_of_two > 0)
    np.add.at(pushes, one, share_of_two < 1)
    return np.asarray(moved_m / np.maximum(pushes, 1.0)[:, None])


def _directions(vectors: Array, up: Array) -> Array:
    """Return the unit vectors (n, 3) along ``vectors``; ``up`` for a vector without a length."""
    length = np.linalg.norm(vectors, axis=1)[:, None]
    return np.where(length > 0, vectors / np.maximum(length, 1e-300), up)


def _nearest(vectors_m: Array, period_m: float) -> Array:
    """Return vectors (n, 3) between particles to the nearest image, where y repeats itself."""
    if period_m > 0:
        vectors_m[:, 1] -= period_m * np.round(vectors_m[:, 1] / period_m)
    return vectors_m


def overlapping_pairs(
    place_m: Array, radius_m: Array, period_m: float = 0.0
) -> tuple[Indices, Indices, Array]:
    """Return the numbers of both particles of each pair that overlaps, and the overlaps in m.

    Neighbours are searched by classes of sizes that differ by a factor of two: within the diameter of the
    largest particle, a fine one can have thousands of others.  Particles repeat themselves after ``period_m``
    along y, unless it is 0.
    """
    from scipy.spatial import cKDTree

    octave = np.floor(np.log2(radius_m / radius_m.min()))
    groups = [np.flatnonzero(octave == number) for number in np.unique(octave)]
    inside_m = place_m.copy()
    if period_m > 0:
        inside_m[:, 1] %= period_m
    trees = [cKDTree(inside_m[group], boxsize=(0.0, period_m, 0.0)) for group in groups]
    largest_m = [radius_m[group].max() for group in groups]
    pairs = []
    for k, group in enumerate(groups):
        pairs.append(group[trees[k].query_pairs(2 * largest_m[k], output_type="ndarray")])
        for finer in range(k):
            reach_m = largest_m[k] + largest_m[finer]
            near = trees[k].sparse_distance_matrix(trees[finer], reach_m, output_type="ndarray")
            pairs.append(np.column_stack([group[near["i"]], groups[finer][near["j"]]]))
    one, two = np.concatenate(pairs).T
    distance_m = np.linalg.norm(_nearest(place_m[one] - place_m[two], period_m), axis=1)
    overlap_m = radius_m[one] + radius_m[two] - distance_m
    touching = overlap_m > 0
    return one[touching], two[touching], overlap_m[touching]
