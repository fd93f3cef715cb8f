"""Pairs that touch at one instant, where, and which contact of the instant before goes on."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
import numpy.typing as npt

from orchestrator.ports import Array, Indices, Overlaps
from orchestrator.ports.geometry import TriangleSurface, closest_on_triangle
from orchestrator.ports.rows import Rows
from tests.reference.spheres.smooth_patches import Places, find_minima, share_force
from tests.reference.spheres.spheres import Spheres
from tests.reference.spheres.triangle_spin import TriangleSpin, cross

SKIN = 0.2  # of the largest radius, of the lists of neighbours
SAME_CONTACT = 0.5  # cosine between a contact's normals at two instants
SAME_PATCH = math.cos(math.radians(30.0))  # a new contact takes over the spring of a present one


@dataclass(frozen=True)
class Neighbours:
    """Candidates for contacts: pairs of spheres (rows i < j), and a sphere and a triangle."""

    i: Indices
    j: Indices
    sphere: Indices
    triangle: Indices
    sphere_m: Array  # positions when the lists were made
    surface_m: Array
    skin_m: float

    @staticmethod
    def of(spheres: Spheres, surface: TriangleSurface, surface_m: Array) -> Neighbours:
        """The lists for spheres and surface points where they are now."""
        from scipy.spatial import cKDTree

        largest_m = float(np.max(spheres.radius_m, initial=0.0))
        skin_m, center_m, radius_m = SKIN * largest_m, spheres.position_m, spheres.radius_m
        i, j = np.empty((2, 0), dtype=np.int64)
        if len(spheres) > 1:
            pairs = cKDTree(center_m).query_pairs(2.0 * largest_m + skin_m, output_type="ndarray")
            i, j = pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))].astype(np.int64).T
            apart = spheres.body[i] != spheres.body[j]  # not of one grain
            i, j = i[apart], j[apart]
        near = np.linalg.norm(center_m[i] - center_m[j], axis=1) < radius_m[i] + radius_m[j] + skin_m
        sphere, triangle = find_near_surface(spheres, skin_m, surface_m[surface.triangles])
        return Neighbours(i[near], j[near], sphere, triangle, center_m.copy(), surface_m.copy(), skin_m)

    def outdated(self, sphere_m: Array, surface_m: Array) -> bool:
        """Return whether a pair outside the lists could touch by now."""
        moved_m = _farthest_m(sphere_m, self.sphere_m)
        return moved_m + max(moved_m, _farthest_m(surface_m, self.surface_m)) >= self.skin_m


def _farthest_m(now_m: Array, then_m: Array) -> float:
    return float(np.sqrt(np.max(np.sum((now_m - then_m) ** 2, axis=1), initial=0.0)))


def find_near_surface(spheres: Spheres, skin_m: float, corners_m: Array) -> tuple[Indices, Indices]:
    """Find the spheres and triangles (corners (m, 3, 3)) with a gap below ``skin_m``."""
    reach_m = spheres.radius_m + skin_m
    apart_m = np.zeros((len(spheres), len(corners_m)))  # between bounding boxes
    for axis in range(3):
        x, low_m, high_m = (
            spheres.position_m[:, axis, None],
            corners_m[:, :, axis].min(axis=1),
            corners_m[:, :, axis].max(axis=1),
        )
        apart_m = np.maximum(apart_m, np.maximum(low_m - x, x - high_m))
    sphere, triangle = np.nonzero(apart_m <= reach_m[:, None])
    center_m, corners_m = spheres.position_m[sphere], corners_m[triangle]
    nearest_m = np.einsum("ij,ijk->ik", closest_on_triangle(center_m, corners_m), corners_m)
    near = np.linalg.norm(center_m - nearest_m, axis=1) < reach_m[sphere]
    return sphere[near], triangle[near]


@dataclass(frozen=True)
class Contacts(Rows):
    """n contacts, first those between two spheres, then those of a sphere and the surface.

    What a contact of the other kind has not is zero; the surface's radius is infinite.
    """

    first: Indices  # (n,) row of the first sphere
    second: Indices  # (n,) row of the second, -1: the surface
    material: Indices  # (n,) of the first partner
    second_material: Indices
    radius_m: Array  # (n,) of the first partner
    second_radius_m: Array
    mass_kg: Array  # (n,) reduced
    normal: Array  # (n, 3) to the first sphere
    overlap_m: Array  # (n,)
    weight: Array  # (n,) share of the force that acts, see smooth_patches.share_force
    turning: Array  # (n, 3) m^(3/2), of the surface, see there
    points: Indices  # (n, 3) corners of the triangle
    barycentric: Array  # (n, 3) of the closest point
    triangle: TriangleSpin

    @property
    def materials(self) -> tuple[Indices, Indices]:
        return self.material, self.second_material

    @property
    def reduced_radius_m(self) -> Array:
        return np.asarray(1.0 / (1.0 / self.radius_m + 1.0 / self.second_radius_m))

    @property
    def distance_m(self) -> Array:
        """The distance (n,) of the first sphere's centre from the surface."""
        return self.radius_m - self.overlap_m

    @property
    def lever_m(self) -> Array:
        """The lever (n,) from the first sphere's centre to the contact plane, which lies half the
        overlap inside (as LIGGGHTS has it, on the surface, too)."""
        return self.radius_m - self.overlap_m / 2.0

    @property
    def second_lever_m(self) -> Array:
        """The lever (n,) from the second sphere's centre to the contact plane; 0 on the surface."""
        return np.where(self.second < 0, 0.0, self.second_radius_m - self.overlap_m / 2.0)

    def compute_slip(self, velocity_m_per_s: Array, spin_rad_per_s: Array, surface_m_per_s: Array) -> Array:
        """Return the velocity (n, 3) of the first partner relative to the second at the contact, of the
        spheres' velocities and spins, and the surface's velocity (n, 3) at the contacts."""
        rolled = self.lever_m[:, None] * spin_rad_per_s[self.first]
        rolled += self.second_lever_m[:, None] * spin_rad_per_s[self.second]
        other = np.where(self.second[:, None] < 0, surface_m_per_s, velocity_m_per_s[self.second])
        return np.asarray(velocity_m_per_s[self.first] - cross(rolled, self.normal) - other)

    def compute_spin(self, spin_rad_per_s: Array, surface_rad_per_s: Array) -> Array:
        """Return the spin (n, 3) of the first partner relative to the second."""
        other = np.where(self.second[:, None] < 0, surface_rad_per_s, spin_rad_per_s[self.second])
        return np.asarray(spin_rad_per_s[self.first] - other)

    def at_contacts(self, point_values: Array) -> tuple[Array, Array]:
        """Return the velocity of what a sphere touches and the spin of its triangle, (n, 3) each, of
        velocities (or small displacements) of all points.

        A contact's plane is half the overlap below the surface.
        """
        corners = point_values[self.points]
        spin = self.triangle.spin(corners)
        closest = np.einsum("ij,ijk->ik", self.barycentric, corners)
        return closest - self.overlap_m[:, None] / 2.0 * cross(spin, self.normal), spin

    def renumbered(self, row: Indices) -> tuple[npt.NDArray[np.bool_], Contacts]:
        """Tell which contacts stay (n,), and give these, if sphere i is now ``row[i]``, gone if
        negative."""
        stays = (row[self.first] >= 0) & ((self.second < 0) | (row[self.second] >= 0))
        left = self.part(stays)
        second = np.where(left.second < 0, -1, row[left.second])
        return stays, replace(left, first=row[left.first], second=second)

    def deepest(self) -> Overlaps:
        """The deepest overlaps of pairs and with the surface."""
        share = self.overlap_m / (2.0 * np.minimum(self.radius_m, self.second_radius_m))
        kinds = (self.second >= 0, self.second < 0)
        sizes = [values[kind] for kind in kinds for values in (self.overlap_m, share)]
        return Overlaps(*(float(size.max(initial=0.0)) for size in sizes))

    def sum_on_spheres(
        self, force_N: Array, turning_N: Array, couple_N_m: Array, spheres: int
    ) -> tuple[Array, Array]:
        """Return force and torque, (spheres, 3) each, of forces and couples (n, 3) on the first partners
        (the second gets the opposite), and of forces (n, 3) of the surface through the sphere's
        centre."""
        force, torque = np.zeros((spheres, 3)), np.zeros((spheres, 3))
        pair = self.second >= 0
        second, turn = self.second[pair], cross(self.normal, force_N)
        np.add.at(force, self.first, force_N + turning_N)
        np.subtract.at(force, second, force_N[pair])
        np.add.at(torque, self.first, couple_N_m - self.lever_m[:, None] * turn)
        on_second_N_m = couple_N_m + self.second_lever_m[:, None] * turn
        np.subtract.at(torque, second, on_second_N_m[pair])
        return force, torque

    def sum_on_points(self, force_N: Array, turning_N: Array, couple_N_m: Array, points: int) -> Array:
        """Return the force (points, 3) on the surface, of the same forces and couples: the force acts at the
        closest point, by barycentric weights, and the couple that is left about it on the corners
        of the triangle (of resistance to rolling, and as friction acts below the surface)."""
        given, from_surface_N = np.zeros((points, 3)), force_N + turning_N
        moment_N_m = couple_N_m - self.lever_m[:, None] * cross(self.normal, force_N)
        moment_N_m += self.distance_m[:, None] * cross(self.normal, from_surface_N)
        shares = self.barycentric[:, :, None] * from_surface_N[:, None, :]
        np.subtract.at(given, self.points, shares + self.triangle.forces(moment_N_m))
        return given


