"""The mapping between the particles' triangles and the finite-element nodes: one matrix H.

H maps motion down and its transpose maps load up, so that the virtual work of both sides is the same for any
two meshes.  The rows of H sum to one, so that force is conserved, too.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.sparse import csr_array

from orchestrator.coupling._kernel import PointMatrix
from orchestrator.coupling.wrappers import PanelWrapper
from orchestrator.ports import Inertia, Known, Load, Motion, Panel, PanelState
from orchestrator.ports.clock import Interval


class MappedPanel(PanelWrapper):
    """A panel as seen through other points of its surface.

    ``H`` (new points, panel's surface points) comes from ``MeshedPanel.interpolation``.
    """

    def __init__(self, panel: Panel, H: csr_array) -> None:
        super().__init__(panel)
        self._H, self._sizes = H, abs(H)
        self._matrix = PointMatrix(H.indptr, H.indices, H.data, H.shape[1])
        self._load, self._own_load = Load(np.zeros((H.shape[0], 3))), Load(np.zeros((H.shape[1], 3)))

    def initial(self) -> PanelState:
        return self._state(super().initial())

    def advance(self, interval: Interval, clamps: Motion, load: Load) -> PanelState:
        if load is not self._load:  # a scheme that tries an interval gives a load twice
            self._load, self._own_load = load, Load.unchecked(self._matrix.transposed_times(load.force_N))
        return self._state(super().advance(interval, clamps, self._own_load))

    def ahead(self, interval: Interval, clamps: Known) -> Known:
        """Return the motion of the points that depend on known surface points alone."""
        own = super().ahead(interval, clamps)
        return Known(self._motion(own.motion), self._sizes @ np.where(own.which, 0.0, 1.0) == 0.0)

    def inertia(self) -> Inertia:
        own = super().inertia()
        return replace(own, shapes=csr_array(self._H @ own.shapes))

    def _motion(self, surface: Motion) -> Motion:
        times = self._matrix.times
        return Motion.unchecked(times(surface.position_m), times(surface.velocity_m_per_s))

    def _state(self, state: PanelState) -> PanelState:
        return PanelState(self._motion(state.surface), state.reaction)
