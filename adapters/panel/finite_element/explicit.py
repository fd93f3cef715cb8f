"""Explicit time integration: velocity Verlet with a diagonal mass.

Verlet, Physical Review 159 (1967) 98-103, doi:10.1103/PhysRev.159.98; the same scheme is known as
the central difference method.  Second order, stable below  2 / (highest angular frequency).
"""

from __future__ import annotations

import numpy as np

from adapters.panel.common.body import Action, BodyState, HeldForce
from adapters.panel.finite_element.structure import Structure
from orchestrator.ports import Saved
from orchestrator.ports.clock import Interval


class Explicit:
    """Whole steps of at most ``largest_step_s`` that fill each sync interval."""

    def __init__(self, structure: Structure, largest_step_s: float) -> None:
        self._structure = structure
        self._largest_step_s = largest_step_s

    @np.errstate(over="ignore", invalid="ignore")  # the panel reports a blow-up
    def advance(self, state: BodyState, action: Action, interval: Interval) -> HeldForce:
        """Move ``state`` to the interval's end under ``action``."""
        body, held = self._structure, self._structure.held
        steps = interval.steps(self._largest_step_s)
        step_s = interval.length_s / steps
        x, v = state.position_m, state.velocity_m_per_s
        kick = (0.5 * step_s) * body.mobility_1_kg
        on_held = HeldForce.none(len(held))
        for step in range(1, steps + 1):
            fraction = step / steps
            v += kick * (action.outside_N - state.internal_N)
            before_m, before_N = x[held], state.internal_N[held]
            x += step_s * v
            x[held] = action.held.position_m(fraction)
            body.begin_step(step_s)
            state.internal_N = body.force_N(x)
            body.end_step()
            v += kick * (action.outside_N - state.internal_N)
            v[held] = action.held.velocity_m_per_s(fraction)
            on_held.add(step_s, 0.5 * (before_N + state.internal_N[held]), x[held] - before_m)
        return on_held

    def save(self) -> Saved:
        """A step remembers nothing that ``State`` and the structure do not know."""
        return {}

    def restore(self, saved: Saved) -> None:
        """Nothing to restore."""

    def close(self) -> None:
        """Nothing is open."""
