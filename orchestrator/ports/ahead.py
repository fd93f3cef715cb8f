"""What is known of points ahead of the loads on them, of any frames and of any panel."""

from __future__ import annotations

from collections.abc import Callable

from orchestrator.ports import Following, Frames, Known, Panel, Scheduled
from orchestrator.ports.clock import Interval

Ahead = Callable[[Interval, Known], Known]


def carried_ahead(frames: Frames, interval: Interval) -> Known | None:
    """Where the points that drives move are at the interval's end; None where nothing is driven."""
    return frames.ahead(interval) if isinstance(frames, Scheduled) else None


def ahead_of(panel: Panel) -> Ahead:
    """``panel.ahead``; of a panel that knows nothing ahead, one that says just that."""
    if isinstance(panel, Following):
        return panel.ahead
    nothing = Known.nothing(len(panel.initial().surface))
    return lambda interval, clamps: nothing
