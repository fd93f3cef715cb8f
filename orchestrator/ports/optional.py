"""What optional calls of solvers answer, and what stands in for a solver that has none of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy.sparse import block_diag, csr_array

from orchestrator.ports import Following, Frames, Inert, Inertia, Known, Panel, Scheduled
from orchestrator.ports.clock import Interval

Ahead = Callable[[Interval, Known], Known]


def find_driven_points(frames: Frames, interval: Interval) -> Known | None:
    """Where the points that drives move are at the interval's end; None where nothing is driven."""
    return frames.ahead(interval) if isinstance(frames, Scheduled) else None


def surface_ahead(panel: Panel) -> Ahead:
    """``panel.ahead``; of a panel that knows nothing ahead, one that says just that."""
    if isinstance(panel, Following):
        return panel.ahead
    nothing = Known.nothing(len(panel.initial().surface))
    return lambda interval, clamps: nothing


def surface_inertia(panel: Panel) -> Inertia:
    """What a panel tells of its masses; unknown if nothing."""
    if isinstance(panel, Inert):
        return panel.inertia()
    return Inertia.unknown(len(panel.initial().surface))


def concatenate_inertias(parts: Sequence[Inertia]) -> Inertia:
    """Points and masses of all, one after the other."""
    return Inertia(
        csr_array(block_diag([part.shapes for part in parts])),
        np.concatenate([part.mass_kg for part in parts]),
        np.concatenate([part.held for part in parts]),
    )
