"""How the masses behind a surface yield to a constant load, while the particles answer."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.sparse import csr_array
from scipy.sparse.linalg import LinearOperator, cg

from orchestrator.ports import Array, Inertia, Load, Panel, Response
from orchestrator.ports.inertia import inertia_of

SOLVED = 1e-4  # of the excess load: less than what the contacts' linear answer is worth
MOST_ITERATIONS = 200
LEAST_SHARE = 1e-3


@dataclass(frozen=True)
class Yielding:
    """``transposed``: the inertia's shapes; ``spread``: the sizes of their entries, each times its
    row's sum, transposed; ``known`` (points,): whether anything is known of a point's mass."""

    inertia: Inertia
    transposed: csr_array
    spread: csr_array
    known: npt.NDArray[np.bool_]

    @staticmethod
    def of(panel: Panel) -> Yielding:
        inertia = inertia_of(panel)
        shapes, sizes = inertia.shapes, abs(inertia.shapes)
        spread = sizes.multiply(np.asarray(sizes.sum(axis=1))[:, None])
        known = np.diff(shapes.indptr) > 0
        return Yielding(inertia, csr_array(shapes.T), csr_array(spread.T), known)

    def to(self, excess_N: Array, response: Response, length_s: float, share: Array) -> Array:
        """Mean velocity (points, 3) by which the points give way to ``excess_N`` (points, 3) over
        an interval: shapes u, where the masses' velocity u solves

            (2 M / (s H) + shapes' Z shapes) u = shapes' excess,

        by conjugate gradients.  Their preconditioner has each Z spread over the masses under it,
        which is never less than the matrix."""
        shapes, wanted = self.inertia.shapes, self._on_masses(excess_N)
        free = 2 / length_s * self.inertia.mass_kg[:, None] / share
        impedance = np.einsum("pii->p", response.impedance_N_s_per_m)
        lumped = free + (self.spread @ impedance)[:, None]
        touched = np.flatnonzero(impedance)
        Z, under = response.impedance_N_s_per_m[touched], shapes[touched]
        onto = csr_array(under.T)

        def product(u: Array) -> Array:
            u = u.reshape(wanted.shape)
            resisting_N = (Z @ (under @ u)[:, :, None])[:, :, 0]
            return np.ravel(free * u + self.inertia.yielding(onto @ resisting_N))

        square = (wanted.size, wanted.size)
        u, _ = cg(
            LinearOperator(square, matvec=product, dtype=float),
            np.ravel(wanted),
            tol=SOLVED,
            atol=0.0,
            maxiter=MOST_ITERATIONS,
            M=LinearOperator(square, matvec=lambda r: r / np.ravel(lumped), dtype=float),
        )
        return np.asarray(shapes @ u.reshape(wanted.shape))

    def share(self, more: Load, gave_m_per_s: Array, length_s: float, before: Array) -> Array:
        """Of what free masses would have done (3,), by direction: the work of the load ``more`` on
        the mean velocity ``gave_m_per_s`` (points, 3) that it really caused.  1 for a free mass, less
        where the panel's stiffness holds it; ``before`` where nothing changed."""
        on_masses_N = self._on_masses(more.force_N)
        free = length_s / 2 * (on_masses_N**2 / self.inertia.mass_kg[:, None]).sum(axis=0)
        found = before.copy()
        real = (more.force_N * gave_m_per_s)[self.known].sum(axis=0)
        np.divide(real, free, out=found, where=free > 0)
        return np.clip(found, LEAST_SHARE, 1.0)

    def _on_masses(self, points_N: Array) -> Array:
        """What the masses yield to."""
        return self.inertia.yielding(self.transposed @ points_N)


def against(response: Response, velocity_m_per_s: Array) -> Array:
    """(points, 3): by how much less the particles push a surface that moves."""
    return np.asarray(np.einsum("pij,pj->pi", response.impedance_N_s_per_m, velocity_m_per_s))
