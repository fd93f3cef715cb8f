"""Triangles over a panel that particles touch, in material coordinates."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchestrator.ports import Array, Indices
from orchestrator.ports.geometry import Rectangle


@dataclass(frozen=True)
class TriangleGrid:
    """Triangles over a panel, in material coordinates.

    ``coordinates_m`` (n, 2), ``triangles`` (m, 3) with normals to the bed's side, and
    ``centre_line`` the points nearest the middle of the width, in order along the panel.
    """

    coordinates_m: Array
    triangles: Indices
    centre_line: Indices


def grid(rectangle: Rectangle, cells: tuple[int, int]) -> TriangleGrid:
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
    a, b, c, d = (n.ravel() for n in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]))
    even = (np.add.outer(np.arange(len(s) - 1), np.arange(across)) % 2 == 0).ravel()
    one = np.where(even[:, None], np.column_stack([a, b, c]), np.column_stack([a, b, d]))
    two = np.where(even[:, None], np.column_stack([a, c, d]), np.column_stack([b, c, d]))
    coordinates = np.column_stack([np.repeat(s, rows), np.tile(y, len(s))])
    return TriangleGrid(coordinates, np.vstack([one, two]).astype(np.int64), number[:, rows // 2])
