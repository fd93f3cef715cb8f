"""Contacts at one instant, and the sums of their forces over spheres and points."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from adapters.particles.surface.triangle_spin import TriangleSpin, cross
from orchestrator.ports import Array, Indices, Overlaps


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
    triangle: TriangleSpin  # of the surface contacts
    distance_m: Array  # (n - pairs,) of the sphere's centre from the surface
    lever_m: Array
    second_lever_m: Array  # (pairs,)

    @property
    def pairs(self) -> int:
        return len(self.second)

    def slip_m_per_s(self, velocity_m_per_s: Array, spin_rad_per_s: Array, surface_m_per_s: Array) -> Array:
        """Velocity (n, 3) of the first partner relative to the second at the contact.

        ``surface_m_per_s`` (n - pairs, 3) is the surface's velocity at its contacts.
        """
        turning = self.lever_m[:, None] * spin_rad_per_s[self.first]
        turning[: self.pairs] += self.second_lever_m[:, None] * spin_rad_per_s[self.second]
        slip = velocity_m_per_s[self.first] - cross(turning, self.normal)
        slip[: self.pairs] -= velocity_m_per_s[self.second]
        slip[self.pairs :] -= surface_m_per_s
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
            self.triangle.only(surface),
            self.distance_m[surface],
            self.lever_m[kept],
            self.second_lever_m[pair],
        )

    def at_contacts(self, point_values: Array) -> tuple[Array, Array]:
        """Velocity of what a sphere touches and spin of its triangle, (n - pairs, 3) each, of
        velocities (or small displacements) of all points.  A contact's plane is half the overlap
        below the surface."""
        corners = point_values[self.points]
        spin = self.triangle.spin(corners)
        closest = np.einsum("ij,ijk->ik", self.barycentric, corners)
        below_m = (self.distance_m - self.lever_m[self.pairs :])[:, None]
        return closest + below_m * cross(spin, self.normal[self.pairs :]), spin

    def deepest(self, diameter_m: Array) -> Overlaps:
        """``diameter_m`` (spheres,)."""
        if not len(self.first):
            return Overlaps()
        smaller_m = diameter_m[self.first]
        pair, surface = slice(self.pairs), slice(self.pairs, None)
        smaller_m[pair] = np.minimum(smaller_m[pair], diameter_m[self.second])
        share = self.overlap_m / smaller_m
        figures = (values[part] for part in (pair, surface) for values in (self.overlap_m, share))
        return Overlaps(*(float(one.max(initial=0.0)) for one in figures))

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
        np.subtract.at(torque, self.second, couple_N_m[pair] + self.second_lever_m[:, None] * turning[pair])
        return force, torque

    def on_points(self, force_N: Array, turning_N: Array, couple_N_m: Array, points: int) -> Array:
        """Force (points, 3) on the surface, of the same forces and couples: the force acts at the
        closest point, by barycentric weights, and the couple that is left about it on the corners
        of the triangle (of resistance to rolling, and as friction acts below the surface)."""
        surface = slice(self.pairs, None)
        given, normal, of_contact_N = np.zeros((points, 3)), self.normal[surface], force_N[surface]
        from_surface_N = of_contact_N + turning_N
        about_center_N_m = couple_N_m[surface] - self.lever_m[surface, None] * cross(normal, of_contact_N)
        moment_N_m = about_center_N_m + self.distance_m[:, None] * cross(normal, from_surface_N)
        shares = self.barycentric[:, :, None] * from_surface_N[:, None, :]
        np.subtract.at(given, self.points, shares + self.triangle.forces(moment_N_m))
        return given
