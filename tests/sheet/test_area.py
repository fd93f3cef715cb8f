"""The areas of the VSMA handbook's worked example, and what moves them."""

import math

import pytest

from orchestrator.preflight.sheet.area import INCH_M, STANDARD_KG_PER_M3, Openings, required_m2
from orchestrator.preflight.sheet.feed_shares import FeedShares

SHORT_TON_PER_H = 907.18474 / 3600
FT2 = 0.3048**2


# "Factors for calculating screen area": 300 short tons an hour of 100 lb/ft3 over three decks.  The feed of
# each deck is what passes the one above; 85, 60, 30 and 15 % of the whole are finer than 1, 1/2, 1/4 and 1/8
# inch.  The handbook rounds up, to 48, 93 and 111 square feet.
@pytest.mark.parametrize(
    ("inch", "open_share", "fed", "passing", "half", "efficiency", "deck", "feet2", "printed"),
    [
        (1.0, 0.64, 300, 255, 180, 0.95, 1.0, 47.37, 48),
        (0.5, 0.54, 255, 180, 90, 0.95, 0.9, 92.65, 93),
        (0.25, 0.46, 180, 90, 45, 0.90, 0.8, 110.6, 111),
    ],
)
def test_worked_example(
    inch: float,
    open_share: float,
    fed: float,
    passing: float,
    half: float,
    efficiency: float,
    deck: float,
    feet2: float,
    printed: int,
) -> None:
    shares = FeedShares(1 - passing / fed, half / fed, math.nan)
    square = Openings(inch * INCH_M, inch * INCH_M, open_share)
    found_m2 = required_m2(fed * SHORT_TON_PER_H, square, shares, STANDARD_KG_PER_M3, efficiency)
    assert found_m2 is not None
    feet2_found = found_m2 / deck / FT2  # factor D of lower decks is not in the program
    assert feet2_found == pytest.approx(feet2, rel=1e-3)
    assert math.ceil(feet2_found) == printed


def test_slots_and_efficiency() -> None:
    shares = FeedShares(0.25, 0.4, 0.2)

    def area_m2(along_m: float, efficiency: float = 0.95) -> float:
        size_m2 = required_m2(10.0, Openings(0.006, along_m, 0.4), shares, 1600.0, efficiency)
        assert size_m2 is not None
        return size_m2

    square = area_m2(0.006)
    assert area_m2(0.018) == pytest.approx(square / 1.15)
    assert area_m2(0.024) == pytest.approx(square / 1.15)
    assert area_m2(0.03) == pytest.approx(square / 1.25)
    assert area_m2(0.006, 0.8) == pytest.approx(square / 1.5)


def test_no_area_beyond_the_table() -> None:
    assert required_m2(1.0, Openings(5e-4, 5e-4, 0.3), FeedShares(0.5, 0.2, 0.2), 1600.0, 0.9) is None
