"""The sheet's explicit integration, compiled: one call per sync interval (``kernel/``).

DOLFINx remains the author: mass, bending matrix, openings and resting shape are its own; the
compiled loop adds the membrane's force on the same cells and Gauss points.  Scheme and books are
those of ``explicit`` on a ``Structure``, which tests compare it with.  docs/theory/panel_sheet.md
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.sparse import csr_matrix

from adapters.panel.common.compiled_body import CompiledBody, kernel
from adapters.panel.common.compiled_panel import CompiledPanel
from adapters.panel.common.grid import ElementGrid
from adapters.panel.finite_element.branch_strain import SHEET_ENTRIES
from adapters.panel.finite_element.dolfinx_versions import cell_corners
from adapters.panel.finite_element.elastic_panel import ElasticPanel
from adapters.panel.finite_element.sheet_forms import membrane_shares, openings
from adapters.panel.finite_element.structure import Structure
from orchestrator.ports import Array, Indices
from orchestrator.ports.clock import Interval
from orchestrator.ports.plans import PanelPlan


class CompiledSheet(CompiledBody):
    """A sheet at rest at ``resting_m``, of nodes that are numbered as those of its grid.

    ``structure`` says what it is made of, and ``nodes`` which of its nodes stands at each of the
    grid's.  ``memory`` holds, beside its motion: the scaled strain at the Gauss points, in groups of
    cells side by side; the elastic bending force; the stresses of both parts' branches, each over
    its ratio; their energies (2, branches); the energy lost (1,) and received from the load and from
    the clamps (2,).  Vectors of nodes stand in it by places, (3, places) (``kernel/node_places.h``).
    """

    kernel: kernel.Sheet
    surface = slice(None)

    def __init__(
        self,
        plan: PanelPlan,
        grid: ElementGrid,
        structure: Structure,
        nodes: Indices,
        resting_m: Array,
        step_s: float,
    ) -> None:
        bending, branches = structure.bending, len(plan.material.branches)
        assert bending is not None  # every sheet bends
        self._places, all_places, points = kernel.sheet_places(*grid.shape)
        vectors = (3, all_places)
        self._flat_m = bending.flat_m[nodes]
        mass_kg = structure.mass_kg[nodes]
        structure.rest(resting_m)
        constants = {
            **_cells(plan, structure, grid),
            **_entries(bending.matrix[nodes][:, nodes]),
            "flat_m": self._flat_m,
            "mobility_1_kg": structure.mobility_1_kg[nodes, 0],
            "mass_kg": mass_kg,
            "weight_N": mass_kg[:, None] * plan.gravity_m_per_s2,
        }
        memory = {
            "strain": np.zeros((*points[:2], 3, points[2])),
            "strain_stress": np.zeros((*points[:2], branches, 3, points[2])),
            "elastic_N": np.zeros(vectors),
            "bending_stress_N": np.zeros((branches, *vectors)),
            "energy_J": np.zeros((2, branches)),
            "received_J": np.zeros(2),
        }
        held = np.flatnonzero(np.isin(nodes, structure.held))
        of_node = np.empty(len(nodes), dtype=np.int32)
        of_node[nodes] = np.arange(len(nodes))
        constants["joined"] = of_node[structure.joined].ravel()
        damping = plan.material.branches
        super().__init__(kernel.Sheet, step_s, vectors, mass_kg, held, damping, constants, memory)
        self.rest(resting_m[nodes])

    def by_nodes(self, vectors: Array) -> Array:
        return np.ascontiguousarray(vectors[:, self._places].T)

    def rest(self, position_m: Array) -> None:
        self.memory["position_m"][:, self._places] = position_m.T
        self.kernel.rest()

    def stored_J(self) -> dict[str, float]:
        """Return the elastic energy by name and that of the Maxwell branches."""
        bent_m = self.position_m - self._flat_m
        return {
            "membrane": self.kernel.membrane_J(),
            "bending": 0.5 * float(np.vdot(bent_m, self.by_nodes(self.memory["elastic_N"]))),
            "maxwell": float(self.memory["energy_J"].sum()),
        }


class SheetPanel(CompiledPanel, ElasticPanel):
    """A ``MeshedPanel`` around a compiled sheet."""

    _body: CompiledSheet

    def _check(self, interval: Interval, found: float) -> None:
        """Check the largest speed of a node in m/s."""
        self._check_speed(interval, found)


def open_sheet(
    plan: PanelPlan, grid: ElementGrid, structure: Structure, nodes: Indices, resting_m: Array, step_s: float
) -> CompiledSheet:
    """Make the compiled sheet, and close ``structure``, which it does not need any more."""
    sheet = CompiledSheet(plan, grid, structure, nodes, resting_m, step_s)
    structure.close()
    return sheet


def _cells(plan: PanelPlan, structure: Structure, grid: ElementGrid) -> dict[str, Any]:
    """Return the membrane's law on each cell of ``grid``, y running fastest."""
    flat = structure.space.mesh
    holes = openings(plan, flat)
    solid, rest = membrane_shares(plan, flat, holes)
    cells = _cell_numbers(grid, flat.geometry.x[cell_corners(flat)].mean(axis=1))
    strain = structure.viscous.entries if structure.viscous else np.tile(SHEET_ENTRIES, (len(solid), 1))
    return {
        "along_m": np.diff(grid.s_m),
        "across_m": np.diff(grid.y_m),
        "c10_N_per_m": plan.material.c10_Pa * plan.thickness_m,
        "c01_N_per_m": plan.material.c01_Pa * plan.thickness_m,
        "solid": solid[cells],
        "rest": np.ascontiguousarray(rest[cells if holes else []][:, [0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]),
        "strain_entries": strain[cells],
    }


def _cell_numbers(grid: ElementGrid, middle_m: Array) -> Indices:
    """Return for each cell of ``grid``, (cells,), the number of the point of ``middle_m`` that is in it."""
    row = np.searchsorted(grid.s_m, middle_m[:, 0]) - 1
    column = np.searchsorted(grid.y_m, middle_m[:, 1]) - 1
    return np.argsort(row * grid.shape[1] + column)


def _entries(matrix: csr_matrix) -> dict[str, Any]:
    """Return the matrix's entries by ``row`` and ``column``."""
    entries = matrix.tocoo()
    return {"row": entries.row, "column": entries.col, "entry": entries.data}