class Adhesive(Protocol):
    """Quantities that the search asks of the normal law."""

    @property
    def reach_m(self) -> float: ...

    def separation_m(self, contacts: Contacts) -> Array: ...


def find_contacts(
    spheres: Spheres,
    surface: TriangleSurface,
    surface_m: Array,
    near: Neighbours,
    law: Adhesive,
    before: Contacts | None,
) -> Contacts:
    """Find all contacts with the surface points at ``surface_m``; ``law`` and the contacts ``before``
    decide which hold beyond zero overlap."""
    on_surface = _find_on_surface(spheres, surface, surface_m, near, law, before)
    pairs = _find_between_spheres(spheres, near, law, before)
    return Contacts.joined([pairs, on_surface]) if len(pairs.first) else on_surface


def _find_between_spheres(
    spheres: Spheres, near: Neighbours, law: Adhesive, before: Contacts | None
) -> Contacts:
    between_m = spheres.position_m[near.i] - spheres.position_m[near.j]
    distance_m = np.sqrt(np.einsum("ij,ij->i", between_m, between_m))
    overlap_m = spheres.radius_m[near.i] + spheres.radius_m[near.j] - distance_m
    hit = np.flatnonzero(overlap_m > -law.reach_m)
    i, j, n = near.i[hit], near.j[hit], len(hit)
    contacts = Contacts(
        first=i,
        second=j,
        material=spheres.material[i],
        second_material=spheres.material[j],
        radius_m=spheres.radius_m[i],
        second_radius_m=spheres.radius_m[j],
        mass_kg=1.0 / (1.0 / spheres.mass_kg[i] + 1.0 / spheres.mass_kg[j]),
        normal=between_m[hit] / distance_m[hit, None],
        overlap_m=overlap_m[hit],
        weight=np.ones(n),
        turning=np.zeros((n, 3)),
        points=np.zeros((n, 3), dtype=np.int64),
        barycentric=np.zeros((n, 3)),
        triangle=TriangleSpin(np.zeros((n, 3, 3)), np.zeros((n, 3, 3))),
    )
    if law.reach_m == 0.0:
        return contacts
    necked = _find_pairs(i, j, before, len(spheres)) >= 0
    overlap_m = contacts.overlap_m
    return contacts.part((overlap_m > 0.0) | (necked & (overlap_m >= law.separation_m(contacts))))


