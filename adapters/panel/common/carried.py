"""Surfaces whose clamps determine the places of all points: walls, chutes and probes on frames, and the
common parts of rigid panels."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from adapters.panel.common.panel import AccountedPanel
from orchestrator.ports import Array, Known, Motion, Mount
from orchestrator.ports.clock import Interval

if TYPE_CHECKING:
    from scipy.sparse import csr_array


def build(points_m: Array, frame: tuple[str, ...]) -> RigidSurface:
    """Open a rigid surface of ``points_m`` (n, 3) in the world at t = 0, each carried by its ``frame``."""
    mount = Mount(points_m, frame)
    return RigidSurface("rigid surfaces", mount, np.zeros(len(points_m)), np.zeros(3))


class RigidSurface(AccountedPanel):
    """Walls and observed points: every point is a clamp, moves as its frame does, and passes its load on.

    It has no mass (its mass belongs to the frame) and no mesh to map from: the particles touch its points
    themselves, hence it is a ``Panel`` but not a ``MeshedPanel``.
    """

    def __init__(self, name: str, mount: Mount, mass_kg: Array, gravity_m_per_s2: Array) -> None:
        super().__init__(name, mount, mass_kg, gravity_m_per_s2)
        self._surface, self._rest_m = self._clamps, self._clamps.position_m

    def ahead(self, interval: Interval, clamps: Known) -> Known:
        """Return the motion of the points, as known as that of the clamps, which they are."""
        return clamps

    def _static_reaction_N(self) -> Array:
        return np.zeros_like(self._rest_m)

    def _move(self, interval: Interval, clamps: Motion, load_N: Array) -> tuple[Motion, Array, float]:
        moved_m = clamps.position_m - self._clamps.position_m
        return clamps, load_N, -float(np.vdot(load_N, moved_m))


class CarriedSurface(AccountedPanel):
    """A ``Panel`` of prescribed shape: surface = N clamps, with N = 1 unless ``carried`` gives another.

    The reaction is the force that moves its masses and bears its load: N^T (load + m (gravity - mean
    acceleration)), with the sum over its points.  Linear momentum is exact.  ``carried`` is N (points,
    clamps) and ``mass_kg`` (points,).
    """

    def __init__(
        self,
        name: str,
        mount: Mount,
        mass_kg: Array,
        gravity_m_per_s2: Array,
        carried: Array | csr_array | None = None,
    ) -> None:
        from scipy.sparse import identity

        super().__init__(name, mount, mass_kg, gravity_m_per_s2)
        self._carried = identity(len(mass_kg), format="csr") if carried is None else carried
        self._transposed, self._sizes = self._carried.T.copy(), abs(self._carried)
        self._surface = self._place(self._clamps, 0.0)
        self._rest_m = self._surface.position_m

    def ahead(self, interval: Interval, clamps: Known) -> Known:
        """Return the motion of the points whose clamps are all known."""
        which = self._sizes @ np.where(clamps.which, 0.0, 1.0) == 0.0
        return Known(self._place(clamps.motion, interval.end_s), which)

    def _static_reaction_N(self) -> Array:
        return np.asarray(self._transposed @ self._weight_N + self._pull_N(0.0))

    def _move(self, interval: Interval, clamps: Motion, load_N: Array) -> tuple[Motion, Array, float]:
        surface, before = self._place(clamps, interval.end_s), self._surface
        acceleration = (surface.velocity_m_per_s - before.velocity_m_per_s) / interval.length_s
        through_N = load_N + self._mass_kg * (self._gravity_m_per_s2 - acceleration)
        middle_s = (interval.start_s + interval.end_s) / 2
        reaction_N = self._transposed @ through_N + self._pull_N(middle_s)
        return surface, reaction_N, self._clamps_work_J(clamps, surface, load_N, through_N, reaction_N)

    def _place(self, clamps: Motion, time_s: float) -> Motion:
        """Return the surface between clamps with the given motion."""
        return Motion(self._carried @ clamps.position_m, self._carried @ clamps.velocity_m_per_s)

    def _pull_N(self, time_s: float) -> Array | float:
        """Return the forces (clamps, 3) of the clamps on each other through the surface."""
        return 0.0

    def _clamps_work_J(
        self, clamps: Motion, surface: Motion, load_N: Array, through_N: Array, reaction_N: Array
    ) -> float:
        """Return the work of the clamps' force  m (a - gravity) - load  along the surface's path."""
        moved_m = surface.position_m - self._surface.position_m
        after, before = surface.velocity_m_per_s, self._surface.velocity_m_per_s
        gained_J = float(np.sum(self._mass_kg * (after**2 - before**2)) / 2)
        return gained_J - float(np.sum((load_N + self._weight_N) * moved_m))
