"""The files that a study of a table writes, held to docs/run-folder.md."""

from __future__ import annotations

import csv
import json
import re
import shutil
from pathlib import Path

import pytest

from orchestrator.studies.design.study import DesignStudy
from orchestrator.studies.design.study_file import read_study
from orchestrator.studies.points import Crew

ROOT = Path(__file__).parents[2]
STUDIES = ROOT / "cases/ffs0827-effects/studies"
SECTION = (ROOT / "docs/run-folder.md").read_text(encoding="utf-8").split("### Design studies\n")[1]


def documented(table: str) -> set[str]:
    """Return the words in backticks in the first column of a table of the section."""
    lines = SECTION.split(f"|{table}|", 1)[1].split("\n\n")[0].splitlines()
    return {word for line in lines for word in re.findall(r"`([^`]+)`", line.split("|")[1 if line else 0])}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the study of Table 5."""
    place = tmp_path_factory.mktemp("study")
    text = (STUDIES / "table5.toml").read_text(encoding="utf-8")
    (place / "table5.toml").write_text(text, encoding="utf-8")
    shutil.copy(STUDIES / "table5.csv", place)
    study = DesignStudy(read_study(place / "table5.toml"), Crew(), place / "out")
    study.load_finished()
    list(study.write())
    return place / "out"


@pytest.mark.slow
def test_the_manual_lists_the_columns_of_points(folder: Path) -> None:
    study = read_study(folder / "study.toml").file
    with (folder / "points.csv").open(encoding="utf-8") as file:
        columns = set(next(csv.reader(file))) - study.factors.keys()
    for name in study.responses:
        columns = {column.replace(name, "<response>") for column in columns}
    predicted = {"<response> predicted", "<response> predicted half width"}  # only runs have them
    assert columns == documented("column of `points.csv` |meaning") - predicted


@pytest.mark.slow
def test_the_manual_lists_the_keys_of_the_fit(folder: Path) -> None:
    fit = json.loads((folder / "fit.json").read_text(encoding="utf-8"))
    assert fit.keys() == documented("key of `fit.json` |meaning")


@pytest.mark.slow
def test_the_manual_lists_the_files(folder: Path) -> None:
    assert {file.name for file in folder.iterdir()} <= set(re.findall(r"`([^`]+)`", SECTION))
