"""The sheet's explicit integration, compiled: one call per sync interval (``kernel/``).

DOLFINx remains the author: mass, bending matrix, openings and resting shape are its own; the
compiled loop adds the membrane's force on the same cells and Gauss points.  Scheme and books are
those of ``explicit`` on a ``Structure``, which tests compare it with.  docs/theory/panel_sheet.md
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.sparse import csr_matrix

from adapters.panel._kernel import LANES, Sheet
from adapters.panel.common.body import Action, BodyState, CompiledBody, HeldForce
from adapters.panel.common.maxwell import checked
from adapters.panel.finite_element.elastic_panel import ElasticPanel
from adapters.panel.finite_element.grid import ElementGrid, SurfaceNodes
from adapters.panel.finite_element.sheet_forms import openings, strain_entries
from adapters.panel.finite_element.structure import Structure
from orchestrator.ports import Array, Indices
from orchestrator.ports.clock import Interval
from orchestrator.ports.plans import PanelPlan


def panel(
    plan: PanelPlan, structure: Structure, surface: SurfaceNodes[ElementGrid], resting_m: Array, step_s: float
) -> ElasticPanel:
    """Return the panel of ``plan`` at rest at ``resting_m`` (nodes, 3), in steps of at most ``step_s``.

    Its nodes are numbered as those of the grid.  Closes ``structure``."""
    sheet = CompiledSheet(plan, structure, surface, step_s)
    structure.close()
    sheet.rest(resting_m[surface.nodes])
    return ElasticPanel(plan, sheet, sheet, sheet.state, surface.grid, slice(None))


class CompiledSheet(CompiledBody):
    """Body and integrator in one, at rest nowhere before ``rest``.

    ``state`` and ``memory`` are all that changes.  In ``memory``: the scaled strain at the Gauss
    points, in groups of cells side by side; the elastic bending force; the stresses of both parts'
    branches, each over its ratio; their energies (2, branches); the energy lost (1,).
    """

    def __init__(
        self, plan: PanelPlan, structure: Structure, surface: SurfaceNodes[ElementGrid], step_s: float
    ) -> None:
        nodes, bending = surface.nodes, structure.bending
        assert bending is not None  # every sheet bends
        count, branches = len(nodes), len(plan.material.branches)
        self.mass_kg = structure.mass_kg[nodes]
        self._flat_m, self._step_s = bending.flat_m[nodes], step_s
        self.state = BodyState(*np.zeros((3, count, 3)))
        groups = -(-surface.grid.shape[0] * surface.grid.shape[1] // LANES)
        memory: dict[str, Any] = {
            "strain": np.zeros((groups, 9, 3, LANES)),
            "strain_stress": np.zeros((groups, 9, branches, 3, LANES)),
            "elastic_N": np.zeros((count, 3)),
            "bending_stress_N": np.zeros((branches, count, 3)),
            "energy_J": np.zeros((2, branches)),
            "lost_J": np.zeros(1),
        }
        held = np.flatnonzero(np.isin(nodes, structure.held))
        ratio, time_s = checked(plan.material.branches)
        kernel = Sheet(
            **_cells(plan, structure, surface.grid),
            **_diagonals(bending.matrix[nodes][:, nodes]),
            flat_m=self._flat_m,
            mobility_1_kg=structure.mobility_1_kg[nodes, 0],
            held=held.astype(np.int32),
            ratio=ratio,
            time_s=time_s,
            position_m=self.state.position_m,
            velocity_m_per_s=self.state.velocity_m_per_s,
            internal_N=self.state.internal_N,
            **memory,
        )
        super().__init__(kernel, held, memory)
        self._sheet = kernel

    def rest(self, position_m: Array) -> None:
        """Take ``position_m`` (nodes, 3) as the shape at rest, with relaxed branches."""
        self.state.position_m[:] = position_m
        self._sheet.rest()

    def advance(self, state: BodyState, action: Action, interval: Interval) -> HeldForce:
        """Move ``state``, which must be its own, to the interval's end under ``action``."""
        return self.move(action, interval.steps(self._step_s))

    def stored_J(self) -> dict[str, float]:
        """Return the elastic energy by name and that of the Maxwell branches."""
        bent_m = self.state.position_m - self._flat_m
        return {
            "membrane": self._sheet.membrane_J(),
            "bending": 0.5 * float(np.vdot(bent_m, self.memory["elastic_N"])),
            "maxwell": float(self.memory["energy_J"].sum()),
        }

    def close(self) -> None:
        """Nothing is open."""


def _cells(plan: PanelPlan, structure: Structure, grid: ElementGrid) -> dict[str, Any]:
    """The membrane's law on each cell of ``grid``, y running fastest."""
    flat = structure.space.mesh
    count = grid.shape[0] * grid.shape[1]
    strain = np.tile(strain_entries(plan.material, plan.thickness_m), (count, 1))
    solid, rest = np.ones(count), np.empty((0, 6))
    holes = openings(plan, flat)
    if holes:
        stiffness_N_per_m = plan.material.youngs_modulus_Pa * plan.thickness_m
        cells = _cell_numbers(grid, holes.share.function_space.tabulate_dof_coordinates())
        share = holes.share.x.array[cells]
        factor, stiffer = holes.split(stiffness_N_per_m)
        solid = 1.0 - (1.0 - factor) * share
        rest = np.outer(share, stiffer[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]])
        strain = holes.strain_entries(stiffness_N_per_m)[cells]
    return {
        "along_m": np.diff(grid.s_m),
        "across_m": np.diff(grid.y_m),
        "c10_N_per_m": plan.material.c10_Pa * plan.thickness_m,
        "c01_N_per_m": plan.material.c01_Pa * plan.thickness_m,
        "solid": solid,
        "rest": rest,
        "strain_entries": strain,
    }


def _cell_numbers(grid: ElementGrid, middle_m: Array) -> Indices:
    """(cells,): for each cell of ``grid``, which of the points ``middle_m`` is in it."""
    row = np.searchsorted(grid.s_m, middle_m[:, 0]) - 1
    column = np.searchsorted(grid.y_m, middle_m[:, 1]) - 1
    return np.argsort(row * grid.shape[1] + column)


def _diagonals(matrix: csr_matrix) -> dict[str, Any]:
    """``entry`` (offsets, nodes): what stands in each row, ``offset`` columns off the diagonal."""
    entries = matrix.tocoo()
    offset, which = np.unique(entries.col - entries.row, return_inverse=True)
    entry = np.zeros((len(offset), matrix.shape[0]))
    entry[which, entries.row] = entries.data
    return {"offset": offset.astype(np.int32), "entry": entry}
