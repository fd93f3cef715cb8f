"""How a mat would flip at other strokes, speeds and pre-stretches."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from orchestrator.ports import Array
from orchestrator.preflight.mats.mats import remembered_regimes
from orchestrator.preflight.mats.regime import Regime
from orchestrator.preflight.mats.trial import Trial

STROKES = (0.6, 0.8, 1.0, 1.2, 1.4)
SPEEDS = (0.8, 0.9, 1.0, 1.1, 1.2)
"""Strokes and speeds of a chart, over the mat's own."""
STRETCH = 0.01
"""Change of the distance of the clamps, over the free length, from one part of a chart to the next."""
CELLS, WATCHED_TURNS = 16, 12
"""Of a trial of a chart: the sides are those of finer ones, and peaks may be off by half."""


@dataclass(frozen=True)
class Chart:
    """The regimes of a mat by (pre-stretch, speed, stroke); the mat's own place is in the middle of each.

    ``tension_m`` is the distance of the clamps less the free length.
    """

    stroke_m: Array
    speed_rad_per_s: Array
    tension_m: Array
    regimes: tuple[tuple[tuple[Regime, ...], ...], ...]


def make_chart(trial: Trial) -> Chart:
    """Return the chart about a mat, which takes some seconds.  Raises SolverFailed and SolverMissing."""
    at = trial.plan.rectangle
    strokes_m, speeds = np.multiply(STROKES, trial.stroke_m), np.multiply(SPEEDS, trial.speed_rad_per_s)
    spans_m = at.span_m + STRETCH * at.length_m * np.array([-1.0, 0.0, 1.0])
    tried = [
        trial.at(stroke_m, speed, span_m) for span_m, speed, stroke_m in product(spans_m, speeds, strokes_m)
    ]
    found = remembered_regimes(tried, CELLS, WATCHED_TURNS)
    rows = [tuple(found[n : n + len(strokes_m)]) for n in range(0, len(found), len(strokes_m))]
    parts = tuple(tuple(rows[n : n + len(speeds)]) for n in range(0, len(rows), len(speeds)))
    return Chart(strokes_m, speeds, spans_m - at.length_m, parts)
