"""A panel's line that folds into itself is found, an arch that only bends is not."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator.output.records.panel_lines import find_fold_m


def hairpin(gap_m: float) -> np.ndarray:
    """100 mm out, a half turn, 100 mm back, ``gap_m`` above."""
    angle = np.linspace(-np.pi / 2, np.pi / 2, 20)[1:-1]
    turn = 0.1 + gap_m / 2 * np.cos(angle), gap_m / 2 * (1 + np.sin(angle))
    out, back = np.linspace(0.0, 0.1, 11), np.linspace(0.1, 0.0, 11)
    x = np.concatenate([out, turn[0], back])
    z = np.concatenate([0 * out, turn[1], 0 * back + gap_m])
    return np.column_stack([x, 0 * x, z])


@pytest.mark.parametrize("gap_m", [0.001, 0.0035])
def test_a_hairpin_narrower_than_the_thickness(gap_m: float) -> None:
    fold_m = find_fold_m(hairpin(gap_m), 0.004)
    assert fold_m is not None
    assert fold_m[1] - fold_m[0] > 4 * 0.004


@pytest.mark.parametrize("gap_m", [0.005, 0.05])
def test_a_hairpin_wider_than_the_thickness(gap_m: float) -> None:
    assert find_fold_m(hairpin(gap_m), 0.004) is None


def test_a_loop_that_crosses_itself_between_points() -> None:
    """Few points: none of them is near the place where the segments cross."""
    line_m = np.array([[0, 0, 0], [0.2, 0, 0], [0.2, 0, 0.1], [0.1, 0, 0.1], [0.1, 0, -0.1]], float)
    assert find_fold_m(line_m, 0.004) is not None


@pytest.mark.parametrize("sag_m", [0.0, 0.027, 0.1])
def test_a_sagging_panel_does_not(sag_m: float) -> None:
    x = np.linspace(0.0, 0.3, 23)
    line_m = np.column_stack([x, 0 * x, -sag_m * np.sin(np.pi * x / 0.3)])
    assert find_fold_m(line_m, 0.004) is None
