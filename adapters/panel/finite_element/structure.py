"""A deformable body on a finite-element mesh for the time integrators: mass, a hyperelastic material with
Maxwell branches, and bending."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import ufl
from basix import CellType, make_quadrature
from dolfinx import fem

from adapters.panel.common.maxwell import Branches
from adapters.panel.finite_element.bending import Bending
from adapters.panel.finite_element.compiled import expression, form, function_space
from orchestrator.ports import Array, Indices, Saved
from orchestrator.ports.state import SavedAttributes, save_attributes


def lumped_mass_kg(space: Any, mass_per_measure: Any) -> Array:
    """Return the integral of each shape function, (nodes,).

    For quadratic cells on a rectangular grid this is the mass collocated at the Gauss-Lobatto points, which
    is positive.  ``mass_per_measure`` is a number, or a UFL expression that is constant in each cell.
    """
    ones = ufl.as_vector([1.0, 1.0, 1.0])
    integral = mass_per_measure * ufl.inner(ones, ufl.TestFunction(space)) * ufl.dx
    mass: Array = fem.assemble_vector(form(integral)).array[::3].copy()
    return mass


def cell_constants(mesh: Any, values: int) -> Any:
    """Return a field of ``values`` numbers that are constant in each cell."""
    return fem.Function(function_space(mesh, "DG", 0, values))


@dataclass(frozen=True)
class Law:
    """A material law in UFL on the field ``position`` (world position of each material point).

    ``energy`` names integrals of stored energy in J.  The Maxwell branches act on ``strain``, a
    vector scaled by the field ``entries``, which is constant in each cell, such that  g/2 |overstrain|^2  is
    their energy per unit of the mesh's measure; ``degree`` is the quadrature degree of that integral.  With
    the entries ``unscaled``, it is the strain itself, from whose means in each cell at rest (cells, size)
    ``scale`` makes the entries.
    """

    position: Any
    energy: Mapping[str, Any]
    strain: Any
    entries: Any
    unscaled: Array
    scale: Callable[[Array], Array]
    degree: int
    branches: tuple[tuple[float, float], ...]


class ViscousStrain(SavedAttributes):
    """Maxwell branches at the quadrature points of a law's strain, whose past decides their force."""

    STATE = ("_before",)
    PARTS = ("branches",)

    def __init__(self, law: Law) -> None:
        mesh = law.position.function_space.mesh
        size = law.strain.ufl_shape[0]
        self._measure = ufl.dx(metadata={"quadrature_degree": law.degree, "quadrature_rule": "default"})
        self._strain, self._law = law.strain, law
        self._history = fem.Function(function_space(mesh, "Quadrature", law.degree, size))
        self._share = fem.Constant(mesh, 0.0)
        reference, weights = make_quadrature(getattr(CellType, mesh.ufl_cell().cellname()), law.degree)
        self._evaluate = expression(law.strain, reference, mesh)
        self._cells = np.arange(mesh.topology.index_map(mesh.topology.dim).size_local, dtype=np.int32)
        volume = expression(abs(ufl.JacobianDeterminant(mesh)), reference, mesh)(self._cells)
        self._weight = np.repeat((volume * weights).reshape(-1), size)
        self._now = np.zeros((len(self._cells), len(weights) * size))
        self._before = np.zeros(len(self._weight))
        self._change = np.zeros(len(self._weight))
        self.branches = Branches(law.branches, len(self._weight))

    def virtual_work(self, position: Any, test: Any) -> Any:
        """Return the work of the overstress that follows the trial positions of a step's end."""
        overstress = self._history + self._share * self._strain
        return ufl.inner(overstress, ufl.derivative(self._strain, position, test)) * self._measure

    def rest(self, position_m: Array) -> None:
        """Make ``position_m``, which must stand in the field, the relaxed shape."""
        law, cells = self._law, len(self._cells)
        law.entries.x.array[:] = np.tile(law.unscaled, cells)
        strain = self._evaluate(self._cells, self._now).reshape(cells, -1, law.strain.ufl_shape[0])
        law.entries.x.array[:] = law.scale(strain.mean(axis=1)).ravel()
        self._before[:] = self._evaluate(self._cells, self._now).reshape(-1)

    @property
    def entries(self) -> Array:
        """The entries (cells, n) that scale the strain about the relaxed shape."""
        return np.asarray(self._law.entries.x.array.reshape(len(self._cells), -1))

    def begin_step(self, step_s: float) -> None:
        self.branches.begin(step_s, self._before)
        self._history.x.array[:] = self.branches.history
        self._share.value = self.branches.share

    def end_step(self, position_m: Array) -> None:
        """Accept ``position_m``, which must stand in the field."""
        now = self._evaluate(self._cells, self._now).reshape(-1)
        np.subtract(now, self._before, out=self._change)
        self._before[:] = now
        self.branches.end(self._change * self._weight, self._change)


