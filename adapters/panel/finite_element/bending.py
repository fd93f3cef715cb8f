"""Bending of a thin sheet with a flat reference: a constant matrix, alike for x, y and z.

The energy is quadratic in the second derivatives of the position, so it is zero for every rigid
motion and every uniform stretch, and equals the plate's energy for motions without strain.  On C0
elements the normal slope may jump across cell borders: the jump is penalised and made consistent
by the C0 interior penalty method (Engel et al., Comput. Methods Appl. Mech. Engrg. 191 (2002)
3669-3750, doi:10.1016/S0045-7825(02)00286-4).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import ufl
from petsc4py import PETSc
from scipy.sparse import csr_matrix, diags

from adapters.panel.common.maxwell import Branches
from adapters.panel.finite_element.compiled import assembled_matrix
from orchestrator.ports import Array
from orchestrator.ports.state import SavedAttributes

# 3 is the least with which the matrix has no negative eigenvalue (docs/theory/panel_sheet.md).
PENALTY = 4.0


Moment = Callable[[Any], Any]  # of a curvature, both 2 x 2 and symmetric


def plate(stiffness_N_per_m: float, poisson_ratio: float) -> Moment:
    """Return the moment law of an isotropic plate of stiffness D = ``stiffness_N_per_m`` (in N m)."""

    def moment(k: Any) -> Any:
        return stiffness_N_per_m * ((1 - poisson_ratio) * k + poisson_ratio * ufl.tr(k) * ufl.Identity(2))

    return moment


def _bilinear_form(trial: Any, test: Any, law: Moment) -> Any:
    """Return the C0 interior penalty form of a plate's bending for one component of the position."""
    mesh = trial.ufl_function_space().ufl_domain()
    normal = ufl.FacetNormal(mesh)

    def curvature(w: Any) -> Any:
        return ufl.grad(ufl.grad(w))

    def moment(w: Any, side: str) -> Any:
        n = normal(side)
        return ufl.dot(n, ufl.dot(law(curvature(w))(side), n))

    def mean_moment(w: Any) -> Any:
        return 0.5 * (moment(w, "+") + moment(w, "-"))

    def slope_jump(w: Any) -> Any:
        return ufl.jump(ufl.grad(w), normal)

    across = ufl.dot(ufl.transpose(ufl.Jacobian(mesh)), normal)
    cell_m = ufl.sqrt(ufl.dot(across, across))
    stiff_N_per_m = ufl.dot(normal, ufl.dot(law(ufl.outer(normal, normal)), normal))
    cells = ufl.inner(law(curvature(trial)), curvature(test))
    facets = (
        PENALTY * ufl.avg(stiff_N_per_m / cell_m) * slope_jump(trial) * slope_jump(test)
        - mean_moment(trial) * slope_jump(test)
        - mean_moment(test) * slope_jump(trial)
    )
    return cells * ufl.dx + facets * ufl.dS


def moulded_energy(position: Any, law: Moment, curvature_1_m: Any, across: Any) -> Any:
    """Return the energy that a stress-free curvature (2 x 2) along the sheet adds to that of bending.

    Half the square of the stress-free curvature by the moment law, less the work of its moments on the
    curvature about ``across``, a fixed unit vector; the sheet's normal is the product of its slope along s
    and ``across``.  Slopes that jump between cells count as in the sheet's own bending.
    """
    mesh = position.ufl_function_space().ufl_domain()
    facet = ufl.FacetNormal(mesh)
    gradient = ufl.grad(position)  # (3, 2)
    normal = ufl.cross(gradient[:, 0], across)
    second = ufl.grad(gradient)  # (3, 2, 2)
    bent_1_m = ufl.as_matrix([[ufl.dot(second[:, i, j], normal) for j in range(2)] for i in range(2)])
    moment = law(curvature_1_m)

    def across_facet(side: str) -> Any:
        return ufl.dot(facet(side), ufl.dot(moment(side), facet(side)))

    jump = ufl.dot(gradient("+"), facet("+")) + ufl.dot(gradient("-"), facet("-"))
    mean_moment = 0.5 * (across_facet("+") + across_facet("-"))
    cells = ufl.inner(moment, 0.5 * curvature_1_m - bent_1_m)
    facets = mean_moment * ufl.dot(jump, ufl.avg(normal))
    points = {"quadrature_degree": 6}
    return cells * ufl.dx(metadata=points) + facets * ufl.dS(metadata=points)


