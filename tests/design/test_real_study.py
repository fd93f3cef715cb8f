"""A real study, from its file to a level that is run: undisturbed, and killed again and again.

Some thirty runs of a second or two each.
"""

from __future__ import annotations

import csv
import os
import re
import shutil
import signal
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest

from tests.design.plates import CASE, write_plates
from tests.runs.outside import command, flipflow, summary

pytestmark = [pytest.mark.slow, pytest.mark.process]
DIFFERENT = {"costs.csv", "points.parquet"}  # times are never the same; the other is points.csv once more
KILLED_IN = (4, 10, 13)  # trials during which a study is killed: in each of its stages
LONGEST_S = 300
PREDICTED = "points.csv, predicted"
FITTED = ("fit.json", "front.csv", PREDICTED)
"""Files of what linear algebra fits.  Another process may round its last digit otherwise, and the half widths
of a surrogate without noise are what cancellation leaves: 5e-7 of them was seen."""
NUMBER = re.compile(rb"-?\d+(?:\.\d+)?(?:e[+-]?\d+)?")


def words(folder: Path, out: Path, name: str = "optimise") -> list[str]:
    """Return the words of a command on the study, with one worker where it runs anything."""
    workers = [] if name == "fit" else ["--workers", "1"]
    return ["study", name, str(folder), "--out", str(out), *workers]


def files(out: Path) -> dict[str, bytes]:
    """Return what a study has written, without its runs and its times.

    The columns of predictions in the table of trials count as a file.
    """
    texts = {
        file.name: file.read_bytes()
        for file in out.iterdir()
        if file.is_file() and file.name not in DIFFERENT and not file.name.startswith(".")
    }
    if "points.csv" in texts:
        rows = [*csv.reader(texts["points.csv"].decode().splitlines())]
        for name, predicted in (("points.csv", False), (PREDICTED, True)):
            columns = [k for k, title in enumerate(rows[0]) if (" predicted" in title) is predicted]
            texts[name] = "\n".join(",".join(row[k] for k in columns) for row in rows).encode()
    return texts


def assert_same(mine: dict[str, bytes], wanted: dict[str, bytes]) -> None:
    """Compare the files of two studies byte for byte, and the numbers that were fitted to 1e-5."""
    assert {**mine, **dict.fromkeys(FITTED)} == {**wanted, **dict.fromkeys(FITTED)}
    for name in FITTED:
        assert NUMBER.sub(b"", mine[name]) == NUMBER.sub(b"", wanted[name])
        numbers = [[float(each) for each in NUMBER.findall(table[name])] for table in (mine, wanted)]
        assert numbers[0] == pytest.approx(numbers[1], rel=1e-5, abs=1e-12)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the study's file."""
    folder = tmp_path_factory.mktemp("plates")
    write_plates(folder)
    return folder


@pytest.fixture(scope="module")
def undisturbed(folder: Path) -> Path:
    """The folder of the study, which ran from its beginning to its end."""
    out = folder / "undisturbed"
    done = flipflow(*words(folder, out))
    assert done.returncode == 0, done.stderr
    assert "For the largest speed at way <= 0.009 take amplitude = 9 mm, rate = 100 rad/s" in done.stdout
    assert "as predicted" in done.stdout
    return out


def test_a_plan_that_has_been_run_has_nothing_left(folder: Path, undisturbed: Path) -> None:
    done = flipflow(*words(folder, undisturbed, "design"), "--dry")
    assert done.returncode == 0, done.stderr
    assert re.search(
        r"^0 of \d+ runs are left, of .* each, the mean of \d+, .*: 0 s$", done.stdout, re.MULTILINE
    )


def best_row(out: Path) -> dict[str, str]:
    """Return the row of the best setting."""
    rows = csv.DictReader((out / "best.csv").read_text(encoding="utf-8").splitlines())
    return next(row for row in rows if row["role"] == "best")


def test_the_fastest_motion_is_found_and_measured(undisturbed: Path) -> None:
    """9 mm times 100 rad/s."""
    best = best_row(undisturbed)
    assert float(best["amplitude"]) == pytest.approx(9.0, abs=0.01)
    assert float(best["rate"]) == pytest.approx(100.0, abs=0.1)
    assert float(best["speed"]) == pytest.approx(0.9, abs=1e-3)
    assert best["verdict"] == "as predicted"


