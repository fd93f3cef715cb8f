"""Between the particles' triangles and the finite-element nodes: one matrix H.

Motion goes down by H, load goes up by its transpose, so that the virtual work of both sides is
the same whatever the two meshes are; H's rows sum to one, so that force is conserved, too.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.sparse import csr_array

from orchestrator.coupling.altered_panel import AlteredPanel
from orchestrator.ports import Inertia, Known, Load, Motion, Panel, PanelState
from orchestrator.ports.clock import Interval
from orchestrator.ports.panel import surface_ahead, surface_inertia


def mapped(panel: Panel, H: csr_array) -> AlteredPanel:
    """Returns the panel as seen through other points of its surface.

    ``H`` (new points, panel's surface points) comes from ``MeshedPanel.interpolation``.
    """
    HT, sizes = csr_array(H.T), abs(H)
    follow = surface_ahead(panel)

    def moved(surface: Motion) -> Motion:
        return Motion(H @ surface.position_m, H @ surface.velocity_m_per_s)

    def seen(state: PanelState) -> PanelState:
        return PanelState(moved(state.surface), state.reaction)

    def advance(interval: Interval, clamps: Motion, load: Load) -> PanelState:
        return seen(panel.advance(interval, clamps, Load(HT @ load.force_N)))

    def ahead(interval: Interval, clamps: Known) -> Known:
        """Of the points that hang on nothing that is not known."""
        own = follow(interval, clamps)
        return Known(moved(own.motion), sizes @ np.where(own.which, 0.0, 1.0) == 0.0)

    def inertia() -> Inertia:
        own = surface_inertia(panel)
        return replace(own, shapes=csr_array(H @ own.shapes))

    return AlteredPanel(panel, advance, lambda: seen(panel.initial()), inertia, ahead)
