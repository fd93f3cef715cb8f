"""A bed at rest on a taut panel: what the panel carries, and how far it sags."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.cases import load_case
from tests.coupled.machines import opened
from tests.coupled.resting_bed import ABREAST, BED, CASE, ROWS, SPAN_M, WEIGHT_N, X_M, lowered_m

pytestmark = pytest.mark.solver


def test_bed_at_rest(tmp_path: Path) -> None:
    """Mean over two periods of what is left of the swinging (measured: +0.5 % and 0.0 %).

    Wall force: the bed's weight.  Sag: that of a string under the spheres' weights P, in the
    middle  sum of P min(x, span - x) / (2 T),  for many of them q L^2 / (8 T); the panel's
    bending stiffness takes  8 E I / (T L^2) = 0.8 %  off it.
    """
    string_N_m = WEIGHT_N * ABREAST * np.minimum(X_M, SPAN_M - X_M).sum() / 2
    with opened(load_case(tmp_path, CASE + BED)) as run:
        empty_m = lowered_m(run.state.panel.surface.position_m)
        run.advance(3000)
        wall_N, ratio = np.zeros((2, 3000))
        for n in range(3000):
            state = run.advance(1)
            wall_N[n] = -state.load.force_N[:, 2].sum()
            tension_N = np.abs(state.panel.reaction.force_N[:, 0]).sum() / 2
            sag_m = lowered_m(state.panel.surface.position_m) - empty_m
            ratio[n] = sag_m * tension_N / string_N_m
        at_rest = np.abs(run.particles().velocity_m_per_s).max()
    assert at_rest < 0.005  # from 0.06 m/s on landing
    assert wall_N.mean() == pytest.approx(ROWS * ABREAST * WEIGHT_N, rel=0.01)
    assert ratio.mean() == pytest.approx(1.0, abs=0.02)
