"""A toy deck with openings 6 mm deep, run as a case runs: balls strike the walls inside of the openings."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from orchestrator.ports import Array
from tests.cases import load_case
from tests.coupled.machines import Coupled, opened
from tests.coupled.screen import EXCITER, MACHINE

DEPTH_M = 0.006
BALL_KG = 1430.0 * np.pi / 6 * 0.006**3
OPENINGS = """
[screen.panels.deck.apertures]
length_m = 0.018
width_m = 0.012
pitch_along_m = 0.025
pitch_across_m = 0.025
margin_along_m = 0.0125
rims = "deep"
depth_m = 0.006
"""
BALLS = [
    f"bed.particles.ball-{i}-{j}={{position_m=[{1.01 * (0.05 + 0.025 * i)}, {0.0375 + 0.025 * j}, 0.0], "
    f"velocity_m_per_s=[{0.4 - 0.8 * j}, {0.5 - 1.0 * i}, 0.0], sieve_size_m=0.006, "
    'axes="deck", material="coal"}'
    for i in range(2)
    for j in range(2)
]


def depth_m(run: Coupled) -> Array:
    """Distances (pairs,) between the upper and lower point of each pair on the first panel."""
    panel = run.machine.panels[0]
    places_m = run.state.panel.surface.position_m[panel.surface]
    line = panel.centre_line - panel.surface.start
    lower = line[-1] + 1  # the upper side, the line and the lower side follow one another
    return np.linalg.norm(places_m[: line[0]] - places_m[lower : lower + line[0]], axis=1)


@pytest.mark.parametrize("solver", ["rigid", "strip"])
def test_balls_strike_the_walls_of_openings_and_the_books_close(tmp_path: Path, solver: str) -> None:
    """Four balls bounce for 20 ms between the walls of four openings while the deck is shaken.  Momentum
    crosses to rounding, angular momentum but for what a mean load leaves out.  The walls keep their depth.
    On a rigid panel, which makes no energy itself, the mapping makes less than 1e-6 of what the balls had."""
    settings = [f"panel.solver={solver}", "frames.solver=planar", "particles.solver=spheres"]
    with opened(load_case(tmp_path, MACHINE + EXCITER + OPENINGS, [*BALLS, *settings])) as run:
        struck_N_s = np.zeros(3)
        for _ in range(400):
            struck_N_s += run.interval_s * np.abs(run.advance(1).load.force_N).sum(axis=0)
        assert struck_N_s[:2].min() > 2 * BALL_KG * 0.4
        assert max(run.momentum_residual().values()) < 1e-11
        angular = run.angular_momentum_residual()
        assert angular["particles"] < 1e-11
        assert angular["particles-panel"] < 1e-5
        assert depth_m(run) == pytest.approx(np.full(len(depth_m(run)), DEPTH_M), abs=1e-12)
        if solver == "rigid":
            assert abs(run.energy_J("defect")["defect.panel"]) < 1e-6 * 4 * BALL_KG * 0.64**2 / 2
