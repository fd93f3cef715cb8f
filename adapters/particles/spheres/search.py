"""Finds who touches whom at one instant, and which contact of an instant before it continues."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from adapters.particles.spheres.adhesion import NormalLaw
from adapters.particles.spheres.neighbours import Neighbours
from adapters.particles.spheres.state import Spheres
from adapters.particles.spheres.touch import Touching
from adapters.particles.surface.nearest_feature import match_by_normal, minima
from adapters.particles.surface.smooth_patches import Places, shared
from adapters.particles.surface.triangle_spin import TriangleSpin
from orchestrator.ports import Array, Indices
from orchestrator.ports.geometry import TriangleSurface, closest_on_triangle


def touching(
    spheres: Spheres,
    surface: TriangleSurface,
    surface_m: Array,
    near: Neighbours,
    law: NormalLaw,
    before: Touching | None,
) -> Touching:
    """All contacts with the surface points at ``surface_m``; ``law`` and the contacts ``before``
    say which hold beyond zero overlap."""
    i, j, pair_normal, pair_overlap_m = _pairs(spheres, near, law, before)
    sphere, triangle, barycentric, normal, overlap_m, weight, turning = on_surface(
        spheres, surface, surface_m, near, law, before
    )
    first = np.concatenate([i, sphere])
    overlap_m = np.concatenate([pair_overlap_m, overlap_m])
    return Touching(
        first,
        j,
        surface.triangles[triangle],
        barycentric,
        np.concatenate([spheres.material[j], surface.material[triangle]]),
        np.concatenate([pair_normal, normal]),
        overlap_m,
        np.concatenate([np.ones(len(i)), weight]),
        turning,
        TriangleSpin.of(surface_m[surface.triangles[triangle]]),
        spheres.radius_m[sphere] - overlap_m[len(i) :],
        spheres.radius_m[first] - overlap_m / 2.0,
        spheres.radius_m[j] - pair_overlap_m / 2.0,
    )


def _pairs(
    spheres: Spheres, near: Neighbours, law: NormalLaw, before: Touching | None
) -> tuple[Indices, Indices, Array, Array]:
    between_m = spheres.position_m[near.i] - spheres.position_m[near.j]
    distance_m = np.sqrt(np.einsum("ij,ij->i", between_m, between_m))
    overlap_m = spheres.radius_m[near.i] + spheres.radius_m[near.j] - distance_m
    hit = np.flatnonzero(overlap_m > -law.reach_m)
    if law.reach_m > 0.0:
        i, j = near.i[hit], near.j[hit]
        materials = (spheres.material[i], spheres.material[j])
        least_m = law.separation_m(materials, (spheres.radius_m[i], spheres.radius_m[j]))
        necked = _pair_rows(i, j, before, len(spheres)) >= 0
        hit = hit[(overlap_m[hit] > 0.0) | (necked & (overlap_m[hit] >= least_m))]
    normal = between_m[hit] / distance_m[hit, None]
    return near.i[hit], near.j[hit], normal, overlap_m[hit]


def _pair_rows(i: Indices, j: Indices, before: Touching | None, spheres: int) -> Indices:
    """The row in ``before`` of each pair of spheres, or -1; ascending, as the lists are."""
    if before is None or before.pairs == 0:
        return np.full(len(i), -1)
    old, new = before.first[: before.pairs] * spheres + before.second, i * spheres + j
    place = np.minimum(np.searchsorted(old, new), len(old) - 1)
    return np.asarray(np.where(old[place] == new, place, -1))


def _necked_before(sphere: Indices, normal: Array, before: Touching | None) -> npt.NDArray[np.bool_]:
    """Which places of spheres on the surface continue, or come from, a contact before."""
    if before is None:
        return np.zeros(len(sphere), dtype=bool)
    pairs = slice(before.pairs, None)
    _, parent = match_by_normal((sphere, normal), (before.first[pairs], before.normal[pairs]))
    return np.asarray(parent >= 0)


def on_surface(
    spheres: Spheres,
    surface: TriangleSurface,
    surface_m: Array,
    near: Neighbours,
    law: NormalLaw,
    before: Touching | None,
) -> tuple[Indices, Indices, Array, Array, Array, Array, Array]:
    """Contacts among the candidates ``near`` (sphere, triangle), those of weight zero left out:
    sphere, triangle, barycentric weights, normal, overlap, weight, turning."""
    sphere, triangle, triangles = near.sphere, near.triangle, surface.triangles
    corners_m, center_m = surface_m[triangles[triangle]], spheres.position_m[sphere]
    barycentric = closest_on_triangle(center_m, corners_m)
    out_m = center_m - np.einsum("ij,ijk->ik", barycentric, corners_m)
    distance_m = np.sqrt(np.einsum("ij,ij->i", out_m, out_m))
    overlap_m = spheres.radius_m[sphere] - distance_m
    hit = np.flatnonzero(overlap_m > -law.reach_m)
    hit = hit[minima(sphere[hit], triangles[triangle[hit]], barycentric[hit], overlap_m[hit])]
    depth_m = overlap_m[hit]
    if law.reach_m > 0.0:
        materials = (spheres.material[sphere[hit]], surface.material[triangle[hit]])
        radii_m = (spheres.radius_m[sphere[hit]], np.full(len(hit), np.inf))
        necked = _necked_before(sphere[hit], out_m[hit] / distance_m[hit, None], before)
        depth_m = depth_m - law.separation_m(materials, radii_m)
        held = (overlap_m[hit] > 0.0) | (necked & (depth_m >= 0.0))
        hit, depth_m = hit[held], depth_m[held]
    normal = out_m[hit] / distance_m[hit, None]
    inside = barycentric[hit] > 0.0
    weight, turning = shared(Places(sphere[hit], depth_m, distance_m[hit], normal, corners_m[hit], inside))
    counts = np.flatnonzero(weight > 0.0)
    hit = hit[counts]
    return (
        sphere[hit],
        triangle[hit],
        barycentric[hit],
        normal[counts],
        overlap_m[hit],
        weight[counts],
        turning[counts],
    )


def continued(now: Touching, before: Touching, spheres: int) -> tuple[Indices, Indices]:
    """For each contact now its row in ``before`` or -1 if it is new, and the row whose spring it
    takes over: its own, or of a contact of the same smooth patch, or -1."""
    of_pairs = _pair_rows(now.first[: now.pairs], now.second, before, spheres)
    same, parent = match_by_normal(
        (now.first[now.pairs :], now.normal[now.pairs :]),
        (before.first[before.pairs :], before.normal[before.pairs :]),
    )
    for of_surface in (same, parent):
        of_surface[of_surface >= 0] += before.pairs
    return np.concatenate([of_pairs, same]), np.concatenate([of_pairs, parent])
