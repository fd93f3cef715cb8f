"""The coupling: who acts on what within a sync interval.

A scheme carries the state at a sync point to the next one; each is a short function that reads
like its formula.  They stand beside this file, one file per family; names and choice in the
package's ``__init__.py``.  docs/theory/coupling.md derives them; tests/coupling measures their
order.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from orchestrator.ports import Array, Frames, Load, Motion, Panel, PanelState, Particles, Restorable
from orchestrator.ports.clock import Interval


@dataclass(frozen=True)
class Solvers:
    """The members of a coupled run; ``particles`` is None where the case has none."""

    frames: Frames
    panel: Panel
    particles: Particles | None


@dataclass(frozen=True)
class State:
    """All that the coupling knows at a sync point.

    ``clamps``: the frames' carried points; ``clamps_acceleration_m_per_s2`` their mean acceleration
    over the last interval; ``panel``: surface motion and reaction; ``load``: the particles' mean
    force on the surface over the last interval.
    """

    clamps: Motion
    clamps_acceleration_m_per_s2: Array
    panel: PanelState
    load: Load


@dataclass(frozen=True)
class Pending:
    """Impulse, (3,) each, that was given at a sync point but not yet received above, and its
    moments about the world's origin."""

    load_N_s: Array
    reaction_N_s: Array
    load_N_m_s: Array
    reaction_N_m_s: Array


class Memory(Restorable, Protocol):
    """What a scheme remembers from interval to interval; alike on every rank."""

    def figures(self) -> dict[str, Any]:
        """For ``summary.json``."""
        ...


@dataclass(frozen=True)
class Scheme:
    """``advance`` carries the state over an interval; ``late``: loads act one interval late;
    ``memory`` is None where nothing is remembered but the state."""

    advance: Callable[[Solvers, Interval, State], State]
    late: bool = False
    memory: Memory | None = None

    def pending(self, state: State, interval: Interval) -> Pending:
        """What is in transit after ``interval``."""
        held_s = interval.length_s if self.late else 0.0
        load_N, reaction_N = state.load.force_N, state.panel.reaction.force_N
        clamps = slice(len(reaction_N))  # the first of the carried points
        return Pending(
            held_s * load_N.sum(axis=0),
            held_s * reaction_N.sum(axis=0),
            held_s * np.cross(state.panel.surface.position_m, load_N).sum(axis=0),
            held_s * np.cross(state.clamps.position_m[clamps], reaction_N).sum(axis=0),
        )

    def figures(self) -> dict[str, Any]:
        """For ``summary.json``."""
        return self.memory.figures() if self.memory is not None else {}


def initial(solvers: Solvers) -> State:
    """Everything at t = 0, before anything has moved."""
    clamps = solvers.frames.initial()
    panel = solvers.panel.initial()
    load = solvers.particles.initial() if solvers.particles else Load.zero(len(panel.surface))
    return State(clamps, 0.0 * clamps.velocity_m_per_s, panel, load)
