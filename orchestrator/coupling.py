"""The coupling: in which order the solvers act within a sync interval, and on what.

A scheme is one short function from the state at a sync point to the state at the next.

``particles_first`` (the default): every member acts on the *extrapolated* motion of the heavier
one above it and hands its mean load of the *same* interval up: particles, then panels, then
frames.  Momentum is exact at every interface; the energy created in an elastic contact falls
with the third power of the interval between two rigid bodies, with the second on a panel.

``serial_staggered``: the conventional order (Farhat, C. and Lesoinne, M., Computer Methods in
Applied Mechanics and Engineering 182, 2000, 499-515, doi 10.1016/S0045-7825(99)00206-6):
frames, panels, particles, each load one interval late.  Momentum is exact, but a load that lags
acts like negative damping: first order, and it adds energy.

docs/theory/coupling.md derives both; tests/coupling measures their order.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from orchestrator.clock import Interval
from orchestrator.hermite import Path
from orchestrator.ports import Array, Frames, Load, Motion, Panel, PanelState, Particles


@dataclass(frozen=True)
class Solvers:
    """The members of a coupled run; ``particles`` is None where the case has none."""

    frames: Frames
    panel: Panel
    particles: Particles | None


@dataclass(frozen=True)
class State:
    """All that the coupling knows at a sync point.

    ``clamps``: the frames' carried points; ``clamps_acceleration_m_s2`` their mean acceleration
    over the last interval; ``panel``: surface motion and reaction; ``load``: the particles' mean
    force on the surface over the last interval.
    """

    clamps: Motion
    clamps_acceleration_m_s2: Array
    panel: PanelState
    load: Load


@dataclass(frozen=True)
class Pending:
    """Impulse, (3,) each, that was given at a sync point but not yet received above."""

    load_N_s: Array
    reaction_N_s: Array


def initial(solvers: Solvers) -> State:
    """Everything at t = 0, before anything has moved."""
    clamps = solvers.frames.initial()
    panel = solvers.panel.initial()
    load = solvers.particles.initial() if solvers.particles else Load.zero(len(panel.surface))
    return State(clamps, 0.0 * clamps.velocity_m_s, panel, load)


def particles_first(solvers: Solvers, interval: Interval, now: State) -> State:
    """Load runs up within the interval, motion is extrapolated down."""
    load = _particles_on(solvers, interval, drifted(now.panel.surface, interval.length_s), now)
    ahead = extrapolated(now.clamps, now.clamps_acceleration_m_s2, interval.length_s)
    panel = solvers.panel.advance(interval, ahead, load)
    clamps = solvers.frames.advance(interval, panel.reaction)
    return State(clamps, _acceleration(now.clamps, clamps, interval), panel, load)


def serial_staggered(solvers: Solvers, interval: Interval, now: State) -> State:
    """Motion runs down within the interval, load is the last interval's."""
    clamps = solvers.frames.advance(interval, now.panel.reaction)
    panel = solvers.panel.advance(interval, clamps, now.load)
    load = _particles_on(solvers, interval, panel.surface, now)
    return State(clamps, _acceleration(now.clamps, clamps, interval), panel, load)


@dataclass(frozen=True)
class Scheme:
    """``advance`` carries the state over an interval; ``late``: loads act one interval late."""

    advance: Callable[[Solvers, Interval, State], State]
    late: bool

    def pending(self, state: State, interval: Interval) -> Pending:
        """What is in transit after ``interval``."""
        held_s = interval.length_s if self.late else 0.0
        return Pending(
            held_s * state.load.force_N.sum(axis=0),
            held_s * state.panel.reaction.force_N.sum(axis=0),
        )


SCHEMES = {
    "particles-first": Scheme(particles_first, late=False),
    "serial-staggered": Scheme(serial_staggered, late=True),
}


def drifted(motion: Motion, length_s: float) -> Motion:
    """Where points are after ``length_s`` at constant velocity."""
    return Motion(motion.position_m + length_s * motion.velocity_m_s, motion.velocity_m_s)


def extrapolated(motion: Motion, acceleration_m_s2: Array, length_s: float) -> Motion:
    """Where points are after ``length_s`` at constant acceleration."""
    return Motion(
        motion.position_m + length_s * (motion.velocity_m_s + length_s / 2 * acceleration_m_s2),
        motion.velocity_m_s + length_s * acceleration_m_s2,
    )


def _particles_on(solvers: Solvers, interval: Interval, end: Motion, now: State) -> Load:
    if solvers.particles is None:
        return now.load  # zero for ever
    return solvers.particles.advance(interval, Path(now.panel.surface, end, interval.length_s))


def _acceleration(before: Motion, after: Motion, interval: Interval) -> Array:
    return (after.velocity_m_s - before.velocity_m_s) / interval.length_s
