"""The layers of a study of accuracy: marks, their table and picture, and scenes."""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from orchestrator.case.file.errors import CaseError
from orchestrator.studies.accuracy.combinations import StudyRequest
from orchestrator.studies.accuracy.layers import (
    CHANCE,
    FILE,
    LOST,
    MODEL,
    NUMERICS,
    Mark,
    marks_of,
    read_marks,
    scenes_of,
)
from orchestrator.studies.accuracy.report import write_layers
from orchestrator.studies.accuracy.scenes import Scene, find_scenes
from orchestrator.studies.points import CaseStudy, Crew
from tests.accuracy.test_study import made
from tests.runs.outside import ROOT, flipflow

BALL = Mark("ball", NUMERICS, "panel mesh", "strip, 22 cells", s_per_s=3.0, start_s=1.0, error=1e-2)
MARKS = [
    replace(BALL, is_own=True),
    replace(BALL, label="strip, 44 cells", s_per_s=9.0, error=2.5e-3),
    replace(BALL, label="strip, 88 cells", s_per_s=30.0, error=6e-4, half_width=1e-3),
    Mark("ball", MODEL, "panel model", "sheet, 22 x 8 cells", error=0.03, of="deflection_m"),
    Mark("ball", LOST, "no result", "serial-staggered, 0.0002 s", status="doubtful", s_per_s=2.0),
    replace(BALL, scene="machine", half_width=0.0, error=1e-4),
    Mark("machine", CHANCE, "chance", "chance, 3 seeds", error=0.02, of="velocity_m_per_s"),
]


def test_marks_come_back_from_their_table_as_they_were(tmp_path: Path) -> None:
    table, picture = write_layers(MARKS, tmp_path)
    assert read_marks(table) == MARKS
    assert [*scenes_of(MARKS)] == ["ball", "machine"]
    assert picture.name == "layers.png"


def test_a_difference_within_its_interval_is_chance() -> None:
    assert [mark.is_chance for mark in MARKS] == [False, False, True, False, False, False, False]


def test_the_picture_has_every_mark_in_its_place(tmp_path: Path) -> None:
    """Without the crosses of lost runs, some red is gone; without the bands, some black is."""

    def pixels(marks: list[Mark]) -> np.ndarray:
        _, picture = write_layers(marks, tmp_path)
        with Image.open(picture) as image:
            return np.asarray(image.convert("RGB")).astype(int)

    def red(picture: np.ndarray) -> int:
        return int(((picture[..., 0] > 150) & (picture[..., 1:] < 110).all(axis=-1)).sum())

    whole = pixels(MARKS)
    without_crosses = pixels([mark for mark in MARKS if mark.layer != LOST])
    without_bands = pixels([mark for mark in MARKS if mark.layer not in (MODEL, CHANCE)])
    assert red(whole) > red(without_crosses)
    assert (whole < 60).all(axis=-1).sum() > (without_bands < 60).all(axis=-1).sum()


def test_a_table_without_a_column_says_which(tmp_path: Path) -> None:
    file = tmp_path / FILE
    file.write_text("scene,layer\nball,numerics\n", encoding="utf-8")
    with pytest.raises(CaseError, match="missing column") as told_all:
        read_marks(file)
    assert any("s_per_s" in problem.key for problem in told_all.value.problems)


def test_a_cell_that_is_no_number_is_named(tmp_path: Path) -> None:
    table, _ = write_layers(MARKS, tmp_path)
    rows = [*csv.reader(table.read_text(encoding="utf-8").splitlines())]
    rows[1][rows[0].index("error")] = "much"
    with table.open("w", encoding="utf-8", newline="") as text:
        csv.writer(text).writerows(rows)
    with pytest.raises(CaseError, match='"much" is not a number'):
        read_marks(table)


def test_every_mistake_in_the_files_of_scenes_is_told_at_once(tmp_path: Path) -> None:
    for name, text in {"a": 'title = "A"\npoints = 0\n', "b": 'titel = "B"\n'}.items():
        (tmp_path / name).mkdir()
        (tmp_path / name / "accuracy.toml").write_text(text, encoding="utf-8")
    with pytest.raises(CaseError) as told_all:
        [*find_scenes(CaseStudy(tmp_path))]
    words = str(told_all.value)
    assert all(
        word in words for word in ("points", "parameters", "titel", "a/accuracy.toml", "b/accuracy.toml")
    )


def test_a_quick_scene_differs_where_its_table_says_so() -> None:
    scene = Scene.model_validate(
        {"title": "A", "parameters": ["sync"], "quantities": ["deflection_m"], "points": 5, "seeds": 4}
        | {"quick": {"points": 3}}
    )
    assert (scene.sized(False).points, scene.sized(True).points, scene.sized(True).seeds) == (5, 3, 4)


@pytest.mark.process
def test_the_scenes_that_come_with_the_program_are_five(tmp_path: Path) -> None:
    done = flipflow("study", "accuracy", str(ROOT / "cases"), "--dry", "--out", str(tmp_path / "study"))
    assert done.returncode == 0
    titles = [line for line in done.stdout.splitlines() if line.endswith(":")]
    assert titles == [
        "Ball on a panel:",
        "Empty machine:",
        "Thick wet bed:",
        "Driven empty panel:",
        "Thin dry layer:",
    ]
    assert "not offered" not in done.stdout
    assert not (tmp_path / "study").exists()


@pytest.mark.process
def test_a_folder_without_scenes_ends_with_a_hint(tmp_path: Path) -> None:
    done = flipflow("study", "accuracy", str(tmp_path))
    assert done.returncode == 2
    assert "has no case with accuracy.toml" in done.stdout + done.stderr


@pytest.mark.slow
@pytest.mark.process
def test_a_study_that_keeps_its_model_draws_another_one_as_a_band(tmp_path: Path) -> None:
    """The finest strip is held against the finest sheet, and the reference stays a strip."""
    where = CaseStudy(ROOT / "cases/panel-cycle", "draft", ("duration_s=0.1",), tmp_path, Crew(2))
    parameters, judged_by = ("panel-mesh", "panel-model=sheet"), ("deflection_m",)
    asked = StudyRequest(where, parameters, 3, 1, 600.0, judged_by, keeps_model=True)
    kept, free = made(asked), made(replace(asked, keeps_model=False))
    assert "sheet" in free.measured[free.reference].label
    assert "sheet" not in kept.measured[kept.reference].label
    marks = marks_of(kept, "panel")
    mesh = [mark for mark in marks if mark.layer == NUMERICS]
    assert [mark.label for mark in mesh] == ["strip, 11 cells", "strip, 22 cells"]
    assert [mark.is_own for mark in mesh] == [False, True]
    (band,) = (mark for mark in marks if mark.layer == MODEL)
    names = ("panel-strip-44-cells", "panel-sheet-33-x-12-cells")
    finest, sheet = (kept.measured[name].mean("deflection_m") for name in names)
    assert finest
    assert sheet
    assert band.label == "strip, 44 cells"
    assert band.error == pytest.approx(abs(finest - sheet) / sheet)
    assert all(mark.s_per_s and mark.start_s for mark in mesh)
