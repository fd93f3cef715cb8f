"""The ladder's predictions against what rungs have taken: the tables of docs/measured/model_hierarchy.md."""

from __future__ import annotations

import re
from collections.abc import Iterator

import pytest

from orchestrator.preflight.cost import particles_at_start, predicted_parts_s, predicted_s
from orchestrator.preflight.levels import load
from orchestrator.studies.ladder.rungs import LADDERS, rungs
from tests.runs.outside import ROOT

GOOD_TO = 3.0  # a factor, as cost.py says; busy machines differ by as much
TEXT = (ROOT / "docs/measured/model_hierarchy.md").read_text(encoding="utf-8")


def tables() -> Iterator[tuple[str, str, dict[tuple[str, str], float]]]:
    """Case, duration, and processor time in s by ladder and rung."""
    for part in TEXT.split("`flipflow ladder cases/")[1:]:
        command = re.match(r"(\S+) --duration ([\d.]+)", part)
        assert command is not None
        rows = [re.split(r" ?\| ?", line.strip("| ")) for line in part.splitlines() if "|" in line]
        header, _, *body = rows
        column = header.index("processor s")
        taken = {(row[0], row[1]): float(row[column]) for row in body if len(row) == len(header)}
        yield command[1], command[2], taken


TABLES = list(tables())


@pytest.mark.parametrize(("case", "duration", "taken"), TABLES, ids=[row[0] for row in TABLES])
def test_predictions_are_good_to_a_factor_of_three(
    case: str, duration: str, taken: dict[tuple[str, str], float]
) -> None:
    base = load(ROOT / "cases" / case, "default", [f"duration_s={duration}"]).case
    compared = 0
    for ladder in LADDERS:
        for rung in rungs(base, ladder):
            measured_s = taken.get((ladder, rung.name))
            if measured_s is not None and not rung.needs:
                sets = [f"duration_s={duration}", *rung.sets]
                found = load(ROOT / "cases" / case, "default", sets).case
                said_s = predicted_s(found, particles_at_start(found))
                assert measured_s / GOOD_TO < said_s < measured_s * GOOD_TO, (ladder, rung.name)
                compared += 1
    assert compared >= 5


def test_what_makes_a_run_dear() -> None:
    """Twice the time costs twice as much but for the start; particles and panels add to it, and the
    steps of a sheet go with the third power of its cells (their number, and the step)."""

    def of(*sets: str, at_start: int = 0) -> float:
        return predicted_s(load(ROOT / "cases/quickstart", "default", sets).case, at_start)

    def of_panels(*sets: str) -> float:
        case = load(ROOT / "cases/quickstart", "default", [*sets, "particles.solver=none"]).case
        return predicted_parts_s(case, 0)["panel"]

    half, whole = of("duration_s=0.25"), of("duration_s=0.5")
    nothing_s = 2 * half - whole
    assert 0.0 < nothing_s < half
    assert of(at_start=10_000) - whole == pytest.approx(2 * (of(at_start=5_000) - whole))
    cells = [of_panels(f"panel.cells=[{22 * n}, {4 * n}]") for n in (1, 2, 3)]
    assert cells[0] == pytest.approx(of_panels())
    assert (cells[2] - cells[0]) / (cells[1] - cells[0]) == pytest.approx(26 / 7)
