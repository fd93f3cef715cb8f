"""A body whose explicit steps are compiled code (``kernel/``)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from adapters.panel.common.maxwell import check_branches
from adapters.panel.common.panel import Body, HeldForce
from orchestrator.ports import Array, HermitePath, Indices, Saved
from orchestrator.ports.clock import Interval
from orchestrator.ports.plans import SolverMissing

try:
    from adapters.panel import _kernel as kernel
except ImportError as missing:
    raise SolverMissing(
        "the panel solvers 'sheet' and 'strip' need their compiled part, which docker/setup.sh "
        f"builds: {missing}"
    ) from missing

__all__ = ["CompiledBody", "kernel"]


class CompiledBody(Body):
    """A body in steps of at most ``step_s``, moved by an object of the compiled class ``compiled``.

    ``constants`` and ``memory`` are its arguments by name.  ``memory`` holds the state that changes beside
    position, velocity and internal force, which have the shape ``vectors``; the compiled code works on these
    very arrays.
    """

    def __init__(
        self,
        compiled: type[kernel.Sheet | kernel.Chain],
        step_s: float,
        vectors: tuple[int, int],
        mass_kg: Array,
        held: Indices,
        branches: tuple[tuple[float, float], ...],
        constants: Mapping[str, Any],
        memory: Mapping[str, Array],
    ) -> None:
        self.mass_kg, self.held, self.step_s = mass_kg, held, step_s
        self.memory = {
            "position_m": np.zeros(vectors),
            "velocity_m_per_s": np.zeros(vectors),
            "internal_N": np.zeros(vectors),
            "lost_J": np.zeros(1),
            **memory,
        }
        ratio, time_s = check_branches(branches)
        self.kernel = compiled(
            **constants, held=held.astype(np.int32), ratio=ratio, time_s=time_s, **self.memory
        )

    @property
    def position_m(self) -> Array:
        """Return the positions (nodes, 3)."""
        return self.by_nodes(self.memory["position_m"])

    @property
    def velocity_m_per_s(self) -> Array:
        """Return the velocities (nodes, 3)."""
        return self.by_nodes(self.memory["velocity_m_per_s"])

    @property
    def internal_N(self) -> Array:
        """Return the internal forces (nodes, 3)."""
        return self.by_nodes(self.memory["internal_N"])

    def by_nodes(self, vectors: Array) -> Array:
        """Return (nodes, 3) vectors that stand in ``memory``."""
        return vectors

    def rest(self, position_m: Array) -> None:
        """Take ``position_m`` (nodes, 3) as the shape at rest, with relaxed branches."""
        self.memory["position_m"][:] = position_m
        self.kernel.rest()

    def move(self, path: HermitePath, outside_N: Array, interval: Interval) -> HeldForce:
        """Go on to the interval's end in equal steps under ``outside_N``, constant."""
        impulse_N_s = np.zeros((len(self.held), 3))
        work_J = self.kernel.advance(
            start_m=path.start.position_m,
            start_m_per_s=path.start.velocity_m_per_s,
            end_m=path.end.position_m,
            end_m_per_s=path.end.velocity_m_per_s,
            outside_N=outside_N,
            length_s=path.length_s,
            steps=interval.steps(self.step_s),
            impulse_N_s=impulse_N_s,
        )
        return HeldForce(impulse_N_s, work_J)

    def lost_J(self) -> float:
        """Return the energy that the Maxwell branches have dissipated since the start."""
        return float(self.memory["lost_J"][0])

    def save(self) -> Saved:
        return {name: array.copy() for name, array in self.memory.items()}

    def restore(self, saved: Saved) -> None:
        """Restore into the arrays that are there: compiled code works on them."""
        for name, array in self.memory.items():
            array[:] = saved[name]

    def close(self) -> None:
        """Do nothing, since nothing is open."""
