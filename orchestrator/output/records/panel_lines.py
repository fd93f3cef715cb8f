"""The middle lines of panels at one moment: their stretch, their height over the chord, and their folds.

A line runs along the middle of a panel's width, from the outer edge of its first clamp to the outer
edge of its second clamp.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy.spatial import cKDTree

from orchestrator.ports import Array
from orchestrator.ports.geometry import Rectangle


class PanelLines:
    """The middle lines of all panels in common arrays (points, 3), one panel's points after the other's.

    The common arrays make an evaluation at every sync point cheap.
    """

    def __init__(self, rectangles: Sequence[Rectangle], lines_m: Sequence[Array]) -> None:
        """Set the place of each panel (at least one), and its line (n, 3) at t = 0."""
        counts = np.array([len(line) for line in lines_m])
        self._last = np.cumsum(counts) - 1
        self._first = self._last - counts + 1
        self._middle = self._first + counts // 2
        self._panel = np.repeat(np.arange(len(counts)), counts)
        self._along = np.array([at.along for at in rectangles])
        self._normal = np.array([at.normal for at in rectangles])
        self._free_m = np.array([at.length_m for at in rectangles])
        outer_m = [at.clamp_m * math.sin(math.radians(at.clamp_angle_deg)) for at in rectangles]
        self._lift_m = np.array(outer_m) if any(outer_m) else None  # of the ends over the inner edges
        pairs = zip(rectangles, lines_m, strict=True)
        self._clamped_m = np.array([clamped_length_m(rectangle, line_m) for rectangle, line_m in pairs])

    def stretch(self, line_m: Array) -> Array:
        """Return the mean strain (..., panels) along the lines (..., points, 3), of any number of times.

        The strain is the length between the clamps over the stress-free length, less one.  Chords of
        length h on a curvature k are shorter than their arcs by the share h^2 k^2 / 24.
        """
        step_m = np.diff(line_m, axis=-2)
        piece_m = np.sqrt(sum_of_products(step_m, step_m))
        piece_m[..., self._last[:-1]] = 0.0  # from the end of a panel to the beginning of the next panel
        length_m = np.add.reduceat(piece_m, self._first, axis=-1)
        return np.asarray((length_m - self._clamped_m) / self._free_m - 1.0)

    def heights_m(self, line_m: Array) -> tuple[Array, Array]:
        """Return each line's largest distance from the chord between its ends, and the height of its middle.

        Both are (..., panels) in m, of lines (..., points, 3).  The height over the chord is positive towards
        the bed.  Ends in turned clamps count as being as high as the clamps' inner edges.
        """
        first_m = line_m[..., self._first, :]
        chord_m = line_m[..., self._last, :] - first_m
        run_m, climb_m = sum_of_products(chord_m, self._along), sum_of_products(chord_m, self._normal)
        over_m = np.hypot(run_m, climb_m)
        # normal to the chord, in the plane of the panel's length and its normal
        upright = (run_m[..., None] * self._normal - climb_m[..., None] * self._along) / over_m[..., None]
        from_end_m = line_m - first_m[..., self._panel, :]
        height_m = sum_of_products(from_end_m, upright[..., self._panel, :])
        if self._lift_m is not None:
            height_m = height_m + self._lift_m[self._panel]
        largest_m = np.maximum.reduceat(np.abs(height_m), self._first, axis=-1)
        return largest_m, height_m[..., self._middle]


def sum_of_products(a: Array, b: Array) -> Array:
    """Return the products of vectors (..., 3), added in the same order however many there are."""
    return np.asarray(a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1] + a[..., 2] * b[..., 2])


def clamped_length_m(at: Rectangle, line_m: Array) -> float:
    """Return the length of a line (n, 3) at t = 0 that lies under the clamps."""
    along = (line_m - at.corner_m) @ at.along
    inside = (along > -0.5 * at.clamp_m - 1e-9) & (along < at.span_m + 0.5 * at.clamp_m + 1e-9)
    return _length_m(line_m) - _length_m(line_m[inside])


def panel_pull_N(first_N: Array, second_N: Array, along: Array) -> Array:
    """Return the pull (..., n) of panels, which is negative where a panel pushes.

    The pull is half the difference of the forces (..., n, 3) on the first and the second clamp, along the
    unit vectors ``along`` from the first clamp to the second, (3,) or (n, 3).
    """
    return sum_of_products(first_N - second_N, along) / 2


def _length_m(line_m: Array) -> float:
    return float(np.linalg.norm(np.diff(line_m, axis=0), axis=1).sum())


FOLD_LENGTHS = 4.0  # thicknesses: places that are nearer along the panel form a bend and no fold


def find_fold_m(line_m: Array, thickness_m: float) -> tuple[float, float] | None:
    """Return the stations in m of two places on a line (n, 3) that touch, or None if no places touch.

    Two places touch if they are nearer to each other than the thickness, although more than
    ``FOLD_LENGTHS`` thicknesses of the line lie between them.  There are none where all pieces of the line go
    forward, along its chord, by more than their length over ``FOLD_LENGTHS``.
    """
    piece_m = np.linalg.norm(np.diff(line_m, axis=0), axis=1)
    count = np.maximum(1, np.ceil(2.0 * piece_m / thickness_m).astype(int))
    fine = [
        start + np.outer(np.arange(n) / n, end - start)
        for start, end, n in zip(line_m[:-1], line_m[1:], count, strict=True)
    ]
    places_m = np.vstack([*fine, line_m[-1:]])
    along_m = np.concatenate([[0.0], np.linalg.norm(np.diff(places_m, axis=0), axis=1).cumsum()])
    near = cKDTree(places_m).query_pairs(thickness_m, output_type="ndarray")  # lower number first
    touching = near[np.diff(along_m[near], axis=1)[:, 0] > FOLD_LENGTHS * thickness_m]
    if not len(touching):
        return None
    first, second = along_m[min(touching.tolist())]
    return float(first), float(second)
