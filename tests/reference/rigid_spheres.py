"""Rigid spheres that hit a still panel with rectangular openings: the chance that a hit ends below it.

It shares nothing with the program: no triangles, no overlaps, no contact law but Newton's restitution and
Coulomb's friction, each of which acts in an instant.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
G_M_PER_S2 = 9.81
SHORTEST_M = 2e-7  # of a step, by which a sphere goes too far at most
SLOWEST_M_PER_S = 0.05  # in a step's length: those that hardly move are drawn by gravity
LONGEST_S = 0.2  # after which a sphere that lies or rolls on the panel has not passed
OVER = 0.25  # diameters of gap above the panel at which a hit is over


@dataclass(frozen=True)
class Slots:
    """Openings ``length_m`` x ``width_m`` in cells ``pitch_m`` (2,), with straight walls of ``depth_m``; the
    upper side is in z = 0."""

    length_m: float
    width_m: float
    pitch_m: tuple[float, float]
    depth_m: float = 0.0

    def away_m(self, center_m: Array) -> Array:
        """Return the vectors (n, 3) to centres (n, 3) from the nearest points of the material."""
        half = np.array([self.length_m, self.width_m]) / 2
        pitch = np.array(self.pitch_m)
        place = center_m[:, :2] - pitch * np.round(center_m[:, :2] / pitch)
        to_wall = half - np.abs(place)
        inside = (to_wall > 0).all(axis=1)
        axis = to_wall.argmin(axis=1)
        rows = np.arange(len(center_m))
        away = np.zeros_like(center_m)
        away[rows, axis] = np.where(inside, -np.sign(place[rows, axis]) * to_wall[rows, axis], 0.0)
        away[:, 2] = center_m[:, 2] - np.clip(center_m[:, 2], -self.depth_m, 0.0)
        return away


def passed_share(
    slots: Slots,
    diameter_m: float,
    hits: int,
    speed_m_per_s: float,
    restitution: float,
    friction: float,
    seed: int = 1,
) -> float:
    """Return the share of hits, straight down at random places, after which a sphere is through.

    A hit is over when the sphere is below the panel, a quarter of its diameter above it, or has lain on it or
    rolled there for long.  Spheres go on
    straight ways as long as they can touch nothing (conservative advancement); where one touches the material
    and comes nearer, it gets the impulse  J_n = -(1 + e) m v_n  along the normal and, against the slip of its
    surface, the smaller of  mu J_n  and  2/7 m |slip|, which stops the slip of a solid sphere.
    """
    radius_m = diameter_m / 2
    place = np.random.default_rng(seed).uniform(-0.5, 0.5, (hits, 2)) * slots.pitch_m
    center = np.column_stack([place, np.full(hits, radius_m + 1e-6)])
    velocity = np.tile([0.0, 0.0, -speed_m_per_s], (hits, 1))
    spin = np.zeros((hits, 3))
    passed, time_s = 0, np.zeros(hits)
    while len(center):
        low, high = center[:, 2] < -slots.depth_m - radius_m, center[:, 2] - radius_m > OVER * diameter_m
        passed += int(low.sum())
        going = ~(low | high) & (time_s < LONGEST_S)
        center, velocity, spin, time_s = center[going], velocity[going], spin[going], time_s[going]
        away = slots.away_m(center)
        distance = np.linalg.norm(away, axis=1)
        normal = away / distance[:, None]
        gap = distance - radius_m
        _bounce(
            (gap <= 0) & (np.einsum("ij,ij->i", velocity, normal) < 0),
            normal,
            velocity,
            spin,
            radius_m,
            restitution,
            friction,
        )
        speed = np.linalg.norm(velocity, axis=1) + SLOWEST_M_PER_S
        step = (np.maximum(gap, SHORTEST_M) / speed)[:, None]
        center = center + step * velocity
        velocity = velocity - step * [0.0, 0.0, G_M_PER_S2]
        time_s = time_s + step[:, 0]
    return passed / hits


def _bounce(
    hit: npt.NDArray[np.bool_],
    normal: Array,
    velocity: Array,
    spin: Array,
    radius_m: float,
    restitution: float,
    friction: float,
) -> None:
    """Give those that ``hit`` (n,) their impulses over mass, in place."""
    n, v, w = normal[hit], velocity[hit], spin[hit]
    normal_m_per_s = -(1 + restitution) * np.einsum("ij,ij->i", v, n)
    arm = -radius_m * n
    slip = v + np.cross(w, arm)
    slip -= np.einsum("ij,ij->i", slip, n)[:, None] * n
    size = np.linalg.norm(slip, axis=1)
    tangential = np.minimum(friction * normal_m_per_s, 2 / 7 * size)
    given = normal_m_per_s[:, None] * n - (tangential / np.maximum(size, 1e-12))[:, None] * slip
    velocity[hit] = v + given
    spin[hit] = w + np.cross(arm, given) / (0.4 * radius_m**2)
