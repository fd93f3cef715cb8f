"""Force, stiffness and energy of a hyperelastic material with Maxwell branches, by DOLFINx."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import ufl
from basix import make_quadrature  # type: ignore[attr-defined]
from basix.cell import string_to_type
from dolfinx import fem

from adapters.panel.common.compiled import expression, form, function_space
from adapters.panel.common.maxwell import Branches
from orchestrator.ports import Array, Saved
from orchestrator.ports.state import restore_attributes, save_attributes


@dataclass(frozen=True)
class Law:
    """A material law in UFL on the field ``position`` (world position of each material point).

    ``energy`` names integrals of stored energy in J.  The Maxwell branches act on ``strain``, a
    vector scaled such that  g/2 |overstrain|^2  is their energy per unit of the mesh's measure;
    ``degree`` is the quadrature degree of that integral.
    """

    position: Any
    energy: Mapping[str, Any]
    strain: Any
    degree: int
    branches: tuple[tuple[float, float], ...]


class ViscousStrain:
    """Maxwell branches at the quadrature points of a law's strain (a ``Memory``)."""

    def __init__(self, law: Law) -> None:
        mesh = law.position.function_space.mesh
        cell = mesh.ufl_cell()
        size = law.strain.ufl_shape[0]
        points = ufl.VectorElement("Quadrature", cell, degree=law.degree, quad_scheme="default", dim=size)
        self._measure = ufl.dx(metadata={"quadrature_degree": law.degree, "quadrature_rule": "default"})
        self._strain = law.strain
        self._history = fem.Function(function_space(mesh, points))
        self._share = fem.Constant(mesh, 0.0)
        reference, weights = make_quadrature(string_to_type(cell.cellname()), law.degree)
        self._evaluate = expression(law.strain, reference)
        self._cells = np.arange(mesh.topology.index_map(mesh.topology.dim).size_local, dtype=np.int32)
        volume = expression(abs(ufl.JacobianDeterminant(mesh)), reference).eval(self._cells)
        self._weight = np.repeat((volume * weights).reshape(-1), size)
        self._now = np.zeros((len(self._cells), len(weights) * size))
        self._before = np.zeros(len(self._weight))
        self._change = np.zeros(len(self._weight))
        self.branches = Branches(law.branches, len(self._weight))

    def virtual_work(self, position: Any, test: Any) -> Any:
        """Work of the overstress that follows the trial positions of a step's end."""
        overstress = self._history + self._share * self._strain
        return ufl.inner(overstress, ufl.derivative(self._strain, position, test)) * self._measure

    def rest(self, position_m: Array) -> None:
        """Take ``position_m``, which must stand in the field, as relaxed."""
        self._before[:] = self._evaluate.eval(self._cells, self._now).reshape(-1)

    def begin_step(self, step_s: float) -> None:
        self.branches.begin(step_s, self._before)
        self._history.x.array[:] = self.branches.history
        self._share.value = self.branches.share

    def end_step(self, position_m: Array) -> None:
        """Accept ``position_m``, which must stand in the field."""
        now = self._evaluate.eval(self._cells, self._now).reshape(-1)
        np.subtract(now, self._before, out=self._change)
        self._before[:] = now
        self.branches.end(self._change * self._weight, self._change)

    def save(self) -> Saved:
        return save_attributes(self, "_before") | {"branches": self.branches.save()}

    def restore(self, saved: Saved) -> None:
        restore_attributes(self, saved, "_before")
        self.branches.restore(saved["branches"])


class Material:
    """A law's force and stiffness at the positions now in its field."""

    def __init__(self, law: Law) -> None:
        space = law.position.function_space
        test, trial = ufl.TestFunction(space), ufl.TrialFunction(space)
        work = ufl.derivative(sum(law.energy.values()), law.position, test)
        self.viscous = ViscousStrain(law) if law.branches else None
        if self.viscous:
            work += self.viscous.virtual_work(law.position, test)
        self._energy = {name: form(energy) for name, energy in law.energy.items()}
        self._force = form(work)
        self.tangent = ufl.derivative(work, law.position, trial)

    def add_force(self, force_N: Array) -> None:
        """Add the internal force to ``force_N`` (nodes, 3)."""
        fem.assemble_vector(force_N.reshape(-1), self._force)

    def stored_J(self) -> dict[str, float]:
        return {name: float(fem.assemble_scalar(energy)) for name, energy in self._energy.items()}
