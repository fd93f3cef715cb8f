"""Who touches whom at one instant, and the sums of contact forces over spheres and points."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from adapters.particles.nearest_feature import (
    closest_on_triangle,
    match_by_normal,
    minima,
)
from adapters.particles.smooth_patches import Places, shared
from adapters.particles.sphere_adhesion import NormalLaw
from adapters.particles.sphere_neighbours import Neighbours
from adapters.particles.sphere_state import Spheres
from orchestrator.geometry import TriangleSurface
from orchestrator.ports import Array, Indices


@dataclass(frozen=True)
class Touching:
    """n contacts: the first ``pairs`` between two spheres, the others of a sphere and the surface.

    ``normal`` (n, 3) points to the first sphere; levers (n,) reach from a sphere's centre to the
    contact plane, half the overlap inside (as LIGGGHTS has it, on the surface too).
    """

    first: Indices  # (n,) rows of spheres
    second: Indices  # (pairs,)
    points: Indices  # (n - pairs, 3) corners of the triangle
    barycentric: Array  # (n - pairs, 3)
    material: Indices  # (n,) of the second partner
    normal: Array
    overlap_m: Array
    weight: Array
    turning: Array  # (n - pairs, 3) m^(3/2), see smooth_patches.shared
    lever_m: Array
    second_lever_m: Array  # (pairs,)

    @property
    def pairs(self) -> int:
        return len(self.second)

    def slip_m_s(self, velocity_m_s: Array, spin_rad_s: Array, surface_m_s: Array) -> Array:
        """Velocity (n, 3) of the first partner relative to the second at the contact.

        ``surface_m_s`` (n - pairs, 3) is the surface's velocity at its contacts.
        """
        turning = self.lever_m[:, None] * spin_rad_s[self.first]
        turning[: self.pairs] += self.second_lever_m[:, None] * spin_rad_s[self.second]
        slip = velocity_m_s[self.first] - cross(turning, self.normal)
        slip[: self.pairs] -= velocity_m_s[self.second]
        slip[self.pairs :] -= surface_m_s
        return slip

    def renumbered(self, row: Indices) -> tuple[npt.NDArray[np.bool_], Touching]:
        """Which contacts stay (n,) and these, if sphere i is now ``row[i]``, gone if negative."""
        kept = row[self.first] >= 0
        kept[: self.pairs] &= row[self.second] >= 0
        left = self.only(kept)
        return kept, replace(left, first=row[left.first], second=row[left.second])

    def only(self, kept: npt.NDArray[np.bool_]) -> Touching:
        """Some of the contacts; ``kept`` (n,)."""
        pair, surface = kept[: self.pairs], kept[self.pairs :]
        return Touching(
            self.first[kept],
            self.second[pair],
            self.points[surface],
            self.barycentric[surface],
            self.material[kept],
            self.normal[kept],
            self.overlap_m[kept],
            self.weight[kept],
            self.turning[surface],
            self.lever_m[kept],
            self.second_lever_m[pair],
        )

    def at_contacts(self, point_values: Array) -> Array:
        """Values (n - pairs, 3) at the surface contacts of values at all points."""
        return np.asarray(np.einsum("ij,ijk->ik", self.barycentric, point_values[self.points]))

    def weighted(self, values: Array) -> Array:
        """Values (n, 3) times the contacts' weights."""
        return np.asarray(self.weight[:, None] * values)

    def on_spheres(
        self, force_N: Array, turning_N: Array, couple_N_m: Array, spheres: int
    ) -> tuple[Array, Array]:
        """Force and torque, (spheres, 3) each, of forces and couples (n, 3) on the first partners
        (the second gets the opposite), and of forces (n - pairs, 3) of the surface through the
        sphere's centre."""
        force, torque = np.zeros((spheres, 3)), np.zeros((spheres, 3))
        turning = cross(self.normal, force_N)
        np.add.at(force, self.first, force_N)
        np.add.at(force, self.first[self.pairs :], turning_N)
        np.subtract.at(force, self.second, force_N[: self.pairs])
        pair = slice(self.pairs)
        np.add.at(torque, self.first, couple_N_m - self.lever_m[:, None] * turning)
        np.subtract.at(
            torque, self.second, couple_N_m[pair] + self.second_lever_m[:, None] * turning[pair]
        )
        return force, torque

    def on_points(self, force_N: Array, turning_N: Array, points: int) -> Array:
        """Force (points, 3) on the surface, by barycentric weights, of the same forces."""
        given = np.zeros((points, 3))
        from_surface_N = force_N[self.pairs :] + turning_N
        shares = self.barycentric[:, :, None] * from_surface_N[:, None, :]
        np.subtract.at(given, self.points, shares)
        return given


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


def _necked_before(
    sphere: Indices, normal: Array, before: Touching | None
) -> npt.NDArray[np.bool_]:
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
    weight, turning = shared(
        Places(sphere[hit], depth_m, distance_m[hit], normal, corners_m[hit], inside)
    )
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


def cross(a: Array, b: Array) -> Array:
    """Row by row, (n, 3); a third of the time of np.cross on short arrays."""
    return np.stack(
        [
            a[:, 1] * b[:, 2] - a[:, 2] * b[:, 1],
            a[:, 2] * b[:, 0] - a[:, 0] * b[:, 2],
            a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0],
        ],
        axis=1,
    )
