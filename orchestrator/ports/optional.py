"""What optional calls of solvers answer, and what stands in for a solver that has none of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy.sparse import block_diag, csr_array

from orchestrator.ports import Following, Frames, Inert, Inertia, Known, Panel, Scheduled
from orchestrator.ports.clock import Interval

Ahead = Callable[[Interval, Known], Known]


def find_driven_points(frames: Frames, interval: Interval) -> Known | None:
    """Tells where the points that drives move are at the interval's end.

    Parameters
    ----------
    frames
        Any frames, ``Scheduled`` or not.
    interval
        The next interval.

    Returns
    -------
    Known or None
        None where nothing is driven.
    """
    return frames.ahead(interval) if isinstance(frames, Scheduled) else None


def surface_ahead(panel: Panel) -> Ahead:
    """Returns ``panel.ahead``, or for a panel without it a call that knows no point ahead."""
    if isinstance(panel, Following):
        return panel.ahead
    nothing = Known.nothing(len(panel.initial().surface))
    return lambda interval, clamps: nothing


def surface_inertia(panel: Panel) -> Inertia:
    """Returns the masses behind a panel's surface points, unknown ones for a panel that tells none."""
    if isinstance(panel, Inert):
        return panel.inertia()
    return Inertia.unknown(len(panel.initial().surface))


def concatenate_inertias(parts: Sequence[Inertia]) -> Inertia:
    """Returns the points and masses of all parts, one after the other."""
    return Inertia(
        csr_array(block_diag([part.shapes for part in parts])),
        np.concatenate([part.mass_kg for part in parts]),
        np.concatenate([part.held for part in parts]),
    )
