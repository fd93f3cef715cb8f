"""The middle lines of all panels at one moment: how far they are stretched, and how they stand out.

A line runs along the middle of a panel's width, from the outer edge of its first clamp to that of
its second.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from orchestrator.ports import Array
from orchestrator.ports.geometry import Rectangle


class PanelLines:
    """All lines together in arrays (points, 3), one panel's points after the other's, so that
    looking at them costs little at every sync point."""

    def __init__(self, rectangles: Sequence[Rectangle], lines_m: Sequence[Array]) -> None:
        """Of at least one panel: where each is mounted, and its line (n, 3) at t = 0."""
        counts = np.array([len(line) for line in lines_m])
        self._last = np.cumsum(counts) - 1
        self._first = self._last - counts + 1
        self._middle = self._first + counts // 2
        self._panel = np.repeat(np.arange(len(counts)), counts)
        self._along, self._normal = (
            np.array([getattr(one, name) for one in rectangles]) for name in ("along", "normal")
        )
        self._free_m = np.array([one.length_m for one in rectangles])
        self._clamped_m = np.array(
            [clamped_m(one, line) for one, line in zip(rectangles, lines_m, strict=True)]
        )

    def stretch(self, line_m: Array) -> Array:
        """(panels,) mean strain along the lines (points, 3): length between the clamps over the
        stress-free length, less one.

        A chord is shorter than its arc: with pieces h on a curvature k by h^2 k^2 / 24.
        """
        step_m = np.diff(line_m, axis=0)
        piece_m = np.sqrt(np.einsum("ij,ij->i", step_m, step_m))
        piece_m[self._last[:-1]] = 0.0  # from the end of one panel to the next one's beginning
        length_m = np.add.reduceat(piece_m, self._first)
        return np.asarray((length_m - self._clamped_m) / self._free_m - 1.0)

    def heights_m(self, line_m: Array) -> tuple[Array, Array]:
        """Distance from the chord between a line's ends, positive towards the bed: (panels,) the
        largest size, and (panels,) that of the middle point."""
        chord_m = line_m[self._last] - line_m[self._first]
        run_m = np.einsum("pi,pi->p", chord_m, self._along)
        climb_m = np.einsum("pi,pi->p", chord_m, self._normal)
        over_m = np.hypot(run_m, climb_m)
        # normal to the chord, in the plane of the panel's length and its normal
        upright = (run_m[:, None] * self._normal - climb_m[:, None] * self._along) / over_m[:, None]
        from_end_m = line_m - line_m[self._first][self._panel]
        height_m = np.einsum("ij,ij->i", from_end_m, upright[self._panel])
        largest_m = np.maximum.reduceat(np.abs(height_m), self._first)
        return largest_m, height_m[self._middle]


def clamped_m(at: Rectangle, line_m: Array) -> float:
    """How much of a line (n, 3) at t = 0 lies outside the free length, under the clamps."""
    along = (line_m - at.corner_m) @ at.along
    inside = (along > -0.5 * at.clamp_m - 1e-9) & (along < at.span_m + 0.5 * at.clamp_m + 1e-9)
    return _length_m(line_m) - _length_m(line_m[inside])


def tension_N(first_N: Array, second_N: Array, along: Array) -> Array:
    """(n,) pull of panels: half the difference of the forces (n, 3) on first and second clamp,
    along the unit vectors between them, (3,) or (n, 3); negative where a panel pushes."""
    return np.asarray(((first_N - second_N) * along).sum(axis=1) / 2)


def _length_m(line_m: Array) -> float:
    return float(np.linalg.norm(np.diff(line_m, axis=0), axis=1).sum())
