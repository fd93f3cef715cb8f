"""A bed on a moving screen with openings: small ones fall through, large ones stay."""

from __future__ import annotations

from pathlib import Path

import pytest

from orchestrator.case.deck.panels import axes
from orchestrator.ports import Array
from orchestrator.preflight.check import find_problems
from orchestrator.preflight.judge import JudgedCase
from tests.cases import load_case
from tests.coupled.machines import opened
from tests.coupled.screen import CASE

pytestmark = pytest.mark.solver
OPENINGS = """
[screen.panels.deck.apertures]
length_m = 0.018
width_m = 0.007
pitch_along_m = 0.025
pitch_across_m = 0.010
margin_along_m = 0.02
[bed.blocks.fines]
material = "coal"
box_m = [[0.02, 0.005, 0.016], [0.13, 0.095, 0.030]]
count = 150
sizes = [{ smallest_m = 0.003, largest_m = 0.004, mass_fraction = 1.0 }]
velocity_m_per_s = [0.0, 0.0, -0.5]
"""


def over_the_deck_m(loaded: JudgedCase, position_m: Array) -> Array:
    """Height normal to the deck."""
    return position_m @ axes(loaded.case)[:, 2]


@pytest.mark.slow
@pytest.mark.parametrize("panel", ["strip", "sheet"])
def test_fines_fall_through_a_shaken_screen_and_the_books_close(tmp_path: Path, panel: str) -> None:
    """60 ms: of 150 fines some come out under the panels, through openings of 7 mm and past the
    large ones, of those of 8-11 mm none; momentum is handed over to rounding."""
    loaded = load_case(tmp_path, CASE + OPENINGS, [f"panel.solver={panel}"])
    assert find_problems(loaded) == []
    with opened(loaded) as machine:
        state = machine.advance(1200)
        now = machine.particles()
        residuals = machine.momentum_residual()
        assert max(residuals.values()) < 1e-11, residuals
        lowest_m = over_the_deck_m(loaded, state.panel.surface.position_m).min()
        below = over_the_deck_m(loaded, now.position_m) < lowest_m - now.grains.sieve_size_m
        small = now.grains.sieve_size_m < 0.006
        assert not below[~small].any()
        assert below[small].sum() > 5
        assert machine.machine.members.frames.received.impulse_N_s.any()
