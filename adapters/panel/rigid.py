"""A panel that does not deform: flat between its clamps, massive, without integration.

Each clamp is a rectangle of four points (two if it has no depth: ``clamp_m`` = 0); the surface
between the inner edges is bilinear in its four corners.  All its points are clamps, so they
move as the frames do, and the panel's reaction has the forces that move them:

    reaction = load + m (gravity - mean acceleration)      at each point.

The mass of a cell goes in equal parts to its corners (the row sums of the consistent mass
matrix): total mass, centre of mass and linear momentum are exact, the moment of inertia about
the panel's own centre is not (edges too heavy by a factor of up to 3).
"""

from __future__ import annotations

import numpy as np

from adapters.panel.common import bilinear
from adapters.panel.common.carried import RigidSurface
from adapters.panel.common.grid import clamped_rows_m
from orchestrator.ports import Array, Interpolation, Mount
from orchestrator.ports.adapters import PanelAdapter
from orchestrator.ports.plans import Cost, PanelPlan, PanelsWork


def build(plan: PanelPlan) -> RigidPanel:
    """Open a rigid panel of the plan's rectangle, frames, thickness, density and gravity."""
    return RigidPanel(plan)


class RigidPanel(RigidSurface):
    """A ``MeshedPanel`` whose surface points are its clamp points, row by row: y = 0 before y = width."""

    def __init__(self, plan: PanelPlan) -> None:
        rectangle = plan.rectangle
        rows_m = clamped_rows_m(rectangle, np.array([0.0, rectangle.length_m]))
        self._rows_m, self._width_m = rows_m, rectangle.width_m
        material_m = bilinear.points_m(rows_m, rectangle.width_m)
        per_length = plan.material.density_kg_per_m3 * plan.thickness_m * rectangle.width_m
        solid = np.ones(len(rows_m) - 1)
        if plan.apertures:
            solid[len(solid) // 2] = plan.apertures.material_share(rectangle)
        ends = rectangle.end(material_m).astype(int)
        super().__init__(
            f"panel {plan.name}",
            Mount(rectangle.mounted(material_m), tuple(plan.frames[k] for k in ends)),
            bilinear.half_row_mass_kg(rows_m, per_length * solid),
            plan.gravity_m_per_s2,
        )

    def interpolation(self, coordinates_m: Array) -> Interpolation:
        """Return bilinear shape functions in (s, y) within each of the panel's one or three rectangles."""
        return bilinear.interpolation(self._rows_m, self._width_m, coordinates_m)


def cost(work: PanelsWork) -> Cost:
    """Return the time of a call of each panel in each interval."""
    return Cost(0.01 * work.panels, 4e-5 * work.panels * work.runs)


ADAPTER = PanelAdapter(
    about="flat between its clamps, undeformed",
    build=build,
    cost=cost,
    leaves_out={"panel-deformation": "panels stay flat"},
    deforms=False,
    yields=False,
    varies_across=False,
    fidelity=0,
)