def stiffness_matrix(scalar_space: Any, law: Moment) -> csr_matrix:
    """Return the matrix (nodes, nodes) in N/m for a plate whose moments, in N, follow ``law``."""
    trial, test = ufl.TrialFunction(scalar_space), ufl.TestFunction(scalar_space)
    return balanced(assembled_matrix(_bilinear_form(trial, test, law)))


def balanced(matrix: csr_matrix) -> csr_matrix:
    """Return a stiffness ``matrix`` (nodes, nodes) without what rounding has left in its sums.

    Forces within a sheet sum to zero, so each column must.  Entries are a million times stiffer than the
    sheet they bend, and what remains of a sum acts always to the same side: of an assembled matrix it was up
    to 2e-9 of the momentum, after rounding that differs from processor to processor.  The matrix returned is
    symmetric, its entries are multiples of a power of two, 9e-16 of the largest, and the diagonal makes all
    sums zero without rounding.
    """
    grain = 2.0 ** (np.ceil(np.log2(np.abs(matrix.data).max())) - 50)
    symmetric = (matrix + matrix.T).tocsr() / 2
    symmetric.data = grain * np.round(symmetric.data / grain)
    return (symmetric - diags(np.asarray(symmetric.sum(axis=1)).ravel())).tocsr()


class Product:
    """The product of a sparse matrix and (nodes, 3) by PETSc, in a third of the time SciPy needs."""

    def __init__(self, matrix: csr_matrix) -> None:
        self._right = np.zeros((matrix.shape[1], 3), order="F")
        self._dense = PETSc.Mat().createDense(self._right.shape, array=self._right, comm=PETSc.COMM_SELF)
        self._sparse = PETSc.Mat().createAIJ(
            matrix.shape, csr=(matrix.indptr, matrix.indices, matrix.data), comm=PETSc.COMM_SELF
        )
        self._result = self._sparse.matMult(self._dense)

    def __call__(self, values: Array) -> Array:
        self._right[:] = values
        self._sparse.matMult(self._dense, result=self._result)
        product: Array = self._result.getDenseArray().copy(order="C")
        return product

    def close(self) -> None:
        """Give the memory back, which petsc4py does not do by itself."""
        for made in (self._result, self._sparse, self._dense):
            made.destroy()


class Bending(SavedAttributes):
    """The force and energy of a constant stiffness matrix with Maxwell branches of its own.

    ``flat_m`` (nodes, 3) are positions without bending: the matrix acts on the difference from them, which
    keeps its rounding errors, and with them those of momentum, small. The branches act on the nodal
    displacement, so their overstress does not turn with the sheet: good while rotations within a relaxation
    time are small.
    """

    STATE = ("_position_m", "_elastic_N")
    PARTS = ("branches",)

    def __init__(self, matrix: csr_matrix, flat_m: Array, branches: tuple[tuple[float, float], ...]) -> None:
        self.matrix = matrix
        self._multiply = Product(matrix)
        self.flat_m = flat_m
        nodes = matrix.shape[0]
        self.branches = Branches(branches, 3 * nodes)
        self._position_m = np.zeros((nodes, 3))
        self._elastic_N = np.zeros((nodes, 3))
        self._trial_N = np.zeros((nodes, 3))

    def rest(self, position_m: Array) -> None:
        """Take ``position_m`` (nodes, 3) as relaxed."""
        self._position_m[:] = position_m
        self._elastic_N[:] = self._multiply(position_m - self.flat_m)

    def begin_step(self, step_s: float) -> None:
        self.branches.begin(step_s, self._elastic_N.reshape(-1))

    def add_force(self, position_m: Array, force_N: Array) -> None:
        self._trial_N = self._multiply(position_m - self.flat_m)
        force_N += (1.0 + self.branches.share) * self._trial_N
        force_N += self.branches.history.reshape(-1, 3)

    def end_step(self, position_m: Array) -> None:
        """Accept ``position_m``, for which ``add_force`` was called last."""
        self.branches.end(
            (position_m - self._position_m).reshape(-1), (self._trial_N - self._elastic_N).reshape(-1)
        )
        self._position_m[:] = position_m
        self._elastic_N[:] = self._trial_N

    def close(self) -> None:
        self._multiply.close()

    def stored_J(self) -> float:
        return 0.5 * float(np.vdot(self._position_m - self.flat_m, self._elastic_N))
