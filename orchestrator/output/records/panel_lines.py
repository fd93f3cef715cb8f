"""The middle lines of panels at one moment: stretch, height over the chord, and folds.

A line runs along the middle of a panel's width, from the outer edge of its first clamp to that of
its second.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from typing import ClassVar

import numpy as np
from scipy.spatial import cKDTree

from orchestrator.case.deck.panels import single_panels
from orchestrator.case.tables.case import Case
from orchestrator.ports import Array
from orchestrator.ports.geometry import Rectangle
from orchestrator.ports.plans import SolverFailed
from orchestrator.ports.state import SavedAttributes


class PanelLines:
    """All lines together in arrays (points, 3), one panel's points after the other's, so that
    looking at them costs little at every sync point."""

    def __init__(self, rectangles: Sequence[Rectangle], lines_m: Sequence[Array]) -> None:
        """Take where each of one or more panels is mounted, and its line (n, 3) at t = 0."""
        counts = np.array([len(line) for line in lines_m])
        self._last = np.cumsum(counts) - 1
        self._first = self._last - counts + 1
        self._middle = self._first + counts // 2
        self._panel = np.repeat(np.arange(len(counts)), counts)
        self._along = np.array([at.along for at in rectangles])
        self._normal = np.array([at.normal for at in rectangles])
        self._free_m = np.array([at.length_m for at in rectangles])
        self._clamped_m = np.array([clamped_m(*pair) for pair in zip(rectangles, lines_m, strict=True)])

    def stretch(self, line_m: Array) -> Array:
        """Return (panels,) mean strain along the lines (points, 3): length between the clamps over the
        stress-free length, less one.

        A chord is shorter than its arc: with pieces h on a curvature k by h^2 k^2 / 24.
        """
        step_m = np.diff(line_m, axis=0)
        piece_m = np.sqrt(np.einsum("ij,ij->i", step_m, step_m))
        piece_m[self._last[:-1]] = 0.0  # from the end of one panel to the next one's beginning
        length_m = np.add.reduceat(piece_m, self._first)
        return np.asarray((length_m - self._clamped_m) / self._free_m - 1.0)

    def heights_m(self, line_m: Array) -> tuple[Array, Array]:
        """Return the distance from the chord between a line's ends, positive towards the bed: (panels,)
        the largest size, and (panels,) that of the middle point."""
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
    """Return how much of a line (n, 3) at t = 0 lies outside the free length, under the clamps."""
    along = (line_m - at.corner_m) @ at.along
    inside = (along > -0.5 * at.clamp_m - 1e-9) & (along < at.span_m + 0.5 * at.clamp_m + 1e-9)
    return _length_m(line_m) - _length_m(line_m[inside])


def panel_pull_N(first_N: Array, second_N: Array, along: Array) -> Array:
    """Return the (n,) pull of panels: half the difference of the forces (n, 3) on first and second clamp,
    along the unit vectors between them, (3,) or (n, 3); negative where a panel pushes."""
    return np.asarray(((first_N - second_N) * along).sum(axis=1) / 2)


def _length_m(line_m: Array) -> float:
    return float(np.linalg.norm(np.diff(line_m, axis=0), axis=1).sum())


LOG = logging.getLogger("flipflow")
FOLD_LENGTHS = 4.0  # in thicknesses: less than this apart along the panel is no fold but a bend


class FoldMonitor(SavedAttributes):
    """Looks for folds at output times, on rank 0.  Raises SolverFailed where the case wants that."""

    STATE: ClassVar = ("_said",)

    def __init__(self, case: Case) -> None:
        self._then = case.monitor.folded_panels
        self._thickness_m = {panel.name: panel.table.thickness_m for panel in single_panels(case)}
        self._said = np.empty(0, dtype=str)  # panels of which it was said

    def look(self, time_s: float, panel: str, line_m: Array) -> None:
        """Look at ``line_m`` (points, 3), the middle of the panel's width from clamp to clamp, now."""
        at_m = find_fold_m(line_m, self._thickness_m[panel])
        if at_m is None:
            return
        what = (
            f"panel {panel} has folded into itself at t = {time_s:.6g} s: its line {at_m[0]:.3g} m "
            f"and {at_m[1]:.3g} m from its first clamp is nearer than its thickness of "
            f"{self._thickness_m[panel]:.3g} m, and no solver here knows that it touches itself"
        )
        if self._then == "stop":
            raise SolverFailed(what)
        if panel not in self._said:
            LOG.warning(what)
            self._said = np.append(self._said, panel)


def find_fold_m(line_m: Array, thickness_m: float) -> tuple[float, float] | None:
    """Return where along the line (n, 3) two places are nearer to each other than the thickness, although
    at least ``FOLD_LENGTHS`` thicknesses lie between them; None if nowhere."""
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
