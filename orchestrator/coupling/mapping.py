"""The mapping between the particles' triangles and the finite-element nodes.

One matrix H maps motion down and its transpose maps load up, so that the virtual work of both sides is the
same for any two meshes.  The rows of H sum to one, so that force is conserved, too.  Points at an offset from
the surface also go with its normal, and the couple of their load goes to the nodes by the transpose of this.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.sparse import csr_array

from orchestrator.coupling._kernel import NormalOffsets, PointMatrix
from orchestrator.coupling.wrappers import PanelWrapper
from orchestrator.ports import (
    Account,
    Inertia,
    Interpolation,
    Known,
    Load,
    Motion,
    Panel,
    PanelState,
    Saved,
    check_point_count,
)
from orchestrator.ports.clock import Interval
from orchestrator.ports.state import restore_attributes, save_attributes


def mapped(panel: Panel, points: Interpolation) -> MappedPanel:
    """Return a panel as seen through other points, which ``MeshedPanel.interpolation`` has found."""
    return OffsetPanel(panel, points) if points.offset_m.any() else MappedPanel(panel, points.values)


class MappedPanel(PanelWrapper):
    """A panel as seen through other points of its surface, by the matrix ``H`` (new points, panel's surface
    points).
    """

    def __init__(self, panel: Panel, H: csr_array) -> None:
        super().__init__(panel)
        self._H, self._sizes = H, abs(H)
        self._matrix = _compiled(H)
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


class OffsetPanel(MappedPanel):
    """A panel as seen through points some of which stand beside its surface, along its normal as it is bent.

    A load acts where the present velocity of the panel takes its points by the middle of the interval.  Force
    and moment are exact there.  The work at the points, which counts as received, differs from that at the
    panel's own points in the third order of the interval; this is a defect of the panel.  In ``inertia`` the
    points count as their feet.
    """

    STATE = ("_own", "_seen", "_work_beyond_own_J")

    def __init__(self, panel: Panel, points: Interpolation) -> None:
        super().__init__(panel, points.values)
        self._sizes = abs(points.values) + abs(points.along) + abs(points.across)
        along, across = _compiled(points.along), _compiled(points.across)
        self._offsets = NormalOffsets(along, across, points.offset_m)
        self._own, self._work_beyond_own_J = panel.initial().surface, 0.0
        self._seen = self._motion(self._own)

    def advance(self, interval: Interval, clamps: Motion, load: Load) -> PanelState:
        check_point_count("points of a panel: load", load, len(self._seen))
        middle_m = self._own.position_m + interval.length_s / 2 * self._own.velocity_m_per_s
        own_load_N = self._matrix.transposed_times(load.force_N)
        self._offsets.add_load(middle_m, load.force_N, own_load_N)
        own = self._solver.advance(interval, clamps, Load(own_load_N))
        seen = self._state(own)
        work_J = np.vdot(load.force_N, seen.surface.position_m - self._seen.position_m)
        own_work_J = np.vdot(own_load_N, own.surface.position_m - self._own.position_m)
        self._work_beyond_own_J += float(work_J - own_work_J)
        self._own, self._seen = own.surface, seen.surface
        return seen

    def account(self) -> Account:
        own = super().account()
        load_J = own.received_J["load"] + self._work_beyond_own_J
        return replace(own, received_J={**own.received_J, "load": load_J})

    def save(self) -> Saved:
        return {"panel": super().save(), **save_attributes(self, *self.STATE)}

    def restore(self, saved: Saved) -> None:
        super().restore(saved["panel"])
        restore_attributes(self, saved, *self.STATE)

    def _motion(self, surface: Motion) -> Motion:
        points = super()._motion(surface)
        self._offsets.add_motion(
            surface.position_m, surface.velocity_m_per_s, points.position_m, points.velocity_m_per_s
        )
        return points

    def _state(self, state: PanelState) -> PanelState:
        points = self._motion(state.surface)
        return PanelState(Motion(points.position_m, points.velocity_m_per_s), state.reaction)


def _compiled(matrix: csr_array) -> PointMatrix:
    return PointMatrix(matrix.indptr, matrix.indices, matrix.data, matrix.shape[1])
