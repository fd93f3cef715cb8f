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
    ("name", "by_hand"),
    [
        ("fine_placement", 30 / 40),
        ("coarse_placement", 57 / 60),
        ("efficiency", 0.75 + 0.95 - 1),
        ("misplaced", 13 / 100),
        ("fines_in_oversize", 10 / 67),
        ("oversize_yield", 67 / 100),
    ],
)
def test_the_whole_deck(name: str, by_hand: float) -> None:
    assert placement.placements(OUT, EXITS)[name] == pytest.approx(by_hand, rel=1e-14)


def test_sections() -> None:
    first, second = (placement.section_shares(OUT, SECTIONS, place) for place in (0, 1))
    assert second["yield"] == pytest.approx(0.12)
    assert first["cumulative_efficiency"] == first["local_efficiency"] == pytest.approx(20 / 40)
    assert second["cumulative_efficiency"] == pytest.approx(30 / 40)
    assert second["local_efficiency"] == pytest.approx(10 / 20)


def test_hancock() -> None:
    """The efficiency by yields and assays (Hancock): gamma (b - a) / (a (1 - a)), with fines a
    in the feed and b in the undersize, is the same number."""
    a, b, gamma = 0.40, 30 / 33, 0.33
    assert placement.placements(OUT, EXITS)["efficiency"] == pytest.approx(gamma * (b - a) / (a * (1 - a)))


def test_a_splitter_and_a_perfect_screen() -> None:
    assert placement.placements(np.array([[1.0, 3.0], [0, 0], [2.0, 6.0]]), EXITS)["efficiency"] == (
        pytest.approx(0.0, abs=1e-15)
    )
    assert placement.placements(np.array([[4.0, 0.0], [1.0, 0.0], [0.0, 5.0]]), EXITS)["efficiency"] == 1.0


def test_without_coarse_particles_the_efficiency_is_the_share_of_fines_that_passed() -> None:
    """20 and 10 of 40 kg of fines pass, and nothing is misplaced but the fines that stay."""
    out_kg = OUT * [1.0, 0.0]
    shares = placement.placements(out_kg, EXITS)
    assert shares["efficiency"] == shares["fine_placement"] == pytest.approx(0.75, rel=1e-14)
    assert np.isnan(shares["coarse_placement"])
    mass_kg, group = np.ones(40), np.repeat([0, 2, 4], [20, 10, 10])
    chance = placement.counting_deviations(mass_kg, group, EXITS)
    assert chance["efficiency"] == chance["fine_placement"] == pytest.approx((0.75 * 0.25 / 40) ** 0.5)


def test_without_fines_there_is_no_placement_of_fines() -> None:
    assert np.isnan(placement.placements(np.array([[0.0, 1.0]] * 3), EXITS)["fine_placement"])


def test_the_cut_size_itself_is_coarse() -> None:
    assert placement.fine_or_coarse(np.array([0.0029, 0.003, 0.0031]), 0.003).tolist() == [0, 1, 1]
