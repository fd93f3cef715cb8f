"""Predictions against what runs have taken: docs/measured/cost.csv."""

from __future__ import annotations

import csv

import pytest

from orchestrator.preflight.cost import predicted_parts_s, predicted_s
from orchestrator.preflight.judge import load_judged
from tests.runs.outside import ROOT
from tools.cost_series import predict, runs_by_name

GOOD_TO = 3.0  # a factor, as cost.py says; busy machines differ by as much


def taken_s() -> dict[str, float]:
    """Return the measured processor time of each run in the table."""
    with (ROOT / "docs/measured/cost.csv").open(newline="", encoding="utf-8") as file:
        return {row["run"]: float(row["measured / s"]) for row in csv.DictReader(file)}


def test_the_table_has_every_run() -> None:
    assert list(taken_s()) == list(runs_by_name())


@pytest.mark.parametrize(("name", "measured_s"), taken_s().items(), ids=list(taken_s()))
def test_predictions_are_good_to_a_factor_of_three(name: str, measured_s: float) -> None:
    for predicted_by_part_s in predict(name):  # a thin bed and a thick one
        assert measured_s / GOOD_TO < sum(predicted_by_part_s.values()) < measured_s * GOOD_TO


def test_what_makes_a_run_dear() -> None:
    """A run of twice the time costs twice as much but for the start; particles and panels add to it, and
    the steps of a sheet go with the third power of its cells (their number, and the step)."""

    def of(*sets: str, at_start: int = 0) -> float:
        return predicted_s(load_judged(ROOT / "cases/quickstart", "default", sets).case, at_start)

    def of_panels(*sets: str) -> float:
        case = load_judged(ROOT / "cases/quickstart", "default", [*sets, "particles.solver=none"]).case
        return predicted_parts_s(case, 0)["panel"]

    half, whole = of("duration_s=0.25"), of("duration_s=0.5")
    nothing_s = 2 * half - whole
    assert 0.0 < nothing_s < half
    assert of(at_start=10_000) - whole == pytest.approx(2 * (of(at_start=5_000) - whole))
    cells = [of_panels(f"panel.cells=[{22 * n}, {4 * n}]") for n in (1, 2, 3)]
    assert cells[0] == pytest.approx(of_panels())
    assert (cells[2] - cells[0]) / (cells[1] - cells[0]) == pytest.approx(26 / 7)
