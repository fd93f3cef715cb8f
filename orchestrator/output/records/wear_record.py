"""The depth of wear of the surface: at its points, and in patches of each panel."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from orchestrator.coupling.machine import PanelPoints
from orchestrator.ports import Array, Indices
from orchestrator.ports.geometry import Rectangle, TriangleSurface, area_vectors_m2

PATCHES = (8, 4)  # along and across a panel: each patch is large enough to be hit often
PARTS = 8  # of each side of a triangle, by the middles of which its area is divided among patches


class WearRecord:
    """A record of the depth of wear, which is the worn volume over the area at t = 0.

    Each corner of a triangle has a third of the triangle's area, and between points the depth is linear.  The
    patches divide the free length and the width of a panel evenly; what lies under a clamp counts to the
    nearest patch.
    """

    def __init__(
        self, surface: TriangleSurface, panels: Sequence[PanelPoints], rectangles: Sequence[Rectangle]
    ) -> None:
        self._area_m2 = vertex_area_m2(surface)
        self._panels = {
            panel.name: (panel.surface, _area_of_patches_m2(surface, panel.surface, rectangle))
            for panel, rectangle in zip(panels, rectangles, strict=True)
        }

    def vertex_depth_m(self, worn_m3: Array) -> Array:
        """Return the depth (vertices,) in m at the vertices; zero at vertices without a triangle."""
        there = self._area_m2 > 0
        return np.divide(worn_m3, self._area_m2, out=np.zeros(len(worn_m3)), where=there)

    def groups(self, worn_m3: Array) -> dict[str, Mapping[str, Array | float]]:
        """Return the group ``wear/<name>`` of each panel: ``worn_m3``, ``mean_m``, and ``depth_m`` by patch.

        The depth has the shape ``PATCHES``, and is NaN where a patch has no triangle.
        """
        groups: dict[str, Mapping[str, Array | float]] = {}
        depth_at_m = self.vertex_depth_m(worn_m3)
        for name, (points, area_m2) in self._panels.items():
            of_patch_m2, worn = area_m2.sum(axis=1), float(worn_m3[points].sum())
            depth_m = np.full(len(of_patch_m2), np.nan)
            np.divide(area_m2 @ depth_at_m[points], of_patch_m2, out=depth_m, where=of_patch_m2 > 0)
            whole = {"worn_m3": worn, "mean_m": worn / float(self._area_m2[points].sum())}
            groups[f"wear/{name}"] = {**whole, "depth_m": depth_m.reshape(PATCHES)}
        return groups


def vertex_area_m2(surface: TriangleSurface) -> Array:
    """Return the area (vertices,) of the vertices: a third of the area of the triangles around each."""
    area_m2 = np.linalg.norm(area_vectors_m2(surface.corners_m), axis=1)
    points, thirds_m2 = surface.triangles.ravel(), np.repeat(area_m2 / 3, 3)
    return np.bincount(points, thirds_m2, len(surface.vertices_m)).astype(np.float64)


def _area_of_patches_m2(surface: TriangleSurface, points: slice, at: Rectangle) -> Array:
    """Return the area (patches, points) that each of the panel's ``points`` has in each patch."""
    number = np.full(len(surface.vertices_m), -1)
    number[points] = np.arange(len(number[points]))
    corners = number[surface.triangles]
    corners = corners[(corners >= 0).all(axis=1)]
    corners_m, weights = surface.vertices_m[points][corners], _middles()
    triangle_m2 = np.linalg.norm(area_vectors_m2(corners_m), axis=1)
    patch = _patch(weights @ corners_m, at)
    shape = (PATCHES[0] * PATCHES[1], len(number[points]))
    place = patch[..., None] * shape[1] + corners[:, None, :]
    shares_m2 = triangle_m2[:, None, None] / len(weights) * weights
    area_m2 = np.bincount(place.ravel(), shares_m2.ravel(), shape[0] * shape[1])
    return np.asarray(area_m2.reshape(shape), dtype=np.float64)


def _middles() -> Array:
    """Return the middles of ``PARTS``^2 equal parts of a triangle, as weights of its corners (parts, 3)."""
    lower = [(3 * i + 1, 3 * j + 1) for i in range(PARTS) for j in range(PARTS - i)]
    upper = [(3 * i + 2, 3 * j + 2) for i in range(PARTS) for j in range(PARTS - i - 1)]
    second, third = np.array(lower + upper).T / (3 * PARTS)
    return np.stack([1 - second - third, second, third], axis=1)


def _patch(position_m: Array, at: Rectangle) -> Indices:
    """Return the number (...) of the patch of each place (..., 3) on the panel at t = 0."""
    from_corner_m = position_m - at.corner_m
    shares = (from_corner_m @ at.along / at.span_m, from_corner_m @ at.across / at.width_m)
    row, column = (
        np.clip((share * count + 1e-9).astype(np.int64), 0, count - 1)
        for share, count in zip(shares, PATCHES, strict=True)
    )
    return np.asarray(row * PATCHES[1] + column)
