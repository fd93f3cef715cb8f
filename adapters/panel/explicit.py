"""Explicit time integration: velocity Verlet with a diagonal mass.

Verlet, Physical Review 159 (1967) 98-103, doi:10.1103/PhysRev.159.98; the same scheme is known as
the central difference method.  Second order, stable below  2 / (highest angular frequency).
"""

from __future__ import annotations

import numpy as np

from adapters.panel.state import HeldForce, State
from adapters.panel.structure import Structure
from orchestrator.clock import Interval
from orchestrator.hermite import Path
from orchestrator.ports import Array


class Explicit:
    """Whole steps of at most ``largest_step_s`` that fill each sync interval."""

    def __init__(self, structure: Structure, largest_step_s: float) -> None:
        self._structure = structure
        self._largest_step_s = largest_step_s
        self._mobility = np.zeros((len(structure.mass_kg), 1))  # 1/kg, zero where held
        self._mobility[structure.free, 0] = 1.0 / structure.mass_kg[structure.free]

    def advance(self, state: State, path: Path, outside_N: Array, interval: Interval) -> HeldForce:
        """Move ``state`` to the interval's end while ``outside_N`` (nodes, 3) acts on it."""
        body, held = self._structure, self._structure.held
        steps = interval.steps(self._largest_step_s)
        step_s = interval.length_s / steps
        x, v = state.position_m, state.velocity_m_s
        kick = (0.5 * step_s) * self._mobility
        on_held = HeldForce.none(len(held))
        for step in range(1, steps + 1):
            fraction = step / steps
            v += kick * (outside_N - state.internal_N)
            before_m, before_N = x[held], state.internal_N[held]
            x += step_s * v
            x[held] = path.position_m(fraction)
            body.begin_step(step_s)
            state.internal_N = body.force_N(x)
            body.end_step()
            v += kick * (outside_N - state.internal_N)
            v[held] = path.velocity_m_s(fraction)
            on_held.add(step_s, 0.5 * (before_N + state.internal_N[held]), x[held] - before_m)
        return on_held