def _find_on_surface(
    spheres: Spheres,
    surface: TriangleSurface,
    surface_m: Array,
    near: Neighbours,
    law: Adhesive,
    before: Contacts | None,
) -> Contacts:
    """The contacts among the candidates, but those without weight."""
    sphere, triangles = near.sphere, surface.triangles[near.triangle]
    corners_m, center_m = surface_m[triangles], spheres.position_m[sphere]
    barycentric = closest_on_triangle(center_m, corners_m)
    out_m = center_m - np.einsum("ij,ijk->ik", barycentric, corners_m)
    distance_m = np.sqrt(np.einsum("ij,ij->i", out_m, out_m))
    overlap_m = spheres.radius_m[sphere] - distance_m
    hit = np.flatnonzero(overlap_m > -law.reach_m)
    hit = hit[find_minima(sphere[hit], triangles[hit], barycentric[hit], overlap_m[hit])]
    sphere, n = sphere[hit], len(hit)
    contacts = Contacts(
        first=sphere,
        second=np.full(n, -1),
        material=spheres.material[sphere],
        second_material=surface.material[near.triangle[hit]],
        radius_m=spheres.radius_m[sphere],
        second_radius_m=np.full(n, np.inf),
        mass_kg=spheres.mass_kg[sphere],
        normal=out_m[hit] / distance_m[hit, None],
        overlap_m=overlap_m[hit],
        weight=np.ones(n),
        turning=np.zeros((n, 3)),
        points=triangles[hit],
        barycentric=barycentric[hit],
        triangle=TriangleSpin.of(corners_m[hit]),
    )
    depth_m, corners_m = contacts.overlap_m, corners_m[hit]
    if law.reach_m > 0.0:
        necked = np.zeros(n, dtype=bool)
        if before is not None:
            necked = _match_by_normal(contacts, before)[1] >= 0
        depth_m = depth_m - law.separation_m(contacts)
        holds = (contacts.overlap_m > 0.0) | (necked & (depth_m >= 0.0))
        contacts, depth_m, corners_m = contacts.part(holds), depth_m[holds], corners_m[holds]
    places = Places(
        contacts.first, depth_m, contacts.distance_m, contacts.normal, corners_m, contacts.barycentric > 0.0
    )
    weight, turning = share_force(places)
    contacts = replace(contacts, weight=weight, turning=turning)
    return contacts if weight.all() else contacts.part(weight > 0.0)


