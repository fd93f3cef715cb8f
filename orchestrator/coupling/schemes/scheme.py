"""The definition of a coupling scheme: it carries the state of all solvers from one sync point to the next.

Each scheme is a short function that reads like its formula.  The schemes stand beside this file, one file per
family; the package's ``__init__.py`` has their names.  The second half of this file holds the steps that
schemes share.  docs/theory/coupling.md derives the schemes; tests/coupling measures their order.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from orchestrator.ports import (
    Array,
    Following,
    Frames,
    HermitePath,
    Known,
    Load,
    Motion,
    Panel,
    PanelState,
    Particles,
    Restorable,
)
from orchestrator.ports.clock import Interval
from orchestrator.ports.frames import find_driven_points


@dataclass(frozen=True)
class Solvers:
    """The members of a coupled run; ``particles`` is None where the case has none."""

    frames: Frames
    panel: Panel
    particles: Particles | None


@dataclass(frozen=True)
class State:
    """The state of the coupling at a sync point.

    ``clamps`` is the motion of the frames' carried points, and ``clamps_acceleration_m_per_s2`` their mean
    acceleration over the last interval.  ``panel`` has the surface motion and the reaction.  ``load`` is the
    particles' mean force on the surface over the last interval.
    """

    clamps: Motion
    clamps_acceleration_m_per_s2: Array
    panel: PanelState
    load: Load


@dataclass(frozen=True)
class Pending:
    """The impulses, (3,) each, that were given at a sync point but not yet received above, and their moments
    about the world's origin."""

    load_N_s: Array
    reaction_N_s: Array
    load_N_m_s: Array
    reaction_N_m_s: Array


class Memory(Restorable, Protocol):
    """The memory of a scheme from interval to interval, the same on every rank."""

    def figures(self) -> dict[str, Any]:
        """Return the scheme's entry of ``summary.json``."""
        ...


@dataclass(frozen=True)
class Scheme:
    """A coupling scheme.

    ``advance`` carries the state over an interval.  With ``late``, loads act one interval late.  ``memory``
    is None if the scheme remembers nothing beside the state.
    """

    advance: Callable[[Solvers, Interval, State], State]
    late: bool = False
    memory: Memory | None = None

    def pending(self, state: State, interval: Interval) -> Pending:
        """Return the impulses that are in transit after ``interval``."""
        late_s = interval.length_s if self.late else 0.0
        load_N, reaction_N = state.load.force_N, state.panel.reaction.force_N
        clamps = slice(len(reaction_N))  # the first of the carried points
        return Pending(
            late_s * load_N.sum(axis=0),
            late_s * reaction_N.sum(axis=0),
            late_s * np.cross(state.panel.surface.position_m, load_N).sum(axis=0),
            late_s * np.cross(state.clamps.position_m[clamps], reaction_N).sum(axis=0),
        )

    def figures(self) -> dict[str, Any]:
        """Return the scheme's entry of ``summary.json``."""
        return self.memory.figures() if self.memory is not None else {}


def initial_state(solvers: Solvers) -> State:
    """Return the state at t = 0, before anything has moved."""
    clamps = solvers.frames.initial()
    panel = solvers.panel.initial()
    load = solvers.particles.initial() if solvers.particles else Load.zero(len(panel.surface))
    return State(clamps, 0.0 * clamps.velocity_m_per_s, panel, load)


@dataclass(frozen=True)
class Forecast:
    """The end of an interval, as far as it can be predicted before anything moves.

    ``clamps`` is the motion of the carried points from their drives or, without a drive, from their last
    acceleration.  ``surface`` has the points whose motion follows from driven clamps alone, and is None
    if no clamp is driven.  ``start`` is the surface now.
    """

    clamps: Motion
    surface: Known | None
    start: Motion

    @property
    def is_settled(self) -> bool:
        """True if drives alone settle the surface's motion, so that no load can change it."""
        return self.surface is not None and bool(self.surface.which.all())

    def path(self, otherwise: HermitePath) -> HermitePath:
        """Return the surface's true path (cubic Hermite) where it is known, and ``otherwise`` elsewhere."""
        if self.surface is None:
            return otherwise
        start = Known(self.start, self.surface.which).over(otherwise.start)
        return HermitePath(start, self.surface.over(otherwise.end), otherwise.length_s)


def forecast(solvers: Solvers, interval: Interval, now: State) -> Forecast:
    """Return the forecast of the interval that begins in the state ``now``, without moving anything."""
    clamps = extrapolate(now.clamps, now.clamps_acceleration_m_per_s2, interval.length_s)
    known = find_driven_points(solvers.frames, interval)
    if known is None:
        return Forecast(clamps, None, now.panel.surface)
    surface = None
    if isinstance(solvers.panel, Following):
        surface = solvers.panel.ahead(interval, known)
    return Forecast(known.over(clamps), surface, now.panel.surface)


def finish_interval(solvers: Solvers, interval: Interval, now: State, panel: PanelState, load: Load) -> State:
    """Move the frames under the panel's reaction, and return the state at the interval's end."""
    clamps = solvers.frames.advance(interval, panel.reaction)
    return State(clamps, mean_acceleration(now.clamps, clamps, interval), panel, load)


def chord(start: Motion, end: Motion, length_s: float) -> HermitePath:
    """Return the straight path between two places, at constant velocity."""
    mean_m_per_s = (end.position_m - start.position_m) / length_s
    return HermitePath(Motion(start.position_m, mean_m_per_s), Motion(end.position_m, mean_m_per_s), length_s)


def extrapolate(motion: Motion, acceleration_m_per_s2: Array, length_s: float) -> Motion:
    """Return the motion of points after ``length_s`` at constant acceleration."""
    return Motion.unchecked(
        motion.position_m + length_s * (motion.velocity_m_per_s + length_s / 2 * acceleration_m_per_s2),
        motion.velocity_m_per_s + length_s * acceleration_m_per_s2,
    )


def mean_acceleration(before: Motion, after: Motion, interval: Interval) -> Array:
    """Return the mean acceleration (points, 3) over the interval."""
    return (after.velocity_m_per_s - before.velocity_m_per_s) / interval.length_s
