"""Where a case's openings are, in the world at t = 0."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from orchestrator.case.deck.panels import SinglePanel, single_panels
from orchestrator.case.tables.case import Case
from orchestrator.ports import Array


def openings_m(case: Case) -> Array:
    """(openings, 3) centres, on the straight line between the clamps; none gives (0, 3)."""
    return np.vstack([np.empty((0, 3)), *(_centres_m(panel) for panel in single_panels(case))])


def _centres_m(panel: SinglePanel) -> Array:
    if panel.apertures is None:
        return np.empty((0, 3))
    at = panel.rectangle
    s, y = panel.apertures.centres_m(at).T
    along = np.outer(s * at.span_m / at.length_m, at.along)
    return np.asarray(at.corner_m + along + np.outer(y, at.across))


def smaller_sides_m(case: Case) -> Iterator[float]:
    """Of the openings of each panel that has any."""
    for panel in single_panels(case):
        if panel.apertures is not None:
            yield min(panel.apertures.length_m, panel.apertures.width_m)