class Structure:
    """The lumped mass, internal force and energy of a body.

    ``held`` are the prescribed nodes, ``tangent`` is the bilinear form of the material's stiffness at the
    positions now in the law's field.  ``viscous`` is the strain of the Maxwell branches, if there are any.
    ``added_kg`` is the mass that is fixed to the nodes.  ``joined`` are pairs of free nodes (pairs, 2) that
    move alike, opposite each other along y: the sides of a body that goes on beyond them.  At rest, nothing
    moves them along y.

    Arrays of positions and forces have shape (nodes, 3).  A step is ``begin_step``, then any number of
    ``force_N`` at trial positions of its end, then ``end_step``, which accepts the positions given to
    ``force_N`` last.
    """

    def __init__(
        self,
        law: Law,
        mass_per_measure: Any,
        held: Indices,
        bending: Bending | None = None,
        added_kg: Array | float = 0.0,
        joined: Indices | None = None,
    ) -> None:
        self.space = law.position.function_space
        self.material_m: Array = self.space.tabulate_dof_coordinates()  # s, y, height
        self.mass_kg = lumped_mass_kg(self.space, mass_per_measure) + added_kg
        self.held = held
        self.free = np.setdiff1d(np.arange(len(self.mass_kg)), held)
        self.mobility_1_kg = np.zeros((len(self.mass_kg), 1))  # zero where held
        self.mobility_1_kg[self.free, 0] = 1.0 / self.mass_kg[self.free]
        self.joined = np.empty((0, 2), dtype=np.int64) if joined is None else joined
        self.mobility_1_kg[self.joined, 0] = 1.0 / self.mass_kg[self.joined].mean(axis=1, keepdims=True)
        self.fixed = np.zeros((len(self.mass_kg), 3), dtype=bool)  # components of the nodes at rest
        self.fixed[held] = True
        self.fixed[self.joined, 1] = True
        self.bending = bending
        test, trial = ufl.TestFunction(self.space), ufl.TrialFunction(self.space)
        work = ufl.derivative(sum(law.energy.values()), law.position, test)
        self.viscous = ViscousStrain(law) if law.branches else None
        if self.viscous:
            work += self.viscous.virtual_work(law.position, test)
        self._energy = {name: form(energy) for name, energy in law.energy.items()}
        self._force = form(work)
        self.tangent = ufl.derivative(work, law.position, trial)
        self._memories = [part for part in (self.viscous, bending) if part is not None]
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
        """Return the internal force (nodes, 3), which the body needs to stay at trial positions."""
        self._position_m[:] = position_m
        force = np.zeros_like(position_m)
        fem.assemble_vector(force.reshape(-1), self._force)
        if self.bending:
            self.bending.add_force(position_m, force)
        return force

    def join(self, force_N: Array) -> Array:
        """Return forces (nodes, 3) of which nodes that move alike have equal shares."""
        if len(self.joined):
            force_N[self.joined] = force_N[self.joined].mean(axis=1, keepdims=True)
        return force_N

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
        """Return the stored energies in J by name: the elastic energies and the Maxwell branches' energy."""
        stored = {name: float(fem.assemble_scalar(energy)) for name, energy in self._energy.items()}
        if self.bending:
            stored["bending"] = self.bending.stored_J()
        branches = (float(memory.branches.energy_J.sum()) for memory in self._memories)
        return stored | {"maxwell": sum(branches)}

    def lost_J(self) -> float:
        """Return the energy that the Maxwell branches dissipated since the start."""
        return sum(memory.branches.lost_J for memory in self._memories)
