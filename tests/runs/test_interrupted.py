"""Exit codes 129, 130 and 143: a run that is told to stop ends its sync interval and its books."""

from __future__ import annotations

import fcntl
import json
import os
import pty
import signal
import subprocess
import termios
from pathlib import Path

import pytest

from orchestrator.output.checkpoints import find_newest
from orchestrator.studies.design.runs import has_ended
from orchestrator.workbench import Run
from tests.runs.outside import (
    HANG_S,
    QUICK,
    ROOT,
    buffered,
    command,
    flipflow,
    left_usable,
    run_words,
    started,
    times,
    wait_until,
)

LONG = [*QUICK, "duration_s=30"]
# waits in the third interval until it is told to stop a second time
STUCK = """
import pathlib, time
from adapters.frames import two_mass
advance = two_mass.TwoMassFrames.advance
def stuck(self, interval, reaction):
    if interval.index == 2:
        pathlib.Path({marker!r}).touch()
        time.sleep(300)
    return advance(self, interval, reaction)
two_mass.TwoMassFrames.advance = stuck
"""


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_it_ends_its_interval_and_its_books(tmp_path: Path, name: str) -> None:
    folder, number = tmp_path / "run", getattr(signal, name)
    run = started(*run_words("quickstart", folder, LONG))
    wait_until(lambda: (folder / "particles.pvd").exists())
    run.send_signal(number)
    output = run.communicate(timeout=HANG_S)[1]
    assert run.returncode == 128 + number, output
    assert "Traceback" not in output
    assert f"stopped by {name} at t = " in output
    assert output.endswith(f"results in {folder}\n")
    assert f"stopped by {name} at t = " in (folder / "run.log").read_text()
    summary = left_usable(folder, "interrupted")
    assert summary["reason"] == f"stopped by {name}"
    assert 0 < summary["sync_intervals"] < 300_000
    assert times(folder, "frames/driving")[-1] == pytest.approx(summary["simulated_s"])
    assert summary["momentum_residual_relative"] < 1e-11
    assert summary["energy_ledger_J"]
    assert "WARNING" not in (folder / "run.log").read_text().split("open after")[1]


def test_told_twice_it_does_not_wait(tmp_path: Path) -> None:
    folder, marker = tmp_path / "run", tmp_path / "stuck"
    before = STUCK.format(marker=str(marker))
    run = started(*run_words("empty-machine", folder, LONG), before=before)
    wait_until(marker.exists)
    run.send_signal(signal.SIGINT)
    with pytest.raises(subprocess.TimeoutExpired):
        run.wait(timeout=1.0)  # it waits for the end of the interval
    run.send_signal(signal.SIGINT)
    output = run.communicate(timeout=HANG_S)[1]
    assert run.returncode == 130, output
    assert "Traceback" not in output
    summary = left_usable(folder, "interrupted")
    assert (summary["reason"], summary["sync_intervals"]) == ("stopped at once", 2)


# waits while the solvers are opened
OPENING = """
import pathlib, time
from adapters.frames import two_mass
def stuck(self, *given, **more):
    pathlib.Path({marker!r}).touch()
    time.sleep(300)
two_mass.TwoMassFrames.__init__ = stuck
"""


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_before_the_start_it_waits_for_nothing(tmp_path: Path, name: str) -> None:
    folder, marker = tmp_path / "run", tmp_path / "stuck"
    before = OPENING.format(marker=str(marker))
    run = started(*run_words("empty-machine", folder, LONG), before=before)
    wait_until(marker.exists)
    run.send_signal(getattr(signal, name))
    output = run.communicate(timeout=HANG_S)[1]
    assert run.returncode == 128 + getattr(signal, name), output
    assert "Traceback" not in output
    assert f"stopped by {name} before the start" in output
    summary = json.loads((folder / "summary.json").read_text())
    assert (summary["status"], summary["sync_intervals"]) == ("interrupted", 0)


# is killed after the last interval, before its results are made
KILLED_AT_ITS_END = """
import os, signal
from orchestrator.run import ending
ending.compute_results = lambda folder: os.kill(os.getpid(), signal.SIGKILL)
"""


