"""The errors of the headline figures in ``summary.json``, on the console and on the page."""

from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any

import pytest

from orchestrator.figures.accuracy import Accuracy, KnownError
from orchestrator.figures.figure import to_json
from orchestrator.output.report.errors import PASSED, UNKNOWN, closing_line, error_of, errors_table
from orchestrator.output.report.page import Film, page
from orchestrator.output.results.compute import compute_results
from tests.results.synthetic import folder_of

VELOCITY, LOAD = "results.bed.velocity_m_per_s", "results.bed.load_kg_per_m2"
FOUND = Accuracy(
    "measured",
    "by a study of this case with these settings",
    "runs/x-accuracy/accuracy.json",
    0.1,
    0.004,
    0.03,
    {"velocity_m_per_s": KnownError(0.012, 0.03, 0.004), "deflection_m": KnownError(0.05, None, None)},
)
NOTHING = Accuracy("not known", "no study of this case and level", command="flipflow study accuracy x")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return folder_of(tmp_path_factory.mktemp("errors") / "run")


@pytest.fixture(scope="module")
def summary(folder: Path) -> dict[str, Any]:
    table: dict[str, Any] = json.loads((folder / "summary.json").read_text())
    return table | {"results": to_json(compute_results(folder))}


def told(summary: dict[str, Any], accuracy: Accuracy, **changes: Any) -> dict[str, Any]:
    changed = copy.deepcopy(summary) | changes
    return changed | {"accuracy": errors_table(accuracy, changed)}


@pytest.mark.parametrize(("simulated_s", "is_told"), [(0.1, False), (0.105, False), (10.0, True)])
def test_a_study_of_another_duration_tells_its_own(
    summary: dict[str, Any], simulated_s: float, is_told: bool
) -> None:
    line = closing_line(told(summary, FOUND, simulated_s=simulated_s))
    assert ("whose runs lasted" in line) == is_told


def test_a_figure_has_the_error_of_the_quantity_that_it_is(summary: dict[str, Any]) -> None:
    """Nobody compares loads; the interval by the run's own statistics stands beside."""
    with_errors = told(summary, FOUND)
    figures = with_errors["accuracy"]["figures"]
    velocity, load = figures[VELOCITY], figures[LOAD]
    assert (velocity["quantity"], velocity["error"], velocity["error_half_width"]) == (
        "velocity_m_per_s",
        0.012,
        0.03,
    )
    measured = summary["results"]["bed"]["velocity_m_per_s"]
    assert velocity["interval"] == pytest.approx(measured["half_width"] / measured["value"])
    assert (load["quantity"], load["error"]) == (None, None)
    assert error_of(with_errors, VELOCITY) == "error 1.2 % ± 3.0 %, measured"
    assert error_of(with_errors, LOAD) == UNKNOWN
    assert json.loads(json.dumps(with_errors["accuracy"])) == with_errors["accuracy"]


def test_quantities_of_several_panels_are_no_figure_of_one(summary: dict[str, Any]) -> None:
    """Probes on two panels differ, so that their mean is the figure of neither."""
    changed = copy.deepcopy(summary)
    points = changed["results"]["motion"]["panel_points"]
    first = next(iter(points))
    points[first]["rms_g"]["value"] *= 1.5
    quantities = {
        path: figure["quantity"] for path, figure in errors_table(FOUND, changed)["figures"].items()
    }
    assert quantities[f"results.motion.panel_points.{first}.rms_g"] is None
    assert list(quantities.values()).count("power_W") == 1


def test_a_bound_that_was_passed_is_told_in_place_of_an_error(summary: dict[str, Any]) -> None:
    item = {"worst": 0.2, "limit": 0.1, "times": 3, "first_s": 0.01}
    calm = item | {"times": 0, "first_s": None}
    for changes in (
        {"monitor": {"figures": {"long_steps": item, "deep_overlaps": calm}}},
        {"doubts": ["why"]},
    ):
        table = told(summary, FOUND, **changes)
        assert all(figure["error"] is None for figure in table["accuracy"]["figures"].values())
        assert len(table["accuracy"]["passed"]) == 1
        assert table["accuracy"]["passed"][0] in closing_line(table)
        assert error_of(table, VELOCITY) == PASSED


def test_one_line_where_nothing_is_known(summary: dict[str, Any]) -> None:
    table = told(summary, NOTHING)
    assert NOTHING.command in closing_line(table)
    assert error_of(table, VELOCITY) == ""
    assert not any(figure["error"] for figure in table["accuracy"]["figures"].values())


def test_the_page_is_made_from_the_summary(folder: Path, summary: dict[str, Any]) -> None:
    """Again and again, and also of a run of a version that knew of no errors."""
    own = (folder / "summary.json").read_text()
    try:
        for accuracy, words in (
            (FOUND, "error 1.2 % ± 3.0 %, measured"),
            (NOTHING, NOTHING.command),
            (None, ""),
        ):
            table = told(summary, accuracy) if accuracy else summary
            (folder / "summary.json").write_text(json.dumps(table))
            html = page(folder, compute_results(folder), lambda run, lasting_s: Film(b""))
            assert words in html
            assert (UNKNOWN in html) == (accuracy is FOUND)
    finally:
        (folder / "summary.json").write_text(own)
