"""The depth of wear of the surface: at its points, and in patches of each panel."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from orchestrator.coupling.machine import PanelPoints
from orchestrator.ports import Array, Indices
from orchestrator.ports.geometry import Rectangle, TriangleSurface

PATCHES = (8, 4)  # along and across a panel: each patch is large enough to be hit often


class WearRecord:
    """A record of the depth of wear, which is the worn volume over the area at t = 0.

    Each corner of a triangle has a third of the triangle's area.  The patches divide the free length and the
    width of a panel evenly; a point under a clamp counts to the nearest patch.
    """

    def __init__(
        self, surface: TriangleSurface, panels: Sequence[PanelPoints], rectangles: Sequence[Rectangle]
    ) -> None:
        self._area_m2 = point_area_m2(surface)
        self._panels = {
            panel.name: (panel.surface, _patch(surface.position_m[panel.surface], rectangle))
            for panel, rectangle in zip(panels, rectangles, strict=True)
        }

    def point_depth_m(self, worn_m3: Array) -> Array:
        """Return the depth (points,) in m at the points; zero at points without a triangle."""
        there = self._area_m2 > 0
        return np.divide(worn_m3, self._area_m2, out=np.zeros(len(worn_m3)), where=there)

    def groups(self, worn_m3: Array) -> dict[str, Mapping[str, Array | float]]:
        """Return the group ``wear/<name>`` of each panel: ``worn_m3``, ``mean_m``, and ``depth_m`` by patch.

        The depth has the shape ``PATCHES``, and is NaN where a patch has no point.
        """
        groups: dict[str, Mapping[str, Array | float]] = {}
        for name, (points, patch) in self._panels.items():
            worn, area = (
                np.bincount(patch, values[points], PATCHES[0] * PATCHES[1]).reshape(PATCHES)
                for values in (worn_m3, self._area_m2)
            )
            depth_m = np.divide(worn, area, out=np.full(PATCHES, np.nan), where=area > 0)
            whole = {"worn_m3": float(worn.sum()), "mean_m": float(worn.sum() / area.sum())}
            groups[f"wear/{name}"] = {**whole, "depth_m": depth_m}
        return groups


def point_area_m2(surface: TriangleSurface) -> Array:
    """Return the area (points,) of the points: a third of the area of the triangles around each."""
    a, b, c = (surface.position_m[surface.triangles[:, k]] for k in range(3))
    area_m2 = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    points, thirds_m2 = surface.triangles.ravel(), np.repeat(area_m2 / 3, 3)
    return np.bincount(points, thirds_m2, len(surface.position_m)).astype(np.float64)


def _patch(position_m: Array, at: Rectangle) -> Indices:
    """Return the number (points,) of each point's patch, from its place at t = 0."""
    from_corner_m = position_m - at.corner_m
    shares = (from_corner_m @ at.along / at.span_m, from_corner_m @ at.across / at.width_m)
    row, column = (
        np.clip((share * count + 1e-9).astype(np.int64), 0, count - 1)
        for share, count in zip(shares, PATCHES, strict=True)
    )
    return np.asarray(row * PATCHES[1] + column)
