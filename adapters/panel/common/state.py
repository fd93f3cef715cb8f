"""What the time integrators change, and what they tell about the held nodes."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from orchestrator.ports import Array, Saved
from orchestrator.ports.hermite import Path
from orchestrator.ports.state import taken


@dataclass
class State:
    """Nodal positions, velocities and internal forces (nodes, 3) at one instant.

    ``filtered_N`` is the internal force as the implicit scheme averages it over past steps.
    """

    position_m: Array
    velocity_m_per_s: Array
    internal_N: Array
    filtered_N: Array = field(init=False)

    def __post_init__(self) -> None:
        self.filtered_N = self.internal_N.copy()

    def moved(self) -> list[Array]:
        """What an explicit step changes, in the order of the fields."""
        return [self.position_m, self.velocity_m_per_s, self.internal_N]

    def save(self) -> Saved:
        return taken(self, *vars(self))

    def restore(self, saved: Saved) -> None:
        """Into the arrays that are there: compiled code works on them."""
        for name, array in vars(self).items():
            array[:] = saved[name]

    @staticmethod
    def at_rest(position_m: Array, internal_N: Array) -> State:
        return State(position_m.copy(), np.zeros_like(position_m), internal_N)


@dataclass(frozen=True)
class Action:
    """What acts on a body during an interval: the path of its held nodes, and a constant force
    (nodes, 3) from outside, weight included."""

    held: Path
    outside_N: Array


@dataclass
class HeldForce:
    """Internal force at the held nodes over an interval: its impulse (held, 3) and its work on
    their motion, both with the mean force that the scheme itself uses in each step."""

    impulse_N_s: Array
    work_J: float

    @staticmethod
    def none(held: int) -> HeldForce:
        return HeldForce(np.zeros((held, 3)), 0.0)

    def add(self, step_s: float, force_N: Array, moved_m: Array) -> None:
        self.impulse_N_s += step_s * force_N
        self.work_J += float(np.vdot(force_N, moved_m))
