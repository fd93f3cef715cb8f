"""What schemes are made of: one member moved over an interval."""

from __future__ import annotations

from orchestrator.clock import Interval
from orchestrator.coupling import Solvers, State
from orchestrator.hermite import Path
from orchestrator.ports import Array, Load, Motion, PanelState


def panel_moved(solvers: Solvers, interval: Interval, now: State, load: Load) -> PanelState:
    """The panel under a load, between clamps that go on as in the last interval."""
    ahead = extrapolated(now.clamps, now.clamps_acceleration_m_s2, interval.length_s)
    return solvers.panel.advance(interval, ahead, load)


def ended(solvers: Solvers, interval: Interval, now: State, panel: PanelState, load: Load) -> State:
    """The frames move under the panel's reaction, and the interval is over."""
    clamps = solvers.frames.advance(interval, panel.reaction)
    return State(clamps, acceleration(now.clamps, clamps, interval), panel, load)


def chord(start: Motion, end: Motion, length_s: float) -> Path:
    """The straight path between two places, at constant velocity."""
    mean_m_s = (end.position_m - start.position_m) / length_s
    return Path(Motion(start.position_m, mean_m_s), Motion(end.position_m, mean_m_s), length_s)


def extrapolated(motion: Motion, acceleration_m_s2: Array, length_s: float) -> Motion:
    """Where points are after ``length_s`` at constant acceleration."""
    return Motion(
        motion.position_m + length_s * (motion.velocity_m_s + length_s / 2 * acceleration_m_s2),
        motion.velocity_m_s + length_s * acceleration_m_s2,
    )


def acceleration(before: Motion, after: Motion, interval: Interval) -> Array:
    """Mean over the interval."""
    return (after.velocity_m_s - before.velocity_m_s) / interval.length_s
