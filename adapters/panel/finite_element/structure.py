"""A deformable body on a finite-element mesh, as the time integrators see it."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
import ufl
from dolfinx import fem

from adapters.panel.common.compiled import form
from adapters.panel.common.maxwell import Branches
from adapters.panel.finite_element.bending import Bending
from adapters.panel.finite_element.material import Law, Material
from orchestrator.ports import Array, Indices, Restorable, Saved
from orchestrator.ports.state import save_attributes


def lumped_mass_kg(space: Any, mass_per_measure: Any) -> Array:
    """(nodes,): the integral of each shape function.  For quadratic cells on a rectangular grid
    this is the mass collocated at the Gauss-Lobatto points: positive.  ``mass_per_measure`` is a
    number, or a UFL expression that is constant in each cell."""
    ones = ufl.as_vector([1.0, 1.0, 1.0])
    integral = mass_per_measure * ufl.inner(ones, ufl.TestFunction(space)) * ufl.dx
    mass: Array = fem.assemble_vector(form(integral)).array[::3].copy()
    return mass


class Memory(Restorable, Protocol):
    """A part whose force depends on its past."""

    branches: Branches

    def rest(self, position_m: Array) -> None: ...

    def begin_step(self, step_s: float) -> None: ...

    def end_step(self, position_m: Array) -> None: ...


class Structure:
    """Lumped mass, internal force and energy of a body; ``held`` are the prescribed nodes.

    Arrays of positions and forces have shape (nodes, 3).  A step is ``begin_step``, then any
    number of ``force_N`` at trial positions of its end, then ``end_step``, which accepts the
    positions given to ``force_N`` last.
    """

    def __init__(
        self, law: Law, mass_per_measure: Any, held: Indices, bending: Bending | None = None
    ) -> None:
        self.space = law.position.function_space
        self.material_m: Array = self.space.tabulate_dof_coordinates()  # s, y, height
        self.mass_kg = lumped_mass_kg(self.space, mass_per_measure)
        self.held = held
        self.free = np.setdiff1d(np.arange(len(self.mass_kg)), held)
        self.mobility_1_kg = np.zeros((len(self.mass_kg), 1))  # zero where held
        self.mobility_1_kg[self.free, 0] = 1.0 / self.mass_kg[self.free]
        self.material = Material(law)
        self.bending = bending
        self._memories: list[Memory] = [part for part in (self.material.viscous, bending) if part is not None]
        self._position_m = law.position.x.array.reshape(-1, 3)  # a view into the field

    def rest(self, position_m: Array) -> None:
        """Take ``position_m`` as the shape in which every Maxwell branch is relaxed."""
        self._position_m[:] = position_m
        for memory in self._memories:
            memory.rest(position_m)

    def begin_step(self, step_s: float) -> None:
        for memory in self._memories:
            memory.begin_step(step_s)

    def force_N(self, position_m: Array) -> Array:
        """Internal force at trial positions: the force that the body needs to stay there."""
        self._position_m[:] = position_m
        force = np.zeros_like(position_m)
        self.material.add_force(force)
        if self.bending:
            self.bending.add_force(position_m, force)
        return force

    def end_step(self) -> None:
        for memory in self._memories:
            memory.end_step(self._position_m)

    def save(self) -> Saved:
        parts = {str(number): memory.save() for number, memory in enumerate(self._memories)}
        return save_attributes(self, "_position_m") | parts

    def restore(self, saved: Saved) -> None:
        self._position_m[:] = saved["position_m"]
        for number, memory in enumerate(self._memories):
            memory.restore(saved[str(number)])

    def close(self) -> None:
        if self.bending:
            self.bending.close()

    def stored_J(self) -> dict[str, float]:
        """Elastic energy by name and that of the Maxwell branches."""
        stored = self.material.stored_J()
        if self.bending:
            stored["bending"] = self.bending.stored_J()
        branches = (float(memory.branches.energy_J.sum()) for memory in self._memories)
        return stored | {"maxwell": sum(branches)}

    def lost_J(self) -> float:
        """What the Maxwell branches dissipated since the start."""
        return sum(memory.branches.lost_J for memory in self._memories)
