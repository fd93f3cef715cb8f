"""Efficiencies of a hand-made mass balance.

            fine  coarse          feed 40 fine + 60 coarse = 100 kg
section 1     20       1
section 2     10       2          undersize 33 kg, oversize 67 kg
oversize      10      57
"""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator.output.results import screening as placement
from orchestrator.output.results.events import Exits

EXITS = Exits(("one", "two", "end"), ("undersize", "undersize", "oversize"))
OUT = np.array([[20.0, 1.0], [10.0, 2.0], [10.0, 57.0]])
SECTIONS = EXITS.of("undersize")


@pytest.mark.parametrize(
    ("figure", "by_hand"),
    [
        (placement.fine_placement, 30 / 40),
        (placement.coarse_placement, 57 / 60),
        (placement.efficiency, 0.75 + 0.95 - 1),
        (placement.misplaced, 13 / 100),
        (placement.fines_in_oversize, 10 / 67),
        (placement.oversize_yield, 67 / 100),
    ],
)
def test_the_whole_deck(figure: object, by_hand: float) -> None:
    assert callable(figure)
    assert figure(OUT, EXITS) == pytest.approx(by_hand, rel=1e-14)


def test_sections() -> None:
    assert placement.section_yield(OUT, 1) == pytest.approx(0.12)
    assert placement.cumulative_efficiency(OUT, SECTIONS, 0) == pytest.approx(20 / 40)
    assert placement.cumulative_efficiency(OUT, SECTIONS, 1) == pytest.approx(30 / 40)
    assert placement.local_efficiency(OUT, SECTIONS, 0) == pytest.approx(20 / 40)
    assert placement.local_efficiency(OUT, SECTIONS, 1) == pytest.approx(10 / 20)


def test_hancock() -> None:
    """The efficiency by yields and assays (Hancock): gamma (b - a) / (a (1 - a)), with fines a
    in the feed and b in the undersize, is the same number."""
    a, b, gamma = 0.40, 30 / 33, 0.33
    assert placement.efficiency(OUT, EXITS) == pytest.approx(gamma * (b - a) / (a * (1 - a)))


def test_a_splitter_and_a_perfect_screen() -> None:
    assert placement.efficiency(np.array([[1.0, 3.0], [0, 0], [2.0, 6.0]]), EXITS) == (
        pytest.approx(0.0, abs=1e-15)
    )
    assert placement.efficiency(np.array([[4.0, 0.0], [1.0, 0.0], [0.0, 5.0]]), EXITS) == 1.0


def test_without_fines_there_is_no_placement_of_fines() -> None:
    assert np.isnan(placement.fine_placement(np.array([[0.0, 1.0]] * 3), EXITS))


def test_the_cut_size_itself_is_coarse() -> None:
    assert placement.fine_or_coarse(np.array([0.0029, 0.003, 0.0031]), 0.003).tolist() == [0, 1, 1]
