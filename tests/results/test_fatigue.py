"""Rainflow counting and the rank of panels by the user's line."""

from __future__ import annotations

import pytest

from orchestrator.case.tables.case import FatigueLine
from orchestrator.output.results.fatigue import damage, rainflow, ranked


def test_example_of_the_standard() -> None:
    """ASTM E1049-85, figure 6: 0.5 of range 3, 1.5 of 4, 0.5 of 6, 1 of 8 and 0.5 of 9."""
    counts: dict[float, float] = {}
    for size, count in rainflow([-2, 1, -3, 5, -1, 3, -4, 4, -2]):
        counts[size] = counts.get(size, 0.0) + count
    assert counts == {3: 0.5, 4: 1.5, 6: 0.5, 8: 1.0, 9: 0.5}


def test_points_between_turns_and_repeated_values_count_not() -> None:
    assert rainflow([0, 1, 1, 2, 0]) == [(2, 0.5), (2, 0.5)] == rainflow([0, 2, 0])
    assert rainflow([]) == rainflow([1.0]) == []


def test_damage_by_miner() -> None:
    """Ranges of 4 % are amplitudes of 2 %, at half of the line's amplitude of 4 %: 2^5 times the cycles."""
    line = FatigueLine(strain_amplitude=0.04, cycles=1e6, slope=5.0)
    assert damage([(0.04, 1.0), (0.08, 0.5)], line) == pytest.approx(1e-6 * (1 / 32 + 0.5))


def test_rank_is_over_the_worst() -> None:
    assert ranked({"a": 2e-6, "b": 1e-6, "c": None}) == {"a": 1.0, "b": 0.5, "c": None}
