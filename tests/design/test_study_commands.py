"""The commands of a design study in this process: what they check, say and write before anything is run."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner, Result

from orchestrator.cli.main import app
from orchestrator.output.records.run_folder import STUDY_LOCK, lock
from tests.design.campaigns import write_study
from tests.design.plates import write_plates

RANGE = 'range = [4, 12]\nunit = "mm"'


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Stand in a folder of the test's own, with lines that are not wrapped."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "400")


def study(command: str, *words: str) -> Result:
    """Run a command on the study in this folder."""
    return CliRunner().invoke(app, ["study", command, "study.toml", *words])


def contents(folder: Path) -> set[str]:
    """List the files and folders in a folder."""
    return {file.name for file in folder.iterdir()}


@pytest.mark.parametrize("command", ["design", "optimise", "fit"])
def test_a_mistake_in_the_file_ends_each_command_before_anything_is_written(
    command: str, tmp_path: Path
) -> None:
    write_study(tmp_path, **{"plan/run": 7, "hours": -1.0})
    done = study(command)
    assert done.exit_code == 2
    assert "2 problems" in done.output
    assert 'study.toml plan.run: unknown key (its value: 7); did you mean "runs"?' in done.output
    assert contents(tmp_path) == {"study.toml"}


def test_a_dry_design_lists_its_runs_and_writes_nothing(tmp_path: Path) -> None:
    write_plates(tmp_path, ("seed = 3", "seed = 3\nhours = 1"))
    done = study("design", "--dry", "--workers", "1")
    assert done.exit_code == 0, done.output
    rows = [
        line.split() for line in done.output.splitlines() if line.split()[:1] and line.split()[0].isdigit()
    ]
    planned = [row for row in rows if len(row) == 3 and row[0] in "234567"]
    assert [row[0] for row in planned] == list("234567")
    assert all(4 <= float(row[1]) <= 12 and 40 <= float(row[2]) <= 100 for row in planned)
    assert "8 runs of" in done.output
    assert "on 1 workers" in done.output
    assert "more fit into 1 h" in done.output
    assert contents(tmp_path) == {"study.toml"}


def test_a_dry_design_says_what_does_not_fit_into_the_hours(tmp_path: Path) -> None:
    """The centre alone is run whatever it takes."""
    write_plates(tmp_path, ("seed = 3", "seed = 3\nhours = 0.0001"))
    done = study("design", "--dry", "--workers", "1")
    assert done.exit_code == 0, done.output
    assert "7 of them will not be made: they do not fit into 8e-05 h (0.0001 h less" in done.output
    assert "more fit" not in done.output


def test_a_fit_before_any_run_says_so(tmp_path: Path) -> None:
    write_plates(tmp_path)
    done = study("fit", "--out", "there")
    assert done.exit_code == 2
    assert "there: there are no data yet" in done.output
    assert "flipflow study design" in done.output
    assert contents(tmp_path) == {"study.toml"}


@pytest.mark.parametrize(
    ("surrogate", "text"),
    [("gaussian-process", "take slope = 30"), ("quadratic", "support no optimum: every setting is needed")],
)
def test_three_settings_that_were_run_three_times_have_a_page(
    surrogate: str, text: str, tmp_path: Path
) -> None:
    """The settings are the fewest: any two of them tell no quadratic."""
    rows = [f"{slope},{slope / 10 + off}" for slope in (10, 20, 30) for off in (-0.1, 0.0, 0.1)]
    (tmp_path / "belt.csv").write_text("\n".join(["slope,speed", *rows]), encoding="utf-8")
    keys = ("case", "set", "plan", "factors/stroke", "responses/share", "responses/speed/result")
    changes = {"table": "belt.csv", "limits": [], "search/surrogate": surrogate}
    write_study(tmp_path, **dict.fromkeys(keys), **changes)
    done = study("fit", "--out", "there")
    assert done.exit_code == 0, done.output
    assert text in done.output
    assert "quadratic surface of speed" in done.output
    assert "design.html" in contents(tmp_path / "there")


@pytest.mark.parametrize("words", [("design",), ("design", "--dry"), ("optimise",)])
def test_a_corner_that_is_no_case_is_named_before_anything_is_run(
    words: tuple[str, ...], tmp_path: Path
) -> None:
    write_plates(tmp_path, ('"rate"', '"rate - 40"'), ("[40, 100]", "[20, 100]"))
    done = study(*words)
    assert done.exit_code == 2
    assert "amplitude = 4, rate = 20" in done.output
    assert "amplitude = 12, rate = 20" in done.output
    assert "rate = 100" not in done.output
    assert "drive.speed_rad_per_s" in done.output
    assert contents(tmp_path) == {"study.toml"}


def test_a_formula_that_divides_by_zero_in_a_corner_is_named(tmp_path: Path) -> None:
    write_plates(tmp_path, ('"amplitude / 1000"', '"1 / (amplitude - 12)"'))
    done = study("design")
    assert done.exit_code == 2
    assert "4 problems" in done.output
    assert "amplitude = 8, rate = 70: -0.25 is out of" in done.output  # the centre
    assert "amplitude = 4, rate = 100: the plate frame moves with 127 g" in done.output  # by 0.125 m
    assert "amplitude = 12, rate = 40: " in done.output
    assert "1 / (amplitude - 12)" in done.output
    assert contents(tmp_path) == {"study.toml"}


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (
            '"screen.frames.plate.drive.speed_rad_per_s" =',
            '"screen.frames.plate.drive.sped" =',
            ["sped", "speed"],
        ),
        (
            '"screen.frames.plate.drive.speed_rad_per_s" =',
            '"screen.frames.plat.drive.speed_rad_per_s" =',
            ['the case has no "plat" in screen.frames', 'did you mean "plate"?'],
        ),
        ("seed = 3", 'seed = 3\nlevel = "drft"', ["drft", "draft"]),
        ("cases/bushing-hysteresis", "cases/bushing-hysteresi", ["1 problem", "bushing-hysteresi"]),
        ("duration_s=0.3", "duration=0.3", ["duration", "duration_s"]),
    ],
    ids=["a key of the case", "a part of the case", "a level", "a case", "an override"],
)
def test_what_the_case_does_not_have_is_named(old: str, new: str, words: list[str], tmp_path: Path) -> None:
    write_plates(tmp_path, (old, new))
    done = study("design", "--dry")
    assert done.exit_code == 2, done.output
    for word in words:
        assert word in done.output
    assert contents(tmp_path) == {"study.toml"}


def test_a_folder_at_which_another_study_works_is_refused(tmp_path: Path) -> None:
    write_plates(tmp_path)
    (tmp_path / "out").mkdir()
    with lock(tmp_path / "out" / STUDY_LOCK):
        for command in ("design", "optimise"):
            done = study(command, "--out", "out")
            assert done.exit_code == 2
            assert "out: another flipflow is at work there; wait for its end" in done.output
    assert contents(tmp_path / "out") == {STUDY_LOCK}


def test_the_file_of_a_study_is_not_written_over_by_its_own_folder(tmp_path: Path) -> None:
    """Its comments would be lost, and its case is given from its own folder."""
    (tmp_path / "belt.csv").write_text("slope,stroke,speed,share\n10,2,0.5,80\n30,2,1.9,45\n10,6,0.8,62\n")
    own: dict[str, Any] = {
        "case": None,
        "set": {},
        "responses/speed/result": None,
        "responses/share/result": None,
    }
    file = write_study(tmp_path, table="belt.csv", **own)
    text = "# by hand\n" + file.read_text()
    file.write_text(text)
    done = study("fit", "--out", ".")
    assert done.exit_code == 0, done.output
    assert file.read_text() == text
    assert "points.csv" in contents(tmp_path)


@pytest.mark.parametrize(
    ("added", "words"),
    [
        ('[cheap]\nlevel = "drft"\nruns = 4', ["drft", "draft"]),
        ('[cheap]\nlevel = "draft"\nruns = 4\noverrides = ["duraton_s=0.1"]', ["duraton_s", "duration_s"]),
        ('[simpler]\nrate = "sqrt(amplitude - 10)"', ["amplitude = 4, rate = 40: ", "has no value"]),
        (
            '[simpler]\nrate = "10 * amplitude"',
            ["amplitude = 12, rate = 40: rate = 120 of [simpler] is out of its range"],
        ),
    ],
    ids=["cheap level", "cheap override", "simpler without a value", "simpler out of range"],
)
def test_what_only_later_stages_need_is_checked_first(added: str, words: list[str], tmp_path: Path) -> None:
    write_plates(tmp_path, ("[search]", f"{added}\n[search]"))
    done = study("design")
    assert done.exit_code == 2, done.output
    for word in words:
        assert word in done.output
    assert contents(tmp_path) == {"study.toml"}


def test_a_folder_that_cannot_be_made_is_refused(tmp_path: Path) -> None:
    """The file system refuses the folder, whatever the user may do."""
    (tmp_path / "belt.csv").write_text("slope,stroke,speed,share\n10,2,0.5,80\n30,2,1.9,45\n")
    own: dict[str, Any] = {"case": None, "set": {}, "responses/speed/result": None}
    write_study(tmp_path, table="belt.csv", **own, **{"responses/share/result": None})
    done = study("fit", "--out", "/proc/nowhere")
    assert done.exit_code == 2
    assert "/proc/nowhere" in done.output
    assert "Traceback" not in done.output