def match_contacts(now: Contacts, before: Contacts, spheres: int) -> tuple[Indices, Indices]:
    """Find for each contact now its row in ``before`` or -1 if it is new, and the row whose spring it
    takes over: its own, or of a contact of the same smooth patch, or -1."""
    same, parent = _match_by_normal(now, before)
    pair = now.second >= 0
    same[pair] = _find_pairs(now.first[pair], now.second[pair], before, spheres)
    parent[pair] = same[pair]
    return same, parent


def _find_pairs(i: Indices, j: Indices, before: Contacts | None, spheres: int) -> Indices:
    """The row in ``before`` of each pair of spheres, or -1; both ascend, as the lists do."""
    pairs = 0 if before is None else int(np.count_nonzero(before.second >= 0))
    if before is None or pairs == 0:
        return np.full(len(i), -1)
    old, new = before.first[:pairs] * spheres + before.second[:pairs], i * spheres + j
    place = np.minimum(np.searchsorted(old, new), pairs - 1)
    return np.asarray(np.where(old[place] == new, place, -1))


def _match_by_normal(now: Contacts, before: Contacts) -> tuple[Indices, Indices]:
    """Return for each contact of the surface the row of the contact before that it continues, or -1, and
    the row of the one that it continues or comes from, or -1.

    Contacts of one sphere are paired by nearest normal, nearest first, each once, and only closer
    than 60 degrees.  One that is left over comes from the contact with the nearest normal closer
    than 30 degrees.
    """
    present, past = np.flatnonzero(now.second < 0), np.flatnonzero(before.second < 0)
    new, old = np.nonzero(now.first[present, None] == before.first[past])
    new, old = present[new], past[old]
    cosine = np.einsum("ij,ij->i", now.normal[new], before.normal[old])
    order = np.argsort(-cosine, kind="stable")
    order = order[cosine[order] > SAME_CONTACT]
    same, parent, taken = np.full(len(now.first), -1), np.full(len(now.first), -1), set()
    for n, o, c in zip(*(each[order].tolist() for each in (new, old, cosine)), strict=True):
        if parent[n] < 0 and c > SAME_PATCH:
            parent[n] = o
        if same[n] < 0 and o not in taken:
            same[n] = parent[n] = o
            taken.add(o)
    return same, parent