def test_the_recommended_level_runs_as_measured(undisturbed: Path, tmp_path: Path) -> None:
    level = str(undisturbed / "recommended.toml")
    done = flipflow("run", str(CASE), "--level", level, "--out", str(tmp_path / "run"))
    assert done.returncode == 0, done.stderr
    speed = summary(tmp_path / "run")["probes"]["plate"]["peak_speed_m_per_s"]
    assert speed == pytest.approx(float(best_row(undisturbed)["speed"]), rel=1e-12)


def test_everything_but_the_runs_is_written_again(undisturbed: Path, folder: Path) -> None:
    before = files(undisturbed) | {"costs.csv": (undisturbed / "costs.csv").read_bytes()}
    for name in before.keys() - {PREDICTED}:
        (undisturbed / name).unlink()
    done = flipflow(*words(folder, undisturbed, "fit"))
    assert done.returncode == 0, done.stderr
    assert_same(files(undisturbed) | {"costs.csv": (undisturbed / "costs.csv").read_bytes()}, before)


def test_a_finished_study_runs_nothing_again(undisturbed: Path, folder: Path) -> None:
    runs = sorted((undisturbed / "runs").glob("*/summary.json"))
    before = [file.stat().st_mtime_ns for file in runs]
    assert len(runs) >= 15
    done = flipflow(*words(folder, undisturbed))
    assert done.returncode == 0, done.stderr
    assert [
        file.stat().st_mtime_ns for file in sorted((undisturbed / "runs").glob("*/summary.json"))
    ] == before


@pytest.mark.parametrize(
    ("old", "new", "key"),
    [
        ("duration_s=0.3", "duration_s=0.31", "duration_s"),
        ('"amplitude / 1000"', '"amplitude / 1001"', "screen.frames.plate.drive.amplitude_m"),
    ],
    ids=["another case", "another formula"],
)
def test_runs_of_another_case_are_not_mixed_with_these(
    old: str, new: str, key: str, undisturbed: Path, tmp_path: Path
) -> None:
    write_plates(tmp_path, (old, new))
    before = files(undisturbed)
    for name in ("optimise", "fit"):
        done = flipflow(*words(tmp_path, undisturbed, name))
        assert done.returncode == 2
        assert f"holds a run of another case (it differs in {key})" in done.stderr
    assert files(undisturbed) == before


def test_runs_of_wider_ranges_are_data_of_a_narrower_study(undisturbed: Path, tmp_path: Path) -> None:
    write_plates(tmp_path, ("[40, 100]", "[50, 90]"))
    out = tmp_path / "narrower"
    shutil.copytree(undisturbed, out)
    done = flipflow(*words(tmp_path, out, "fit"))
    assert done.returncode == 0, done.stderr
    assert "rate = 90 rad/s" in done.stdout
    assert "not yet measured" in done.stdout
    points = (out / "points.csv").read_text(encoding="utf-8").splitlines()
    assert len(points) >= 16


def test_a_study_that_is_killed_again_and_again_ends_with_the_same_files(
    undisturbed: Path, folder: Path
) -> None:
    """The whole process group gets SIGKILL at a random instant of three trials, each of another stage."""
    out, rng = folder / "killed", np.random.default_rng(int(time.time()))
    for number in KILLED_IN:
        study = subprocess.Popen(
            command(*words(folder, out)),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            env=os.environ | {"OMP_NUM_THREADS": "1"},
            start_new_session=True,
        )
        try:
            end = time.monotonic() + LONGEST_S
            while not (out / "runs" / f"{number:04d}.trial.json").exists():
                assert study.poll() is None
                assert time.monotonic() < end, "waited in vain"
                time.sleep(0.02)
            if number == KILLED_IN[0]:
                second = flipflow(*words(folder, out))
                assert second.returncode == 2
                assert "another flipflow is at work there" in second.stderr
            else:
                time.sleep(rng.uniform(0.0, 3.0))
        finally:
            os.killpg(study.pid, signal.SIGKILL)
            study.wait()
    done = flipflow(*words(folder, out))
    assert done.returncode == 0, done.stderr
    mine, wanted = files(out), files(undisturbed)
    assert mine["points.csv"].splitlines() == wanted["points.csv"].splitlines(), (
        "the first trial that differs"
    )
    assert_same(mine, wanted)
    again = [file.name for file in (out / "runs").iterdir() if "unfinished" in file.name]
    assert len(again) <= len(KILLED_IN)
