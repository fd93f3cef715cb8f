"""Recordings made by hand, for the tests of the recorded panel."""

from __future__ import annotations

import numpy as np

from orchestrator.ports import Array
from orchestrator.ports.plans import PanelPlan
from orchestrator.ports.recording import Playback, RecordedGrid, Recording

CELLS = (8, 2)
SAMPLES = 64
PULL_N = np.array([-20.0, 0.0, 1.0])


def arch(plan: PanelPlan, points_m: Array) -> Array:
    """(n,) sin^2 along the free length: level at the clamps, 1 in the middle."""
    s = np.clip(points_m[:, 0], 0.0, plan.rectangle.length_m)
    return np.asarray(np.sin(np.pi * s / plan.rectangle.length_m) ** 2)


def moved(angle_rad: float) -> Array:
    """(3,) of the middle, in m: 10 mm up and down, 1 mm along at twice the speed."""
    return np.array([1e-3 * np.sin(2 * angle_rad), 0.0, 1e-2 * np.sin(angle_rad)])


def rate(angle_rad: float) -> Array:
    return np.array([2e-3 * np.cos(2 * angle_rad), 0.0, 1e-2 * np.cos(angle_rad)])


def playback(plan: PanelPlan, moving: float, sag_m: float = 2e-3, cells: tuple[int, int] = CELLS) -> Playback:
    """An arch that sags at rest and moves by ``moving`` times ``moved`` around there."""
    grid = RecordedGrid.of(plan.rectangle, cells)
    shape = arch(plan, grid.points_m)[:, None]
    angles = 2 * np.pi * np.arange(SAMPLES) / SAMPLES
    rest_m = shape * np.array([0.0, 0.0, -sag_m])
    recording = Recording(
        grid=grid,
        cycles=1,
        shape_m=rest_m + moving * np.array([shape * moved(angle) for angle in angles]),
        rate_m=moving * np.array([shape * rate(angle) for angle in angles]),
        rest_m=rest_m,
        pull_N=PULL_N * (1 + moving * np.cos(angles)[:, None]),
        rest_pull_N=PULL_N,
    )
    return Playback(recording, 78.5, zero_s=0.01, start_s=0.02, run_up_s=0.08)
