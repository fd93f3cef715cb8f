"""A rigid surface that one frame carries: side walls, a feed chute, probes on a frame.

Every point is a clamp, so the surface moves with the frame exactly and hands every load
through.  It has no mass (its mass belongs to the frame) and no mesh to map from: the particles
touch its points themselves, hence it is a ``Panel`` but not a ``MeshedPanel``.
"""

from __future__ import annotations

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

_STATE = ("_position_m", "_received_J")


def build(points_m: Array, frame: str) -> CarriedSurface:
    """``points_m`` (n, 3) in the world at t = 0, all carried by ``frame``."""
    return CarriedSurface(Mount(points_m, (frame,) * len(points_m)))


class CarriedSurface:
    """``Panel`` whose surface is its clamps."""

    def __init__(self, mount: Mount) -> None:
        self.mount = mount
        self._position_m = mount.position_m
        self._received_J = 0.0

    def initial(self) -> PanelState:
        rest = Motion(self.mount.position_m, np.zeros_like(self.mount.position_m))
        return PanelState(rest, Load.zero(len(rest)))

    def advance(self, interval: Interval, clamps: Motion, load: Load) -> PanelState:
        check_point_count("carried surface's clamps", clamps, len(self.mount.frame))
        check_point_count("carried surface's load", load, len(self.mount.frame))
        moved_m = clamps.position_m - self._position_m
        self._received_J += float(np.sum(load.force_N * moved_m))
        self._position_m = clamps.position_m
        return PanelState(clamps, load)

    def ahead(self, interval: Interval, clamps: Known) -> Known:
        return clamps

    def account(self) -> Account:
        received_J = {"load": self._received_J, "clamps": -self._received_J}
        return Account(np.zeros(3), np.zeros(3), received_J=received_J)

    def save(self) -> Saved:
        return save_attributes(self, *_STATE)

    def restore(self, saved: Saved) -> None:
        restore_attributes(self, saved, *_STATE)

    def close(self) -> None:
        pass
