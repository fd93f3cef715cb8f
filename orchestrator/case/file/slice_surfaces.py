"""Rigid surfaces of a slice: what lies across is cut to it, what stands outside is left out or
moved in with the sides."""

from __future__ import annotations

import numpy as np

from orchestrator.ports import Array, Indices

SAME_PLACE_M = 1e-9  # corners closer than this are one


def cut(
    position_m: Array, triangles: Indices, y_m: tuple[float, float], move_in_m: float | None
) -> tuple[Array, Indices]:
    """Points (n, 3) and triangles (m, 3) of the part between ``y_m``.

    Triangles wholly outside, or in the plane of a side, are moved in by ``move_in_m``; None leaves
    them out.  Both in deck axes or both in the world: y is the same.
    """
    low, high = y_m
    kept: list[Array] = []
    for corners_m in position_m[triangles]:
        first, last = corners_m[:, 1].min(), corners_m[:, 1].max()
        if last <= low + SAME_PLACE_M or first >= high - SAME_PLACE_M:
            if move_in_m is not None:
                inwards_m = move_in_m if last <= low + SAME_PLACE_M else -move_in_m
                kept.append(corners_m + np.array([0.0, inwards_m, 0.0]))
            continue
        polygon = _clipped(_clipped(corners_m, low, 1.0), high, -1.0)
        kept += [polygon[[0, k, k + 1]] for k in range(1, len(polygon) - 1)]
    return _welded(np.array(kept).reshape(-1, 3, 3))


def _clipped(polygon_m: Array, limit_m: float, sign: float) -> Array:
    """The part of a convex polygon (n, 3) on one side of a plane y = limit: Sutherland, I. E. and
    Hodgman, G. W., Communications of the ACM 17, 1974, 32-42, doi 10.1145/360767.360802."""
    inside_m = sign * (polygon_m[:, 1] - limit_m)
    found = []
    for k in range(len(polygon_m)):
        before = k - 1
        if (inside_m[before] < 0) != (inside_m[k] < 0):
            along = inside_m[before] / (inside_m[before] - inside_m[k])
            crossing_m = polygon_m[before] + along * (polygon_m[k] - polygon_m[before])
            crossing_m[1] = limit_m
            found.append(crossing_m)
        if inside_m[k] >= 0:
            found.append(polygon_m[k])
    return np.array(found)


def _welded(corners_m: Array) -> tuple[Array, Indices]:
    """Equal corners as one point; triangles that shrank to a line are left out."""
    flat_m = corners_m.reshape(-1, 3)
    _, first, number = np.unique(
        np.round(flat_m / SAME_PLACE_M), axis=0, return_index=True, return_inverse=True
    )
    triangles = number.reshape(-1, 3).astype(np.int64)
    a, b, c = triangles.T
    return flat_m[first], triangles[(a != b) & (b != c) & (c != a)]
