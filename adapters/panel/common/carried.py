"""Surfaces whose every point is a clamp: walls, chutes and probes on frames, and rigid panels."""

from __future__ import annotations

import numpy as np

from adapters.panel.common.panel import AccountedPanel
from orchestrator.ports import Array, Known, Motion, Mount
from orchestrator.ports.clock import Interval


def build(points_m: Array, frame: tuple[str, ...]) -> RigidSurface:
    """Open a rigid surface of ``points_m`` (n, 3) in the world at t = 0, each carried by its ``frame``."""
    mount = Mount(points_m, frame)
    return RigidSurface("rigid surfaces", mount, np.zeros(len(points_m)), np.zeros(3))


class RigidSurface(AccountedPanel):
    """A ``Panel`` whose every point is a clamp and moves as its frame does.

    The reaction is the force that moves its masses (points,) and bears its load:  load + m (gravity - mean
    acceleration)  at each point, so that linear momentum is exact.  Walls and observed points have no mass
    (theirs belongs to the frame) and no mesh to map from: the particles touch their points themselves.
    """

    def __init__(self, name: str, mount: Mount, mass_kg: Array, gravity_m_per_s2: Array) -> None:
        super().__init__(name, mount, mass_kg, gravity_m_per_s2)
        self._surface, self._rest_m = self._clamps, self._clamps.position_m

    def ahead(self, interval: Interval, clamps: Known) -> Known:
        """Return the motion of the points, as known as that of the clamps, which they are."""
        return clamps

    def _static_reaction_N(self) -> Array:
        return self._weight_N.copy()

    def _move(self, interval: Interval, clamps: Motion, load_N: Array) -> tuple[Motion, Array, float]:
        after, before = clamps.velocity_m_per_s, self._surface.velocity_m_per_s
        acceleration = (after - before) / interval.length_s
        reaction_N = load_N + self._mass_kg * (self._gravity_m_per_s2 - acceleration)
        moved_m = clamps.position_m - self._surface.position_m
        gained_J = float(np.sum(self._mass_kg * (after**2 - before**2)) / 2)
        return clamps, reaction_N, gained_J - float(np.vdot(load_N + self._weight_N, moved_m))
