"""Surfaces whose clamps say where all of their points are: walls, chutes and probes on one frame, and
what rigid and recorded panels share."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from orchestrator.ports import (
    Account,
    Array,
    Known,
    Load,
    Motion,
    Mount,
    PanelState,
    Saved,
    check_point_count,
)
from orchestrator.ports.clock import Interval
from orchestrator.ports.state import restore_attributes, save_attributes

if TYPE_CHECKING:
    from scipy.sparse import csr_array


def build(points_m: Array, frame: str) -> CarriedSurface:
    """Open a rigid surface of ``points_m`` (n, 3) in the world at t = 0, all carried by ``frame``.

    It has no mass (its mass belongs to the frame) and no mesh to map from: the particles touch its
    points themselves, hence it is a ``Panel`` but not a ``MeshedPanel``.
    """
    return CarriedSurface(f"surface on {frame}", Mount(points_m, (frame,) * len(points_m)))


class CarriedSurface:
    """A ``Panel`` of prescribed shape: surface = N clamps, as it stands here with N = 1.

    The reaction is what it takes to move its masses and to bear its load:
    N^T (load + m (gravity - mean acceleration)), with the sum over its points.  Linear momentum is
    exact.  ``carried`` is N (points, clamps) and ``mass_kg`` (points,).
    """

    STATE: ClassVar[tuple[str, ...]] = ("_clamps", "_surface", "_elapsed_s", "_received_J")

    def __init__(
        self,
        name: str,
        mount: Mount,
        carried: Array | csr_array | None = None,
        mass_kg: Array | None = None,
        gravity_m_per_s2: Array | None = None,
    ) -> None:
        from scipy.sparse import identity

        self.mount, self._name, clamps = mount, name, len(mount.position_m)
        self._carried = identity(clamps, format="csr") if carried is None else carried
        points = self._carried.shape[0]
        self._mass_kg = np.zeros((points, 1)) if mass_kg is None else mass_kg[:, None]
        self._gravity_m_per_s2 = np.zeros(3) if gravity_m_per_s2 is None else gravity_m_per_s2
        self._clamps = Motion(mount.position_m, np.zeros_like(mount.position_m))
        self._surface = self._rest = self._placed(self._clamps, 0.0)
        self._elapsed_s, self._received_J = 0.0, {"load": 0.0, "clamps": 0.0}

    def initial(self) -> PanelState:
        weight_N = self._carried.T @ (self._mass_kg * self._gravity_m_per_s2)
        return PanelState(self._surface, Load(weight_N + self._pull_N(0.0)))

    def advance(self, interval: Interval, clamps: Motion, load: Load) -> PanelState:
        check_point_count(f"{self._name}: clamps", clamps, len(self._clamps))
        check_point_count(f"{self._name}: load", load, len(self._surface))
        surface, before = self._placed(clamps, interval.end_s), self._surface
        acceleration = (surface.velocity_m_per_s - before.velocity_m_per_s) / interval.length_s
        through_N = load.force_N + self._mass_kg * (self._gravity_m_per_s2 - acceleration)
        middle_s = (interval.start_s + interval.end_s) / 2
        reaction_N = self._carried.T @ through_N + self._pull_N(middle_s)
        self._received_J["load"] += float(np.sum(load.force_N * (surface.position_m - before.position_m)))
        self._book(clamps, surface, load.force_N, through_N, reaction_N)
        self._clamps, self._surface = clamps, surface
        self._elapsed_s += interval.length_s
        return PanelState(surface, Load(reaction_N))

    def ahead(self, interval: Interval, clamps: Known) -> Known:
        """Return the points that hang on clamps which are all known."""
        which = abs(self._carried) @ np.where(clamps.which, 0.0, 1.0) == 0.0
        return Known(self._placed(clamps.motion, interval.end_s), which)

    def account(self) -> Account:
        mass_kg, now = self._mass_kg, self._surface
        risen_m = now.position_m - self._rest.position_m
        return Account(
            (mass_kg * now.velocity_m_per_s).sum(axis=0),
            mass_kg.sum() * self._gravity_m_per_s2 * self._elapsed_s,
            stored_J={
                "kinetic": self._kinetic_J(now),
                "gravitational": -float(np.sum(mass_kg * risen_m * self._gravity_m_per_s2)),
            },
            received_J=dict(self._received_J),
        )

    def save(self) -> Saved:
        return save_attributes(self, *self.STATE)

    def restore(self, saved: Saved) -> None:
        restore_attributes(self, saved, *self.STATE)

    def close(self) -> None:
        pass

    def _placed(self, clamps: Motion, time_s: float) -> Motion:
        """The surface between clamps that move so."""
        return Motion(self._carried @ clamps.position_m, self._carried @ clamps.velocity_m_per_s)

    def _pull_N(self, time_s: float) -> Array | float:
        """Forces (clamps, 3) of the clamps on each other through the surface."""
        return 0.0

    def _book(
        self, clamps: Motion, surface: Motion, load_N: Array, through_N: Array, reaction_N: Array
    ) -> None:
        """Book the work of the clamps' force  m (a - gravity) - load  along the surface's path."""
        moved_m = surface.position_m - self._surface.position_m
        held_N = load_N + self._mass_kg * self._gravity_m_per_s2
        faster_J = self._kinetic_J(surface) - self._kinetic_J(self._surface)
        self._received_J["clamps"] += faster_J - float(np.sum(held_N * moved_m))

    def _kinetic_J(self, motion: Motion) -> float:
        return float(np.sum(self._mass_kg * motion.velocity_m_per_s**2) / 2)
