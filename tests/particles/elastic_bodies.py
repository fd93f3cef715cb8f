"""A Monte Carlo of its own: free rigid bodies of spheres that bounce, elastic and smooth, on a thin still
plate with rectangular openings.

It shares no code with the solvers: linear springs in place of Hertz's contacts, the nearest place of the
plate by a formula in place of triangles, and rotation matrices that are turned by the midpoint of each step.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchestrator.ports import Array


@dataclass
class Plate:
    """The plane z = 0 with openings (along x, across y) in the middles of cells of a pitch each."""

    opening_m: Array  # (2,)
    pitch_m: Array  # (2,)

    def away_m(self, place_m: Array) -> Array:
        """Return the vectors (..., 3) from the nearest place of the plate: over an opening, of its rim."""
        within = place_m[..., :2] % self.pitch_m - self.pitch_m / 2
        room_m = self.opening_m / 2 - np.abs(within)
        open_ = (room_m > 0).all(axis=-1)
        away = np.zeros_like(place_m)
        away[..., 2] = place_m[..., 2]
        nearest = np.argmin(room_m, axis=-1)
        for axis in (0, 1):
            at = open_ & (nearest == axis)
            away[at, axis] = -(np.sign(within[..., axis]) * room_m[..., axis])[at]
        return away


def bounce(
    plate: Plate,
    place_m: Array,
    turn: Array,
    speed_m_per_s: float,
    spheres_m: Array,
    moments_m2: Array,
    seconds: float,
    step_s: float,
    softness_m: float,
) -> tuple[Array, Array]:
    """Throw n bodies down at places (n, 3), turned by rotations (n, 3, 3); return their places, and who never
    touched the plate (n,).

    ``spheres_m`` (k, 4) are place and radius in a body's axes, ``moments_m2`` (3,) its moments over its mass;
    an impact of the whole mass presses a sphere in by ``softness_m``.
    """
    place_m, turn = place_m.copy(), turn.copy()
    velocity = np.zeros_like(place_m)
    velocity[:, 2] = -speed_m_per_s
    momentum = np.zeros_like(place_m)  # angular, over the mass
    spring_per_s2 = (speed_m_per_s / softness_m) ** 2  # over the mass
    untouched = np.ones(len(place_m), dtype=bool)
    for _ in range(round(seconds / step_s)):
        arm_m = np.einsum("nij,kj->nki", turn, spheres_m[:, :3])
        away_m = plate.away_m(place_m[:, None] + arm_m)
        distance_m = np.linalg.norm(away_m, axis=2)
        depth_m = np.maximum(spheres_m[:, 3] - distance_m, 0.0)
        untouched &= ~(depth_m > 0).any(axis=1)
        push = (spring_per_s2 * depth_m / np.maximum(distance_m, 1e-300))[..., None] * away_m
        velocity += step_s * push.sum(axis=1)
        momentum += step_s * np.cross(arm_m, push).sum(axis=1)
        place_m += step_s * velocity
        middle = _turned(turn, turn, momentum, moments_m2, step_s / 2)
        turn = _turned(turn, middle, momentum, moments_m2, step_s)
    return place_m, untouched


def _turned(turn: Array, at: Array, momentum: Array, moments_m2: Array, step_s: float) -> Array:
    """Return ``turn`` after a step with the spin that the angular momentum makes in the attitude ``at``."""
    own = np.einsum("nij,ni->nj", at, momentum) / moments_m2
    angle = step_s * np.einsum("nij,nj->ni", at, own)
    size = np.linalg.norm(angle, axis=1)[:, None, None]
    x, y, z = angle.T
    zero = np.zeros_like(x)
    skew = np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]]).transpose(2, 0, 1)
    small = np.maximum(size, 1e-12)  # Rodrigues's formula
    rotation = np.eye(3) + np.sin(small) / small * skew + (1 - np.cos(small)) / small**2 * skew @ skew
    return np.asarray(rotation @ turn)
