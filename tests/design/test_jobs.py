"""Runs of a study that a scheduler of a cluster makes: a stand-in for it, and for the runs."""

from __future__ import annotations

import csv
import json
import os
import random
import shlex
import signal
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import IO

import pytest
from typer.testing import CliRunner, Result

from orchestrator.cli.main import app
from orchestrator.output.records.run_folder import write_case
from orchestrator.output.records.summary import SUMMARY_FORMAT
from orchestrator.workbench import Case, Run
from tests.design.plates import CASE, write_plates
from tests.runs.outside import wait_until

RATE = "screen.frames.plate.drive.speed_rad_per_s"
SWEEP = ("study", "sweep", str(CASE), "--set", "output.pictures=false", "--vary")
KILLED = 17  # the number of the run that is killed


class StandIn:
    """Runs that end at once, as ``Run.carry_out`` makes them; one of them is killed."""

    def __init__(self) -> None:
        self.made: list[Path] = []

    def __call__(self, words: Sequence[str], log: IO[str]) -> int:
        sets = [words[k + 1] for k, word in enumerate(words) if word == "--set"]
        loaded, folder = Case.load(Path(words[1]), None, sets), Path(words[-1])
        drive = loaded.tables.screen.frames["plate"].drive
        assert drive is not None
        folder.mkdir()  # fails where a run has been made
        write_case(folder, loaded.judged)
        self.made.append(folder)
        if len(self.made) == KILLED:
            return -signal.SIGKILL
        way_m = drive.amplitude_m[0]
        moved = {"peak_speed_m_per_s": way_m * drive.speed_rad_per_s, "half_range_m": [way_m, 0.0, 0.0]}
        table = {
            "format_version": SUMMARY_FORMAT,
            "status": "done",
            "wall_s": 1.0,
            "probes": {"plate": moved},
        }
        (folder / "summary.json").write_text(json.dumps(table))
        return 0


@pytest.fixture
def runs(monkeypatch: pytest.MonkeyPatch) -> StandIn:
    stand_in = StandIn()
    monkeypatch.setattr(Run, "carry_out", staticmethod(stand_in))
    return stand_in


def flipflow(*words: str) -> Result:
    return CliRunner().invoke(app, words)


def schedule(jobs: Path) -> list[int]:
    """Make all jobs in any order, and return their exit codes."""
    lines = jobs.read_text().splitlines()
    random.Random(1).shuffle(lines)
    return [flipflow(*shlex.split(line)[1:]).exit_code for line in lines]


@pytest.mark.slow
def test_fifty_runs_by_a_scheduler_are_those_of_the_sweep(tmp_path: Path, runs: StandIn) -> None:
    out = tmp_path / "a sweep"
    sweep = (*SWEEP, f"{RATE}=40:89:1", "--out", str(out), "--workers", "1")
    done = flipflow(*sweep, "--write-jobs")
    assert done.exit_code == 0, done.output
    assert {file.name for file in out.iterdir()} == {"jobs.txt", "job.sh"}
    assert "#SBATCH --array=1-50\n" in (out / "job.sh").read_text()
    assert sorted(schedule(out / "jobs.txt")) == [0] * 49 + [4]
    assert len(runs.made) == 50
    assert schedule(out / "jobs.txt") == [0] * 50
    assert len(runs.made) == 51  # the killed one again, and no other
    assert runs.made[-1] == runs.made[KILLED - 1]
    assert flipflow(*sweep).exit_code == 0
    assert schedule(out / "jobs.txt") == [0] * 50  # beside the tables, too
    assert len(runs.made) == 51
    with (out / "sweep.csv").open() as text:
        assert [row["status"] for row in csv.DictReader(text)] == ["done"] * 50


def test_a_design_fits_the_runs_of_a_scheduler(tmp_path: Path, runs: StandIn) -> None:
    file, out = str(write_plates(tmp_path)), tmp_path / "out"
    for _ in range(2):  # again, it lists the same runs
        done = flipflow("study", "design", file, "--out", str(out), "--write-jobs")
        assert done.exit_code == 0, done.output
        assert len((out / "jobs.txt").read_text().splitlines()) == 8
    assert not runs.made
    assert schedule(out / "jobs.txt") == [0] * 8
    done = flipflow("study", "fit", file, "--out", str(out))
    assert done.exit_code == 0, done.output
    done = flipflow("study", "design", file, "--out", str(out), "--workers", "1")
    assert done.exit_code == 0, done.output
    assert len(runs.made) == 8


@pytest.mark.parametrize("wrong", [["--folder", "a/b"], ["--folder", "a", "--set", "no.key=1"]])
def test_wrong_jobs_are_refused(wrong: list[str], tmp_path: Path, runs: StandIn) -> None:
    assert flipflow("study", "job", str(CASE), "--out", str(tmp_path / "out"), *wrong).exit_code == 2
    assert not runs.made


def test_a_job_in_the_folder_of_another_case_is_refused(tmp_path: Path, runs: StandIn) -> None:
    job = ("study", "job", str(CASE), "--out", str(tmp_path), "--folder", "a", "--set")
    assert flipflow(*job, f"{RATE}=50").exit_code == 0
    assert flipflow(*job, f"{RATE}=51").exit_code == 2
    assert len(runs.made) == 1


@pytest.mark.slow
@pytest.mark.process
def test_the_script_makes_real_runs_and_again_one_that_was_killed(tmp_path: Path) -> None:
    sweep = (*SWEEP, f"{RATE}=50,60", "--set", "duration_s=0.3", "--out", str(tmp_path))
    assert flipflow(*sweep, "--write-jobs").exit_code == 0
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"

    def task(number: int) -> subprocess.Popen[bytes]:
        env = os.environ | {"PATH": path, "SLURM_ARRAY_TASK_ID": str(number), "OMP_NUM_THREADS": "1"}
        return subprocess.Popen(["bash", tmp_path / "job.sh"], env=env, start_new_session=True)

    killed = task(2)
    folder = tmp_path / "speed_rad_per_s-60"
    wait_until(folder.is_dir)
    os.killpg(killed.pid, signal.SIGKILL)
    killed.wait()
    assert [task(number).wait() for number in (2, 1, 2)] == [0, 0, 0]
    assert (tmp_path / "speed_rad_per_s-60-unfinished-1").is_dir()
    assert not (tmp_path / "speed_rad_per_s-60-unfinished-2").exists()
    done = flipflow(*sweep)
    assert done.exit_code == 0, done.output
    assert done.output.count("done before") == 2
