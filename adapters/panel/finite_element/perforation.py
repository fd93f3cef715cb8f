"""The sheet where it has openings, softer and lighter according to the cell of the pattern.

A field ``share`` says which part of each finite-element cell is perforated (0 ... 1; the cells' borders
follow the perforated region wherever it is at least half a cell from the panel's edge). Equations and
measurements: docs/theory/perforated_panel.md.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import ufl
from dolfinx import fem
from scipy.linalg import eigh

from adapters.panel.finite_element.compiled import function_space
from adapters.panel.finite_element.dolfinx_versions import cell_corners
from adapters.panel.finite_element.unit_cell import SOLID, CellStiffness, cell_stiffness
from orchestrator.ports import Array
from orchestrator.ports.geometry import AperturePattern
from orchestrator.ports.plans import PanelPlan


@dataclass(frozen=True)
class Perforated:
    """The pattern's stiffness and solid share, and its place: ``share`` on a mesh's cells.

    Values of the pattern are constants, not numbers, of the forms: other patterns need no other code.
    """

    cell: CellStiffness
    solid_share: float
    share: Any

    def areal_mass_kg_per_m2(self, solid_kg_per_m2: float) -> Any:
        return solid_kg_per_m2 * (1.0 - (1.0 - self.solid_share) * self.share)

    def membrane_energy(self, solid: Any, stiffness_N_per_m: float, C: Any) -> Any:
        """Return the energy per area in J/m2 from the energy of the ``solid`` sheet, and E t =
        ``stiffness_N_per_m``.

        The solid law takes the greatest factor that leaves the rest of the cell's stiffness positive.  The
        rest acts on the strain (C - 1/C) / 4, which agrees with the logarithmic strain to second order
        (Bazant, J. Eng. Mater. Technol. 120 (1998) 131-136).
        """
        factor, rest = self.split(stiffness_N_per_m)
        flat = self.share.function_space.mesh
        share_of_solid, stiffer = fem.Constant(flat, factor), fem.Constant(flat, rest)
        H = (C - ufl.inv(C)) / 4
        h = ufl.as_vector([H[0, 0], H[1, 1], 2 * H[0, 1]])
        soft = share_of_solid * solid + 0.5 * ufl.inner(h, stiffer * h)
        return (1.0 - self.share) * solid + self.share * soft

    def split(self, stiffness_N_per_m: float) -> tuple[float, Array]:
        """Return the factor of the solid law, and the stiffness (3, 3) on top of it, in N/m."""
        factor = float(eigh(self.cell.membrane, SOLID, eigvals_only=True)[0])
        return factor, stiffness_N_per_m * (self.cell.membrane - factor * SOLID)

    def moment(self, plate_N_m: float) -> Callable[[Any], Any]:
        """Return the bending moment of a curvature (2 x 2), for E t^3 / 12 = ``plate_N_m``."""
        flat = self.share.function_space.mesh
        solid = fem.Constant(flat, plate_N_m * SOLID)
        law = solid + self.share * fem.Constant(flat, plate_N_m * (self.cell.bending - SOLID))

        def moment(curvature: Any) -> Any:
            m = law * ufl.as_vector([curvature[0, 0], curvature[1, 1], curvature[0, 1] + curvature[1, 0]])
            return ufl.as_matrix([[m[0], m[2]], [m[2], m[1]]])

        return moment


def perforate(plan: PanelPlan, apertures: AperturePattern, flat: Any) -> Perforated:
    """Return the perforation on the mesh ``flat`` in material coordinates."""
    space = function_space(flat, "DG", 0)
    share = fem.Function(space)
    region = apertures.region_m(plan.rectangle)
    box = flat.geometry.x[cell_corners(flat)][:, :, :2]
    low, high = box.min(axis=1), box.max(axis=1)
    inside = np.clip(np.minimum(high, region[1]) - np.maximum(low, region[0]), 0.0, None)
    share.x.array[:] = (1.0 - apertures.margin_share) * (inside / (high - low)).prod(axis=1)
    return Perforated(cell_stiffness(apertures, plan.thickness_m), apertures.solid_share, share)
