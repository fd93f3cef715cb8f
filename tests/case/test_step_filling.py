"""The steps in a sync interval: they fill it, and what is proposed fills it."""

from __future__ import annotations

import pytest

from orchestrator.preflight.judge import load_judged
from orchestrator.preflight.step_filling import step_filling, step_filling_lines
from tests.runs.outside import ROOT

CHEAP = ["panel.solver=strip", "coupling.sync_interval_s=3.125e-5"]


def filled(*sets: str):
    case = load_judged(ROOT / "cases/quickstart", "default", [*CHEAP, *sets]).case
    return step_filling(case), list(step_filling_lines(case))


SHORT = "particles.rayleigh_fraction=0.15"


def test_quickstart_fills_its_interval_with_one_step() -> None:
    """The default allows 3.27e-5 s for a step of 3.125e-5 s."""
    filling, lines = filled()
    assert filling.steps == 1
    assert filling.share == pytest.approx(1.0)
    assert len(lines) == 1


def test_shorter_steps_take_two_thirds_of_what_is_allowed() -> None:
    """Two steps of 1.56e-5 s fill 3.125e-5 s; 2.45e-5 s are allowed."""
    filling, lines = filled(SHORT)
    assert filling.steps == 2
    assert filling.share == pytest.approx(0.64, abs=0.005)
    assert "2, each 64 % of the longest allowed" in lines[0]
    assert lines[1].strip() == (
        "full steps: coupling.sync_interval_s = 2.45e-05 (1) or 4.9e-05 (2), "
        "or particles.rayleigh_fraction = 0.191 (1)"
    )


@pytest.mark.parametrize(
    ("proposed", "steps"),
    [
        ("coupling.sync_interval_s=2.45e-5", 1),
        ("coupling.sync_interval_s=4.9e-5", 2),
        ("particles.rayleigh_fraction=0.191", 1),
    ],
)
def test_each_proposal_fills_the_interval(proposed: str, steps: int) -> None:
    filling, lines = filled(SHORT, proposed)
    assert filling.steps == steps
    assert 0.99 < filling.share <= 1.0 + 1e-9
    assert len(lines) == 1


def test_a_given_step_is_not_to_be_changed_by_the_fraction() -> None:
    _, lines = filled("particles.step_s=2e-5")
    assert "rayleigh_fraction" not in "".join(lines)
