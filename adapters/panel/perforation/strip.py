"""What openings leave of a strip's mass and stiffness along, per piece of its length.

Across, margins and pattern act side by side; along, the perforated and the solid part of a piece
act one after the other.  Their stiffness is that of ``unit_cell``, free to contract across.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchestrator.ports import Array
from orchestrator.ports.plans import PanelPlan, SolverMissing


@dataclass(frozen=True)
class Left:
    """What is left of each piece: shares (pieces,) of mass, tension and bending stiffness."""

    mass: Array
    tension: Array
    bending: Array


def left(plan: PanelPlan, low_m: Array, high_m: Array) -> Left:
    """Return what is left of pieces of the strip from s = ``low_m`` to ``high_m``, (pieces,) each.

    SolverMissing without DOLFINx, which computes the pattern's stiffness.
    """
    pattern = plan.apertures
    if pattern is None:
        whole = np.ones(len(low_m))
        return Left(whole, whole, whole)
    try:
        from adapters.panel.common import _petsc  # noqa: F401
        from adapters.panel.perforation.unit_cell import along, cell_stiffness
    except ImportError as missing:
        raise SolverMissing(
            f"a strip with apertures needs DOLFINx 0.5 (Debian 12: python3-dolfinx): {missing}"
        ) from missing
    region = pattern.region_m(plan.rectangle)
    inside_m = np.minimum(high_m, region[1, 0]) - np.maximum(low_m, region[0, 0])
    length = np.clip(inside_m, 0.0, None) / (high_m - low_m)
    width = float(np.ptp(region[:, 1])) / plan.rectangle.width_m
    cell = cell_stiffness(pattern, plan.thickness_m)

    def in_series(stiffness: Array) -> Array:
        beside_margins = 1 - width + width * along(stiffness)
        return np.asarray(1 / (1 - length + length / beside_margins))

    mass = 1 - length * width * (1 - pattern.solid_share)
    return Left(mass, in_series(cell.membrane), in_series(cell.bending))
