"""The packing of particles at random places in a box, where the spheres that just hold them do not touch.

The method is random sequential addition, large spheres first, in batches.  Each sphere of a batch
proposes a place, and several places when few spheres are left.  A sphere that overlaps a placed sphere
or an earlier proposal tries again.  Equal spheres can fill some 38 % of a large volume in this way
(Widom, B., Journal of Chemical Physics 44, 1966, 3888-3894).
"""

from __future__ import annotations

from functools import cache, lru_cache

import numpy as np
import numpy.typing as npt

from orchestrator.case.bed.size_distribution import classes, random_sizes_m
from orchestrator.case.tables.bed import Block
from orchestrator.ports import Array, Indices
from orchestrator.ports.grains import Grain, Grains, ShapeTable, upright
from orchestrator.ports.plans import ParticleList

ROUNDS = 200  # A block's box counts as full after so many rounds of proposals.
REMEMBERED = 8  # blocks, since checks, predicted times and the run itself ask for the same particles
SIZE_RATIO = 2.0  # The ratio of radii in a batch is at most this, so that searches stay short.


def place_block(block: Block, grain: Grain[float]) -> ParticleList:
    """Return the particles of a block, like one ``grain``, completely inside its box, from large to small.

    Positions and velocities are in the axes of the box.  The same seed gives the same particles.
    Raises ValueError if the box has no room for all particles.
    """
    one = grain.resized(1.0)
    sieve_size_m, position_m, placed, orientation = _places(
        block, one.bounding_radius_m, one.sphere_count > 1
    )
    grains = grain.of_sizes(sieve_size_m)
    if not placed.all():
        share = np.sum(grains.volume_m3) / np.prod(np.ptp(block.box_m, axis=0))
        raise ValueError(
            f"only {placed.sum()} of {block.count} particles fit in the box: all would fill {share:.0%} of "
            "it, and random packing reaches 25 to 35 %; enlarge the box or lower count"
        )
    return equal_particles(position_m, np.array(block.velocity_m_per_s), grains, orientation)


@lru_cache(REMEMBERED)
def _places(
    block: Block, radius: float, lie_anyhow: bool
) -> tuple[Array, Array, npt.NDArray[np.bool_], Array]:
    """Return the sieve sizes (n,) of a block's particles, from large to small, their places (n, 3), whether
    each found one (n,), and how they are turned (n, 4), upright unless they ``lie_anyhow``.

    ``radius`` is their bounding radius over the size.
    """
    generator = np.random.default_rng(block.seed)
    sieve_size_m = np.sort(random_sizes_m(classes(block), block.count, generator))[::-1].copy()
    places = find_places(radius * sieve_size_m, np.array(block.box_m), generator, ROUNDS)
    turns = random_orientations(block.count, generator) if lie_anyhow else upright(block.count)
    return sieve_size_m, *places, turns


def random_orientations(count: int, generator: np.random.Generator) -> Array:
    """Return orientations (n, 4) that have no preferred direction.

    Four normal numbers are a vector of no preferred direction in four dimensions, and unit quaternions in its
    direction are then rotations of none (Shoemake, K., Graphics Gems III, 1992, 124-132).
    """
    given = generator.normal(size=(count, 4))
    return np.asarray(given / np.linalg.norm(given, axis=1, keepdims=True))


def find_places(
    radius_m: Array, box_m: Array, generator: np.random.Generator, rounds: int
) -> tuple[Array, npt.NDArray[np.bool_]]:
    """Return the centres (n, 3) of spheres inside the box, and whether each one found a place (n,).

    Where the box is thinner than a sphere, the centre lies in the middle of the box.
    """
    center_m = np.tile(box_m.mean(axis=0), (len(radius_m), 1))
    room_m = np.maximum((box_m[1] - box_m[0]) / 2.0 - radius_m[:, None], 0.0)
    placed = np.zeros(len(radius_m), dtype=bool)
    batches = _batches(radius_m)
    for number, batch in enumerate(batches):
        for _ in range(rounds):
            left = batch[~placed[batch]]
            if not len(left):
                break
            who = np.repeat(left, max(1, len(batch) // (4 * len(left))))
            at_m = box_m.mean(axis=0) + generator.uniform(-1.0, 1.0, (len(who), 3)) * room_m[who]
            free = np.ones(len(who), dtype=bool)
            for other in batches[: number + 1]:
                there = other[placed[other]]
                overlapping = _overlapping(at_m, radius_m[who], center_m[there], radius_m[there])
                free[overlapping] = False
            who, first = np.unique(who[free], return_index=True)
            center_m[who] = at_m[free][first]
            placed[who[~_earlier_overlap(center_m[who], radius_m[who])]] = True
    return center_m, placed


def _batches(radius_m: Array) -> list[Indices]:
    """Return batches of rows; each batch has spheres of similar radius, and the largest come first."""
    if not len(radius_m):
        return []
    number = np.floor(np.log(radius_m.max() / radius_m) / np.log(SIZE_RATIO))
    return [np.flatnonzero(number == k) for k in np.unique(number)]


def _earlier_overlap(center_m: Array, radius_m: Array) -> npt.NDArray[np.bool_]:
    """Return whether each sphere overlaps a sphere in an earlier row, (n,)."""
    from scipy.spatial import cKDTree

    overlapping = np.zeros(len(radius_m), dtype=bool)
    if len(radius_m) < 2:
        return overlapping
    i, j = cKDTree(center_m).query_pairs(2.0 * radius_m.max(), output_type="ndarray").T
    gap_m = np.linalg.norm(center_m[i] - center_m[j], axis=1) - radius_m[i] - radius_m[j]
    overlapping[np.maximum(i, j)[gap_m < 0.0]] = True
    return overlapping


def _overlapping(center_m: Array, radius_m: Array, others_m: Array, radii_m: Array) -> Indices:
    """Return the rows of the spheres that overlap any of the other spheres."""
    from scipy.spatial import cKDTree

    if not len(radii_m):
        return np.empty(0, dtype=np.int64)
    pairs = cKDTree(center_m).sparse_distance_matrix(
        cKDTree(others_m), radius_m.max() + radii_m.max(), output_type="ndarray"
    )
    return np.asarray(pairs["i"][pairs["v"] < radius_m[pairs["i"]] + radii_m[pairs["j"]]])


def equal_particles(
    position_m: Array, velocity_m_per_s: Array, grains: Grains, orientation: Array
) -> ParticleList:
    """Return particles that do not spin and have the same velocity (3,)."""
    count = len(grains)
    velocities = np.tile(velocity_m_per_s, (count, 1))
    return ParticleList(position_m.copy(), velocities, np.zeros((count, 3)), grains, orientation.copy())


@cache
def no_particles() -> ParticleList:
    """Return an empty list of particles, of no shape."""
    none = Grain(np.empty(0), np.empty(0), np.empty(0, int), np.empty(0, int), ShapeTable.of([]))
    return equal_particles(np.empty((0, 3)), np.zeros(3), none, upright(0))