def test_killed_before_its_results_are_made_it_is_not_done(tmp_path: Path) -> None:
    """A study takes such a run up again (it once counted as done, and told nothing)."""
    folder, sets = tmp_path / "run", [*QUICK, "duration_s=0.02", "checkpoint.every_s=0.01"]
    done = flipflow(*run_words("quickstart", folder, sets), before=KILLED_AT_ITS_END)
    assert done.returncode == -signal.SIGKILL
    summary = json.loads((folder / "summary.json").read_text())
    assert summary["status"] == "interrupted"
    assert summary["reason"] == "stopped while its results were being made"
    assert not has_ended(Run(folder))
    assert flipflow("resume", str(folder)).returncode == 0
    assert left_usable(folder, "done")["results"]["failed"] == {}


STOPPED_AT_ITS_PICTURES = """
from orchestrator.run import ending
def python(*words, **more):
    raise KeyboardInterrupt
ending.python = python
"""


def test_stopped_at_its_pictures_it_is_done(tmp_path: Path) -> None:
    """All else is written; the run was called interrupted, without what runs leave at their end."""
    folder = tmp_path / "run"
    words = run_words("quickstart", folder, ["duration_s=0.02"])
    done = flipflow(*words, before=STOPPED_AT_ITS_PICTURES)
    assert done.returncode == 0, done.stderr
    assert "pictures are missing: stopped" in done.stderr
    assert f"results in {folder}" in done.stderr
    assert left_usable(folder, "done")["results"]["failed"] == {}


def test_nohup_keeps_what_it_promises(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    nohup = "import signal\nsignal.signal(signal.SIGHUP, signal.SIG_IGN)"
    run = started(*run_words("quickstart", folder, LONG), before=nohup)
    wait_until(lambda: (folder / "particles.pvd").exists())
    run.send_signal(signal.SIGHUP)
    with pytest.raises(subprocess.TimeoutExpired):
        run.wait(timeout=2.0)
    run.send_signal(signal.SIGTERM)
    output = run.communicate(timeout=HANG_S)[1]
    assert run.returncode == 128 + signal.SIGTERM, output
    assert "stopped by SIGTERM at t = " in output


@pytest.mark.parametrize("kind", ["xterm", "dumb"])
def test_a_terminal_that_closes(tmp_path: Path, kind: str) -> None:
    """All is written and saved, although there is nobody left to tell."""
    folder = tmp_path / "run"
    ours, theirs = pty.openpty()
    run = subprocess.Popen(
        command(*run_words("quickstart", folder, LONG)),
        cwd=ROOT,
        stdin=theirs,
        stdout=theirs,
        stderr=theirs,
        env=buffered() | {"TERM": kind},
        start_new_session=True,
        preexec_fn=lambda: fcntl.ioctl(0, termios.TIOCSCTTY, 0),
    )
    os.close(theirs)
    shown = b""
    while b"running quickstart" not in shown:
        shown += os.read(ours, 4096)
    wait_until(lambda: (folder / "particles.pvd").exists())
    os.close(ours)
    assert run.wait(timeout=HANG_S) == 128 + signal.SIGHUP
    assert left_usable(folder, "interrupted")["reason"] == "stopped by SIGHUP"
    assert find_newest(folder) is not None
    assert "ERROR" not in (folder / "run.log").read_text()


# an archive that a second signal leaves open complains of that, not of the signal
SAVING = """
import pathlib, time, zipfile
import numpy
def savez(file, **arrays):
    with zipfile.ZipFile(file, "w") as archive:
        part = archive.open("positions", "w")
        part.write(bytes(1000))
        pathlib.Path({marker!r}).touch()
        time.sleep(300)
numpy.savez = savez
"""


def test_told_twice_during_a_save(tmp_path: Path) -> None:
    folder, marker = tmp_path / "run", tmp_path / "saving"
    before = SAVING.format(marker=str(marker))
    run = started(*run_words("empty-machine", folder, LONG), before=before)
    wait_until(lambda: (folder / "history.h5").exists())
    run.send_signal(signal.SIGINT)
    wait_until(marker.exists)
    run.send_signal(signal.SIGINT)
    output = run.communicate(timeout=HANG_S)[1]
    assert run.returncode == 130, output
    assert "Traceback" not in output
    assert left_usable(folder, "interrupted")["reason"] == "stopped at once"
