"""The options of all studies refuse wrong words before anything is run or written."""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from orchestrator.cli.main import app, main
from tests.runs.outside import ROOT

EMPTY = str(ROOT / "cases/empty-machine")
VARY = ("--vary", "screen.exciters.shaft.speed_rad_per_s=58,84")


def refused(*words: str) -> str:
    """Return the message of a study that is refused."""
    done = CliRunner().invoke(app, ["study", *words], env={"COLUMNS": "400"})
    assert done.exit_code == 2, done.output
    return done.output


def test_an_address_of_no_scheduler_is_told(tmp_path: Path) -> None:
    message = refused("sweep", EMPTY, *VARY, "--scheduler", "nope", "--out", str(tmp_path / "out"))
    assert "--scheduler nope: missing port number in address 'nope'; for example tcp://host:8786" in message
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("file", ["case.toml", "accuracy.csv", "points.csv"])
def test_the_folder_of_something_else_is_refused(file: str, tmp_path: Path) -> None:
    (tmp_path / file).touch()
    message = refused("sweep", EMPTY, *VARY, "--out", str(tmp_path))
    assert f"has {file}, of a case, a run or another study; give another folder with --out" in message
    assert [each.name for each in tmp_path.iterdir()] == [file]


@pytest.mark.parametrize(
    ("words", "case"), [(("paper", "."), "crank-link-panel"), (("stability", "hard"), "hard/at-rest")]
)
def test_runs_do_not_go_into_the_folders_of_cases(
    words: tuple[str, str], case: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.copytree(ROOT / "cases" / case, tmp_path / case)
    before = sorted(tmp_path.rglob("*"))
    monkeypatch.chdir(tmp_path)
    assert f"{case}: has case.toml, of a case, a run or another study" in refused(*words, "--out", ".")
    assert sorted(tmp_path.rglob("*")) == before


def test_a_study_of_too_many_seeds_is_refused_in_a_moment() -> None:
    """Each of its runs would be checked first, for hours."""
    assert "--seeds" in refused("accuracy", EMPTY, "--dry", "--seeds", "100000")


def test_a_misspelt_variant_is_refused() -> None:
    message = refused("accuracy", EMPTY, "--dry", "--parameters", "scheme=serial-stagered")
    assert {'"serial-stagered"', '"serial-staggered"?'} <= {*message.split()}


def test_a_name_that_is_not_utf_8_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / os.fsdecode(b"na\xffme")
    monkeypatch.setattr(sys, "argv", ["flipflow", "study", "sweep", EMPTY, *VARY, "--out", str(out)])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 2
    assert r"na\udcffme' is not UTF-8; give it another name" in capsys.readouterr().err.replace("\n", "")
    assert not out.exists()
