"""The table and the picture of a sweep: what each column says, and what is drawn as data."""

from __future__ import annotations

import csv
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import matplotlib.image
import numpy as np
import pytest

from orchestrator.output.records.summary import write_summary
from orchestrator.studies import sweep
from orchestrator.studies.points import Vary
from orchestrator.workbench import Run

VARY = Vary("screen.exciters.shaft.speed_rad_per_s", ("58", "78", "98", "118"))
RESULTS: dict[str, Any] = {
    "missing": {"orbits": "the case has no frames"},
    "failed": {},
    "steady": {"is_steady": True, "reason": ""},
    "screening": {
        "efficiency_percent": {"value": 80.0, "half_width": 1.5, "batches": 20},
        "recovered_percent": {"value": None, "half_width": None, "batches": 0},
        "particles": 22,
        "sections": [{"exit": "one", "yield_percent": {"value": 7.0, "half_width": None, "batches": 3}}],
        "in_time": {"time_s": [0.1, 0.2]},
    },
    "bed": {"velocity_m_per_s": {"value": 0.4, "half_width": 0.1, "batches": 20}},
}


def point(place: Path, value: str, status: str, results: Any = RESULTS) -> Any:
    folder = place / value
    folder.mkdir()
    write_summary(folder, {**{"status": status, "results": results}, "cycle_s": 2 * np.pi / 78.5})
    return SimpleNamespace(value=value, folder=folder, run=Run(folder))


def orbit(along_m: float, width_m: float | None = None) -> dict[str, Any]:
    width = None if width_m is None else [width_m, 0.0, width_m]
    return {"amplitude_m": [along_m, 0.0, 2 * along_m], "half_width_m": width}


def moving(drift: float, is_settled: bool) -> dict[str, Any]:
    motion = {"is_settled": is_settled, "drift": drift, "relative": {"b-a": orbit(1e-3)}}
    return RESULTS | {"motion": motion | {"frames": {"a": orbit(1e-3, 1e-5), "b": orbit(2e-3)}}}


@pytest.fixture
def points(tmp_path: Path) -> list[Any]:
    """One that is good, one that still drifts by 43 %, one not to be trusted, and a failed one."""
    states = ("done", "done", "doubtful", "failed")
    results = (moving(0.01, True), moving(0.43, False), moving(0.01, True), RESULTS)
    return [point(tmp_path, *values) for values in zip(VARY.values, states, results, strict=True)]


def test_a_measured_figure_does_not_overwrite_the_swept_value(points: list[Any]) -> None:
    """Both columns end with speed_rad_per_s."""
    table = sweep.sweep_rows(VARY, points)
    assert [row[VARY.key] for row in table] == ["58", "78", "98", "118"]
    assert table[0]["speed_rad_per_s"] == 78.5
    assert table[3] == {VARY.key: "118", "status": "failed"}


def test_every_single_result_is_there_with_its_interval(points: list[Any], tmp_path: Path) -> None:
    file = sweep.write_sweep(VARY, points, tmp_path)[0]
    row = next(csv.DictReader(file.read_text().splitlines()))
    assert float(row["screening.efficiency_percent"]) == 80.0
    assert float(row["screening.efficiency_percent.half_width"]) == 1.5
    assert float(row["screening.particles"]) == 22
    assert float(row["screening.sections.one.yield_percent"]) == 7.0
    assert float(row["motion.frames.a.amplitude_m.z"]) == float(row["a.z_m"]) == 2e-3
    assert float(row["a.x_m.half_width"]) == 1e-5
    assert "screening.recovered_percent" not in row, "a value that is not known is none"
    assert not [name for name in row if "in_time" in name]


def test_what_has_not_settled_says_so(points: list[Any], tmp_path: Path) -> None:
    assert [row.get("settled") for row in sweep.sweep_rows(VARY, points)] == ["yes", "no", "yes", None]


def test_without_frames_there_are_the_results(tmp_path: Path) -> None:
    points = [point(tmp_path, value, "done") for value in VARY.values]
    rows = sweep.sweep_rows(VARY, points)
    assert {row["settled"] for row in rows} == {"unknown: the case has no frames"}
    files = sweep.write_sweep(VARY, points, tmp_path)
    assert [file.name for file in files] == ["sweep.csv", "sweep.png"]


def test_only_good_points_are_drawn_as_data(points: list[Any], tmp_path: Path) -> None:
    table = sweep.sweep_rows(VARY, points)
    for column, kinds in (
        ("a.x_m", ["good", "open", "cross"]),
        ("bed.velocity_m_per_s", ["good", "good", "cross"]),
    ):
        assert [sweep._look(row, column) for row in table[:3]] == kinds
    picture = sweep.write_sweep(VARY, points, tmp_path)[1]
    pixels = matplotlib.image.imread(picture)[..., :3]
    assert 0.01 < (np.abs(pixels - pixels[0, 0]).max(axis=-1) > 0.1).mean() < 0.9
