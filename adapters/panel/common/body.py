"""What time integrators change, what acts on a body, and a body whose explicit loop is compiled."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from orchestrator.ports import Array, HermitePath, Indices, Saved
from orchestrator.ports.state import save_attributes

if TYPE_CHECKING:
    from adapters.panel import _kernel


@dataclass
class BodyState:
    """Nodal positions, velocities and internal forces (nodes, 3) at one instant.

    ``filtered_N`` is the internal force as the implicit scheme averages it over past steps.
    """

    position_m: Array
    velocity_m_per_s: Array
    internal_N: Array
    filtered_N: Array = field(init=False)

    def __post_init__(self) -> None:
        self.filtered_N = self.internal_N.copy()

    @staticmethod
    def at_rest(position_m: Array, internal_N: Array) -> BodyState:
        """Return the state of a body that stands still at ``position_m`` under ``internal_N``."""
        return BodyState(position_m.copy(), np.zeros_like(position_m), internal_N)

    def save(self) -> Saved:
        return save_attributes(self, *vars(self))

    def restore(self, saved: Saved) -> None:
        """Restore into the arrays that are there: compiled code works on them."""
        for name, array in vars(self).items():
            array[:] = saved[name]


@dataclass(frozen=True)
class Action:
    """What acts on a body during an interval: the path of its held nodes, and a constant force
    (nodes, 3) from outside, weight included."""

    held: HermitePath
    outside_N: Array


@dataclass
class HeldForce:
    """Internal force at the held nodes over an interval: its impulse (held, 3) and its work on
    their motion, both with the mean force that the scheme itself uses in each step."""

    impulse_N_s: Array
    work_J: float

    @staticmethod
    def none(held: int) -> HeldForce:
        """Return that of no step yet."""
        return HeldForce(np.zeros((held, 3)), 0.0)

    def add(self, step_s: float, force_N: Array, moved_m: Array) -> None:
        """Add a step with this mean force and these displacements of the held nodes, (held, 3) each."""
        self.impulse_N_s += step_s * force_N
        self.work_J += float(np.vdot(force_N, moved_m))


class CompiledBody:
    """A body whose explicit steps are compiled code (``kernel/``).

    ``memory`` holds, by name, the arrays that change while the body moves; the compiled code works on
    these very arrays.  ``held`` are the numbers of the prescribed points.
    """

    def __init__(self, kernel: _kernel.Sheet | _kernel.Chain, held: Indices, memory: Mapping[str, Array]):
        self._kernel, self.held, self.memory = kernel, held, memory

    def move(self, action: Action, steps: int) -> HeldForce:
        """Move over an interval in equal steps under ``action``."""
        path, impulse_N_s = action.held, np.zeros((len(self.held), 3))
        work_J = self._kernel.advance(
            start_m=path.start.position_m,
            start_m_per_s=path.start.velocity_m_per_s,
            end_m=path.end.position_m,
            end_m_per_s=path.end.velocity_m_per_s,
            outside_N=action.outside_N,
            length_s=path.length_s,
            steps=steps,
            impulse_N_s=impulse_N_s,
        )
        return HeldForce(impulse_N_s, work_J)

    def lost_J(self) -> float:
        """Return the energy that the Maxwell branches have dissipated since the start."""
        return float(self.memory["lost_J"][0])

    def save(self) -> Saved:
        return {name: array.copy() for name, array in self.memory.items()}

    def restore(self, saved: Saved) -> None:
        for name, array in self.memory.items():
            array[:] = saved[name]
