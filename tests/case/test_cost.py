"""The cost that ``flipflow check`` predicts, against counts done by hand."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from orchestrator.bed.cost import THICK, cost
from orchestrator.bed.particle_step import particle_step_s
from orchestrator.casefile.levels import load
from tests.case.cases import CASE, written

FEED = """
[screen.exits.under]
product = "undersize"
box_m = [[-0.5, -0.5, -0.9], [0.5, 0.5, -0.3]]

[bed.feeds.coal]
material = "coal"
rate_kg_s = 0.2
box_m = [[0.0, 0.0, 0.2], [0.3, 0.2, 0.4]]
velocity_m_s = [0.0, 0.0, -0.5]
start_s = 0.5
sizes = [
  { smallest_m = 0.004, largest_m = 0.004, mass_fraction = 0.25 },
  { smallest_m = 0.008, largest_m = 0.008, mass_fraction = 0.75 },
]
"""
STAY_S = 0.302 / THICK.transport_m_s  # the panel is pulled 2 mm longer than it is
DURATION_S = 4.0


def sphere_kg(diameter_m: float) -> float:
    return 1430.0 * math.pi / 6 * diameter_m**3


def test_a_feed_fills_the_deck_until_as_much_leaves(tmp_path: Path) -> None:
    """0.05 and 0.15 kg/s of two sizes; each stays 0.302 m / (0.34 m/s)."""
    case = load(written(tmp_path, CASE + FEED), None, [f"duration_s={DURATION_S}"]).case
    found = cost(case, 0, THICK)
    rate = 0.05 / sphere_kg(0.004) + 0.15 / sphere_kg(0.008)
    assert found.most == pytest.approx(rate * STAY_S, rel=1e-9)
    filling, full = STAY_S, DURATION_S - 0.5 - STAY_S
    wanted = rate * STAY_S * (filling / 2 + full) / DURATION_S
    assert found.mean == pytest.approx(wanted, rel=1e-3)
    assert found.steps == math.ceil(DURATION_S / particle_step_s(case))
    assert found.processor_s == pytest.approx(THICK.particle_step_s * found.mean * found.steps)


def test_who_is_there_at_the_start_leaves_where_there_are_exits(tmp_path: Path) -> None:
    sets = [f"duration_s={DURATION_S}", "bed.feeds.coal.start_s=3.9999"]
    leaving = cost(load(written(tmp_path / "one", CASE + FEED), None, sets).case, 1000, THICK)
    assert leaving.most == 1000
    assert leaving.mean == pytest.approx(1000 * STAY_S / DURATION_S, rel=2e-3)
    assert cost(load(written(tmp_path / "two"), None, []).case, 1000, THICK).mean == 1000
