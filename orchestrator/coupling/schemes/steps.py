"""What schemes are made of: what is known of an interval's end, and one member moved over it."""

from __future__ import annotations

from dataclasses import dataclass

from orchestrator.coupling.schemes.exchange import Solvers, State
from orchestrator.ports import Array, Following, Known, Load, Motion, PanelState
from orchestrator.ports.ahead import carried_ahead
from orchestrator.ports.clock import Interval
from orchestrator.ports.hermite import Path


@dataclass(frozen=True)
class Ahead:
    """The end of an interval as it can be told before anything moves.

    ``clamps``: where their drives have them, and those without a drive as their last acceleration
    takes them on.  ``surface``: the points whose motion follows from driven clamps alone; None
    where nothing is driven.  ``start``: the surface now.
    """

    clamps: Motion
    surface: Known | None
    start: Motion

    @property
    def settled(self) -> bool:
        """Whether no load can change the surface's motion."""
        return self.surface is not None and bool(self.surface.which.all())

    def path(self, otherwise: Path) -> Path:
        """The surface's: the true one (cubic Hermite) where it is known."""
        if self.surface is None:
            return otherwise
        start = Known(self.start, self.surface.which).over(otherwise.start)
        return Path(start, self.surface.over(otherwise.end), otherwise.length_s)


def ahead(solvers: Solvers, interval: Interval, now: State) -> Ahead:
    """Of the interval that begins ``now``; nothing moves."""
    clamps = extrapolated(now.clamps, now.clamps_acceleration_m_per_s2, interval.length_s)
    known = carried_ahead(solvers.frames, interval)
    if known is None:
        return Ahead(clamps, None, now.panel.surface)
    surface = None
    if isinstance(solvers.panel, Following):
        surface = solvers.panel.ahead(interval, known)
    return Ahead(known.over(clamps), surface, now.panel.surface)


def ended(solvers: Solvers, interval: Interval, now: State, panel: PanelState, load: Load) -> State:
    """The frames move under the panel's reaction, and the interval is over."""
    clamps = solvers.frames.advance(interval, panel.reaction)
    return State(clamps, acceleration(now.clamps, clamps, interval), panel, load)


def chord(start: Motion, end: Motion, length_s: float) -> Path:
    """The straight path between two places, at constant velocity."""
    mean_m_per_s = (end.position_m - start.position_m) / length_s
    return Path(Motion(start.position_m, mean_m_per_s), Motion(end.position_m, mean_m_per_s), length_s)


def extrapolated(motion: Motion, acceleration_m_per_s2: Array, length_s: float) -> Motion:
    """Where points are after ``length_s`` at constant acceleration."""
    return Motion(
        motion.position_m + length_s * (motion.velocity_m_per_s + length_s / 2 * acceleration_m_per_s2),
        motion.velocity_m_per_s + length_s * acceleration_m_per_s2,
    )


def acceleration(before: Motion, after: Motion, interval: Interval) -> Array:
    """Mean over the interval."""
    return (after.velocity_m_per_s - before.velocity_m_per_s) / interval.length_s
