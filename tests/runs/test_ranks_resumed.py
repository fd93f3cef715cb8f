"""Runs on two ranks that are stopped, killed or left without a disk: they end soon, and what goes
on is, to the last bit, the run that never stopped."""

from __future__ import annotations

import os
import re
import signal
import time
from pathlib import Path

import pytest

from orchestrator.output.records.run_folder import is_at_work
from tests.runs.outside import (
    ENDED_S,
    HANG_S,
    QUICK,
    flipflow,
    left_usable,
    needs_mpirun,
    of,
    run_words,
    said_plainly,
    started,
    wait_until,
)
from tests.runs.same_run import run_differences

pytestmark = [pytest.mark.solver, pytest.mark.slow, needs_mpirun]
OFTEN = "checkpoint.every_s=0.0006"
# 20 pieces of coal in LIGGGHTS, a panel on each rank; 60 sync intervals
CASE = [*QUICK, "particles.solver=liggghts", "bed.blocks.coal.count=20"]
CASE += ["duration_s=0.006", "output.interval_s=0.0015"]
# slow enough to be told something while it runs
SLOW = """
import time
from adapters.frames import two_mass
advance = two_mass.TwoMassFrames.advance
def slowly(self, interval, reaction):
    time.sleep(0.1)
    return advance(self, interval, reaction)
two_mass.TwoMassFrames.advance = slowly
"""
# the disk of one rank is full from the second save on
FULL = """
import pathlib
from mpi4py import MPI
from orchestrator.output import checkpoints
savez = checkpoints.np.savez
def full(file, **arrays):
    savez(file, **arrays)
    if MPI.COMM_WORLD.rank == {rank} and pathlib.Path(file).parent.name > ".000000000006":
        raise OSError(28, "No space left on device")
checkpoints.np.savez = full
"""


def process(folder: Path, rank: int) -> int:
    """The id of the process of a rank of the run in this folder."""
    name = f"OMPI_COMM_WORLD_RANK={rank}\0".encode()
    (pid,) = (
        candidate for candidate in of(folder) if name in Path(f"/proc/{candidate}/environ").read_bytes()
    )
    return pid


def newest(folder: Path) -> str:
    checkpoints = folder / "checkpoints"
    return (
        max((place.name for place in checkpoints.glob("[0-9]*")), default="") if checkpoints.exists() else ""
    )


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a run that is not stopped, and saved at its end only."""
    folder = tmp_path_factory.mktemp("whole") / "run"
    done = flipflow(*run_words("quickstart", folder, CASE), ranks=2)
    assert done.returncode == 0, done.stderr
    return folder


def goes_on(folder: Path, whole: Path) -> str:
    """Go on with the command that was printed, and return what is printed then."""
    done = flipflow("resume", str(folder), ranks=2)
    assert done.returncode == 0, done.stderr
    said_plainly(done)
    assert run_differences(whole, folder) == []
    return done.stderr


@pytest.mark.parametrize(("sent", "heard", "code"), [("SIGINT", "SIGTERM", 1), ("SIGUSR1", "SIGUSR1", 138)])
def test_mpirun_told_to_stop(
    tmp_path: Path, whole: Path, monkeypatch: pytest.MonkeyPatch, sent: str, heard: str, code: int
) -> None:
    """Open MPI, told by SIGINT or SIGTERM alike, ends its processes by SIGTERM and, a second later
    (here three: a busy machine may need them), by SIGKILL, and exits with 1; SIGUSR1 it passes on,
    and then exits as they do."""
    monkeypatch.setenv("OMPI_MCA_odls_base_sigkill_timeout", "3")
    folder = tmp_path / "run"
    run = started(*run_words("quickstart", folder, CASE), before=SLOW, ranks=2)
    wait_until(lambda: (folder / "particles/particles_00001.vtu").exists())
    run.send_signal(getattr(signal, sent))
    output = run.communicate(timeout=HANG_S)[1]
    assert run.returncode == code, output
    assert "Traceback" not in output
    assert output.count(f"stopped by {heard} at t = ") == 1
    as_root = re.escape(f"-n 2 flipflow resume {folder}")
    assert re.search(rf"\nto go on: mpirun (--allow-run-as-root )?{as_root}\n", output)
    wait_until(lambda: of(folder) == [])
    goes_on(folder, whole)


@pytest.mark.parametrize("rank", [0, 1])
def test_a_killed_rank(tmp_path: Path, whole: Path, rank: int) -> None:
    """mpirun says which; a report says what can be done; nothing of the last save is lost."""
    folder = tmp_path / "run"
    run = started(*run_words("quickstart", folder, [*CASE, OFTEN]), before=SLOW, ranks=2)
    wait_until(lambda: newest(folder) >= f"{12:012d}")
    killed = time.monotonic()
    os.kill(process(folder, rank), signal.SIGKILL)
    output = run.communicate(timeout=HANG_S)[1]
    assert time.monotonic() - killed < ENDED_S
    assert run.returncode == 128 + signal.SIGKILL, output
    assert "Traceback" not in output
    assert f"process rank {rank} with PID " in output
    wait_until(lambda: of(folder) == [] and not is_at_work(folder))
    assert not (folder / "summary.json").exists()
    reported = flipflow("report", str(folder))
    assert reported.returncode == 2
    assert "the run was killed before it could close its books; `flipflow resume" in reported.stderr
    assert "the run had been killed, or the machine stopped" in goes_on(folder, whole)


@pytest.mark.parametrize("rank", [0, 1])
def test_a_full_disk_while_one_rank_saves(tmp_path: Path, whole: Path, rank: int) -> None:
    folder = tmp_path / "run"
    words = run_words("quickstart", folder, [*CASE, OFTEN])
    done = flipflow(*words, before=FULL.format(rank=rank), ranks=2)
    ended = time.time()
    assert done.returncode == 4, done.stderr
    said_plainly(done)
    reason = "the checkpoint at t = 0.0012 s cannot be written: [Errno 28] No space left on device"
    assert done.stderr.count(reason) == 1, done.stderr
    assert left_usable(folder, "failed")["reason"] == f"the computer refused: {reason}"
    assert ended - (folder / "failure.txt").stat().st_mtime < ENDED_S
    wait_until(lambda: of(folder) == [])
    assert [save.name for save in (folder / "checkpoints").iterdir()] == [f"{6:012d}"]
    goes_on(folder, whole)


def test_a_folder_that_vanishes(tmp_path: Path, whole: Path) -> None:
    folder, gone = tmp_path / "run", tmp_path / "gone"
    run = started(*run_words("quickstart", folder, [*CASE, OFTEN]), before=SLOW, ranks=2)
    wait_until(lambda: newest(folder) >= f"{6:012d}")
    folder.rename(gone)
    away = time.monotonic()
    output = run.communicate(timeout=HANG_S)[1]
    assert time.monotonic() - away < ENDED_S
    assert run.returncode == 4, output
    assert "Traceback" not in output
    assert output.count("cannot be written: [Errno 2] No such file or directory") == 1
    assert f"{folder} has gone" in output
    assert not folder.exists()
    wait_until(lambda: of(folder) == [])
    goes_on(Path(gone.rename(folder)), whole)
