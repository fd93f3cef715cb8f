"""The tangent stiffness of a structure as a sparse matrix, and linear solves with it.

Held nodes are taken out: their rows and columns are those of the unit matrix.  For solves, so are those of
components that do not move at rest, along y where sides are joined.  Frequencies are those of free sides;
none of joined sides is higher.
"""

from __future__ import annotations

import dolfinx.fem.petsc as fem_petsc
import numpy as np
import numpy.typing as npt
from dolfinx import fem
from petsc4py import PETSc
from scipy.sparse import bsr_matrix, csr_matrix, diags
from scipy.sparse.linalg import eigsh

from adapters.panel.finite_element.bending import Bending
from adapters.panel.finite_element.compiled import form
from adapters.panel.finite_element.structure import Structure
from orchestrator.ports import Array, Saved

# Above, MUMPS factorises up to 2.5 times faster; below, PETSc's own LU solves twice as fast.
MANY_NODES = 1500


def _in_three_directions(scalar: csr_matrix) -> csr_matrix:
    """Return the matrix with a dense 3 x 3 block per entry, which has room for the material's tangent."""
    blocks = scalar.data[:, None, None] * np.eye(3)
    size = 3 * scalar.shape[0]
    return bsr_matrix((blocks, scalar.indices, scalar.indptr), shape=(size, size)).tocsr()


class Tangent:
    """Stiffness at the positions now in the structure's field, within the step begun last."""

    def __init__(self, structure: Structure) -> None:
        self._structure = structure
        space = structure.space
        held = structure.held.astype(np.int32)
        self._form = form(structure.tangent)
        self._bcs = [fem.dirichletbc(fem.Function(space), held)]
        self._matrix = fem_petsc.create_matrix(self._form)
        self._guided = (3 * structure.joined.ravel() + 1).astype(np.int32)
        self._constant = None
        if structure.bending:
            self._constant = self._bending_matrix(structure.bending, held)
            wide = self._constant.duplicate(copy=False)
            wide.setLGMap(*self._matrix.getLGMap())
            self._matrix.destroy()
            self._matrix = wide
        self._matrix.setOption(PETSc.Mat.Option.KEEP_NONZERO_PATTERN, True)
        self._solver = PETSc.KSP().create(PETSc.COMM_SELF)
        self._solver.setType("preonly")
        factors = self._solver.getPC()
        factors.setType("lu")
        if len(structure.mass_kg) > MANY_NODES:
            factors.setFactorSolverType("mumps")
        else:
            factors.setFactorOrdering("rcm")
        self._right, self._left = self._matrix.createVecs()

    def _bending_matrix(self, bending: Bending, held: npt.NDArray[np.int32]) -> PETSc.Mat:
        kept = np.ones(bending.matrix.shape[0])
        kept[held] = 0.0
        masked = bending.matrix.copy()
        masked.data *= np.repeat(kept, np.diff(masked.indptr)) * kept[masked.indices]
        full = _in_three_directions(masked)
        return PETSc.Mat().createAIJ(
            full.shape, csr=(full.indptr, full.indices, full.data), bsize=3, comm=PETSc.COMM_SELF
        )

    def factorise(self, mass_factor_1_s2: float, stiffness_factor: float) -> None:
        """Form and factorise  mass_factor M + stiffness_factor K."""
        self.assemble(mass_factor_1_s2, stiffness_factor)
        if len(self._guided):
            self._matrix.zeroRowsColumns(self._guided, 1.0)
        self._solver.setOperators(self._matrix)
        self._solver.setUp()

    def assemble(self, mass_factor_1_s2: float, stiffness_factor: float) -> None:
        """Form  mass_factor M + stiffness_factor K."""
        matrix, structure = self._matrix, self._structure
        matrix.zeroEntries()
        fem_petsc.assemble_matrix(matrix, self._form, bcs=self._bcs)
        matrix.assemble()
        if structure.bending:
            share = 1.0 + structure.bending.branches.share
            matrix.axpy(share, self._constant, PETSc.Mat.Structure.SAME_NONZERO_PATTERN)
        matrix.scale(stiffness_factor)
        matrix.getDiagonal(self._left)
        self._left.array[:] += mass_factor_1_s2 * np.repeat(structure.mass_kg, 3)
        matrix.setDiagonal(self._left)
        matrix.assemble()

    def solve(self, force_N: Array) -> Array:
        """Return the displacement (nodes, 3) under ``force_N`` (nodes, 3), zero where none moves at rest."""
        self._right.array[:] = force_N.reshape(-1)
        self._right.array.reshape(-1, 3)[self._structure.fixed] = 0.0
        self._solver.solve(self._right, self._left)
        moved: Array = self._left.array.reshape(-1, 3).copy()
        return moved

    def highest_frequency_rad_per_s(self) -> float:
        """Return the highest angular frequency of small free vibrations about the present positions (Lanczos
        iteration on the stiffness scaled with the diagonal mass)."""
        self.assemble(0.0, 1.0)
        starts, columns, values = self._matrix.getValuesCSR()
        scale = np.zeros((len(self._structure.mass_kg), 3))
        free = self._structure.free
        scale[free] = self._structure.mass_kg[free, None] ** -0.5
        scaled = diags(scale.ravel()) @ csr_matrix((values, columns, starts)) @ diags(scale.ravel())
        start = np.random.default_rng(0).standard_normal(scaled.shape[0])
        largest = eigsh(scaled, k=1, which="LA", v0=start, tol=1e-3, return_eigenvectors=False)
        return float(np.sqrt(largest[0]))

    def save(self) -> Saved:
        """Save the entries of the matrix factorised last; its pattern is always the same."""
        return {"entries": np.array(self._matrix.getValuesCSR()[2])}

    def restore(self, saved: Saved) -> None:
        starts, columns, _ = self._matrix.getValuesCSR()
        self._matrix.setValuesCSR(starts, columns, saved["entries"])
        self._matrix.assemble()
        self._solver.setOperators(self._matrix)
        self._solver.setUp()

    def close(self) -> None:
        """Give the memory back (20 MB for 833 nodes), which petsc4py does not do by itself."""
        for made in (self._solver, self._matrix, self._constant, self._right, self._left):
            if made is not None:
                made.destroy()
