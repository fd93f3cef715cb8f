"""Two at once: each has a folder of its own, or the second is refused; caches are shared."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from orchestrator.output.records.run_folder import RUN_LOCK, is_at_work, lock, make_folder
from tests.runs.outside import (
    HANG_S,
    QUICK,
    ROOT,
    flipflow,
    left_usable,
    run_words,
    said_plainly,
    started,
    times,
    wait_until,
)

SHORT = [*QUICK, "duration_s=0.01"]
LONG = [*QUICK, "duration_s=30"]


def test_runs_of_one_case_at_once_have_folders_of_their_own(tmp_path: Path) -> None:
    """Three start together without --out: each takes a number of its own."""
    words = ["run", str(ROOT / "cases/panel-cycle"), "--level", "draft"]
    words += [word for key in SHORT for word in ("--set", key)]
    runs = [started(*words, cwd=tmp_path) for _ in range(3)]
    outputs = [run.communicate(timeout=HANG_S)[1] for run in runs]
    assert [run.returncode for run in runs] == [0] * 3, outputs
    folders = sorted((tmp_path / "runs").iterdir())
    assert [folder.name for folder in folders] == [f"panel-cycle-{n}" for n in (1, 2, 3)]
    for folder in folders:
        left_usable(folder, "done")


def test_one_folder_for_two_runs_goes_to_one(tmp_path: Path) -> None:
    words = run_words("panel-cycle", tmp_path / "run", SHORT)
    runs = [started(*words) for _ in range(3)]
    outputs = [run.communicate(timeout=HANG_S)[1] for run in runs]
    assert sorted(run.returncode for run in runs) == [0, 2, 2]
    assert sum("exists already; nothing was written" in output for output in outputs) == 2
    left_usable(tmp_path / "run", "done")


def test_one_run_that_three_go_on_with_goes_to_one(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    assert flipflow(*run_words("panel-cycle", folder, SHORT)).returncode == 0
    words = ["resume", str(folder), "--set", "duration_s=0.05"]
    runs = [started(*words) for _ in range(3)]
    outputs = [run.communicate(timeout=HANG_S)[1] for run in runs]
    assert sorted(run.returncode for run in runs) == [0, 2, 2], outputs
    left_usable(folder, "done")
    assert times(folder, "energy")[-1] == pytest.approx(0.05)


def test_a_study_does_not_touch_a_run_that_goes_on(tmp_path: Path) -> None:
    """A run that looks like an unfinished one of the study may still be at work."""
    case, key = "cases/empty-machine", "screen.exciters.shaft.speed_rad_per_s"
    folder = tmp_path / "speed_rad_per_s-70"
    run = started(*run_words("empty-machine", folder, [*LONG, f"{key}=70"]))
    wait_until(lambda: (folder / "surface.pvd").exists())
    assert is_at_work(folder)
    words = ["study", "sweep", case, "--level", "draft", "--vary", f"{key}=70"]
    words += [word for each in LONG for word in ("--set", each)]
    done = flipflow(*words, "--out", str(tmp_path))
    assert done.returncode == 2, done.stderr
    said_plainly(done)
    assert f"{folder}: a run is at work there" in done.stderr
    run.send_signal(signal.SIGINT)
    run.communicate(timeout=HANG_S)
    assert run.returncode == 130
    left_usable(folder, "interrupted")
    assert not is_at_work(folder)


def test_a_second_study_in_a_folder_is_refused(tmp_path: Path) -> None:
    words = ["study", "sweep", "cases/panel-cycle", "--level", "draft", "--out", str(tmp_path)]
    words += ["--vary", "duration_s=0.01,0.02", "--set", "output.pictures=false"]
    with lock(tmp_path / ".lock"):
        done = flipflow(*words)
    assert done.returncode == 2, done.stderr
    assert f"{tmp_path}: another flipflow is at work there" in done.stderr
    assert [file.name for file in tmp_path.iterdir()] == [".lock"]


def test_a_folder_is_let_go_of_by_a_holder_that_is_killed(tmp_path: Path) -> None:
    folder = make_folder(tmp_path / "run")
    hold = (
        "import sys, time; from pathlib import Path\n"
        "from orchestrator.output.records.run_folder import lock\n"
        "with lock(Path(sys.argv[1])): print('held', flush=True); time.sleep(300)"
    )
    words = [sys.executable, "-c", hold, str(folder / RUN_LOCK)]
    with subprocess.Popen(words, cwd=ROOT, stdout=subprocess.PIPE, encoding="utf-8") as holder:
        assert holder.stdout is not None
        assert holder.stdout.readline() == "held\n"
        assert is_at_work(folder)
        os.kill(holder.pid, signal.SIGKILL)
        holder.wait(timeout=HANG_S)
    assert not is_at_work(folder)
