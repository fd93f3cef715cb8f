"""The watch on panels: one that folds into itself is no panel any more."""

from __future__ import annotations

import logging

import numpy as np
from scipy.spatial import cKDTree

from orchestrator.case.deck.panels import single_panels
from orchestrator.case.tables.case import Case
from orchestrator.ports import Array, Saved
from orchestrator.ports.plans import SolverFailed

LOG = logging.getLogger("flipflow")
FOLD_LENGTHS = 4.0  # in thicknesses: less than this apart along the panel is no fold but a bend


class PanelWatch:
    """Looks at output times, on rank 0.  Raises SolverFailed where the case wants that."""

    def __init__(self, case: Case) -> None:
        self._then = case.monitor.folded_panels
        self._thickness_m = {panel.name: panel.table.thickness_m for panel in single_panels(case)}
        self._said: set[str] = set()

    def look(self, time_s: float, panel: str, line_m: Array) -> None:
        """``line_m`` (points, 3): the middle of the panel's width from clamp to clamp, now."""
        at_m = touches_itself_m(line_m, self._thickness_m[panel])
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
            self._said.add(panel)

    def save(self) -> Saved:
        return {"said": np.array(sorted(self._said), dtype=str)}

    def restore(self, saved: Saved) -> None:
        self._said = set(saved["said"].tolist())


def touches_itself_m(line_m: Array, thickness_m: float) -> tuple[float, float] | None:
    """Where along the line (n, 3) two places are nearer to each other than the thickness, although
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
