"""The life of bearings."""

import math

import pytest

from orchestrator.preflight.sheet.bearings import rating_life_h


def test_a_million_turns_at_the_rating() -> None:
    assert rating_life_h(1e5, 1e5, 1000 * 2 * math.pi / 60) == pytest.approx(1e6 / (60 * 1000))


def test_ball_bearing_of_a_textbook() -> None:
    """C = 16 kN, P = 2 kN: 512 million turns (sarthaks.com/2642436)."""
    assert rating_life_h(16e3, 2e3, 100.0, exponent=3) * 3600 * 100.0 / (2 * math.pi) == pytest.approx(512e6)


def test_half_the_load_of_rollers() -> None:
    assert rating_life_h(1e5, 1e4, 80.0) / rating_life_h(1e5, 2e4, 80.0) == pytest.approx(2 ** (10 / 3))
