"""Between the particles' triangles and the finite-element nodes: one matrix H.

Motion goes down by H, load goes up by its transpose, so that the virtual work of both sides is
the same whatever the two meshes are; H's rows sum to one, so that force is conserved, too.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csr_array

from orchestrator.altered_panel import AlteredPanel
from orchestrator.clock import Interval
from orchestrator.geometry import Rectangle
from orchestrator.inertia import inertia_of
from orchestrator.ports import Array, Indices, Inertia, Known, Load, Motion, Panel, PanelState
from orchestrator.schedule import ahead_of


@dataclass(frozen=True)
class Grid:
    """Triangles over a panel, in material coordinates.

    ``coordinates_m`` (n, 2), ``triangles`` (m, 3) with normals to the bed's side, and
    ``centre_line`` the points nearest the middle of the width, in order along the panel.
    """

    coordinates_m: Array
    triangles: Indices
    centre_line: Indices


def grid(rectangle: Rectangle, cells: tuple[int, int]) -> Grid:
    """A regular grid of right triangles over the free length and under both clamps.

    The diagonals alternate, so that the panel has no preferred direction.
    """
    along, across = cells
    free = np.linspace(0.0, rectangle.length_m, along + 1)
    held = [rectangle.clamp_m] if rectangle.clamp_m > 0 else []
    s = np.concatenate([[-c for c in held], free, [rectangle.length_m + c for c in held]])
    y = np.linspace(0.0, rectangle.width_m, across + 1)
    rows = len(y)
    number = np.arange(len(s) * rows).reshape(len(s), rows)
    a, b, c, d = (
        n.ravel() for n in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:])
    )
    even = (np.add.outer(np.arange(len(s) - 1), np.arange(across)) % 2 == 0).ravel()
    one = np.where(even[:, None], np.column_stack([a, b, c]), np.column_stack([a, b, d]))
    two = np.where(even[:, None], np.column_stack([a, c, d]), np.column_stack([b, c, d]))
    coordinates = np.column_stack([np.repeat(s, rows), np.tile(y, len(s))])
    return Grid(coordinates, np.vstack([one, two]).astype(np.int64), number[:, rows // 2])


def mapped(panel: Panel, H: csr_array) -> AlteredPanel:
    """The panel seen through other points of its surface; ``H`` (new points, panel's surface
    points), from ``MeshedPanel.interpolation``."""
    HT, sizes = csr_array(H.T), abs(H)
    follow = ahead_of(panel)

    def moved(surface: Motion) -> Motion:
        return Motion(H @ surface.position_m, H @ surface.velocity_m_s)

    def seen(state: PanelState) -> PanelState:
        return PanelState(moved(state.surface), state.reaction)

    def advance(interval: Interval, clamps: Motion, load: Load) -> PanelState:
        return seen(panel.advance(interval, clamps, Load(HT @ load.force_N)))

    def ahead(interval: Interval, clamps: Known) -> Known:
        """Of the points that hang on nothing that is not known."""
        own = follow(interval, clamps)
        return Known(moved(own.motion), sizes @ np.where(own.which, 0.0, 1.0) == 0.0)

    def inertia() -> Inertia:
        own = inertia_of(panel)
        return replace(own, shapes=csr_array(H @ own.shapes))

    return AlteredPanel(panel, advance, lambda: seen(panel.initial()), inertia, ahead)
