"""The tools that measure pairs of runs and the scatter of parts, against closed forms."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from orchestrator.output.results.run_reader import RunReader
from tests.results.synthetic import MASS_KG, folder_of
from tools.paired_seeds import Levels
from tools.scatter import chance_of_whole, efficiencies

DRAW = np.random.default_rng(1)
DEAR = DRAW.normal(30.0, 3.0, 10)
OTHER = DRAW.normal(30.0, 3.0, 10)


def test_a_perfect_cheap_setting_costs_what_it_costs() -> None:
    """Without a difference only cheap runs are needed: the error falls by the root of the costs' ratio."""
    levels = Levels(DEAR, DEAR.copy(), 1.0, 100.0)
    assert levels.two_level_error(1e4) == pytest.approx(levels.dear_error(1e4) / 10)
    assert levels.controlled_error(1e4, 1.0) == pytest.approx(levels.dear_error(1e4) / 10)


@pytest.mark.parametrize("cheap_s", [0.1, 10.0, 50.0, 90.0])
def test_a_control_variate_pays_from_where_it_costs_the_same(cheap_s: float) -> None:
    levels = Levels(OTHER, DEAR, cheap_s, 100.0)
    alone = levels.dear_error(1e4)
    assert levels.controlled_error(1e4, levels.pays_from) == pytest.approx(alone)
    assert levels.controlled_error(1e4, 0.99 * levels.pays_from) > alone
    assert levels.controlled_error(1e4, 0.5 * (1 + levels.pays_from)) < alone


def test_two_levels_divide_the_time_at_its_best() -> None:
    """Every other division of the time leaves a larger error."""
    levels = Levels(OTHER, DEAR, 20.0, 100.0)
    variances = OTHER.var(ddof=1), (DEAR - OTHER).var(ddof=1)
    errors = [
        np.sqrt(variances[0] * 20.0 / (share * 1e4) + variances[1] * 120.0 / ((1 - share) * 1e4))
        for share in np.linspace(0.01, 0.99, 99)
    ]
    assert levels.two_level_error(1e4) == pytest.approx(min(errors), rel=1e-3)


def test_the_interval_of_a_correlation_is_that_of_fisher() -> None:
    """Half as wide in z with four times as many pairs less three; of ten pairs it is 0.74."""
    low, high = Levels(OTHER, DEAR, 1.0, 1.0).interval
    assert np.arctanh(high) - np.arctanh(low) == pytest.approx(2 * 1.96 / np.sqrt(7))


def test_parts_have_the_efficiency_of_the_whole(tmp_path: Path) -> None:
    """In every cycle five of five fines of 2 mm pass, two of three of 2.8 mm, and none of two coarse ones."""
    with RunReader(folder_of(tmp_path)) as run:
        whole, halves = (efficiencies(run, run.end_s / 2, None, parts) for parts in (1, 2))
    fine, middle, _ = MASS_KG
    passes = 100 * (5 * fine + 2 * middle) / (5 * fine + 3 * middle)
    assert whole == pytest.approx([passes], rel=1e-6)
    assert halves == pytest.approx([passes, passes], rel=1e-6)


def test_independent_parts_tell_the_chance_of_the_whole() -> None:
    parts = [DRAW.normal(30.0, 6.0, 4) for _ in range(2000)]
    assert chance_of_whole(parts) == pytest.approx(3.0, rel=0.03)
