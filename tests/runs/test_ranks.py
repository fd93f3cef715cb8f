"""Two processes under mpirun: the same run, one voice, one end."""

from __future__ import annotations

import os
import re
import signal
import time
from pathlib import Path

import h5py
import meshio
import numpy as np
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
    summary,
    wait_until,
)

pytestmark = [pytest.mark.solver, needs_mpirun]
SHORT = [*QUICK, "duration_s=0.02"]
# broken on one rank only: at the third interval, of the panel that this rank owns
ONE_RANK_FAILS = """
from mpi4py import MPI
from adapters.panel.strip import panel as strip
from orchestrator.ports.plans import SolverFailed
advance = strip.Strip.advance
def broken(self, interval, clamps, load):
    if interval.index == 2 and MPI.COMM_WORLD.rank == {rank}:
        {what}
    return advance(self, interval, clamps, load)
strip.Strip.advance = broken
"""
ALL_RANKS_FAIL = """
import time
from mpi4py import MPI
from orchestrator.output.records.recorder import Recorder
from orchestrator.ports.plans import SolverFailed
from orchestrator.run import run
close = Recorder.close
def broken(observed, time_s, advice):
    if time_s > 2.5e-4:
        raise SolverFailed("on purpose")
def close_slowly(self):
    if MPI.COMM_WORLD.rank == 0:
        time.sleep(0.5)
    close(self)
run.check_speeds, Recorder.close = broken, close_slowly
"""
ONE_RANK_LACKS_A_SOLVER = """
import os, sys
if os.environ["OMPI_COMM_WORLD_RANK"] == "1":
    sys.modules["dolfinx"] = None
"""


def test_two_ranks_give_the_run_of_one(tmp_path: Path) -> None:
    """The spheres and frames are solved on rank 0 or alike on both; sums may differ in the last
    digits, which 0.02 s do not enlarge."""
    alone, both = tmp_path / "alone", tmp_path / "both"
    assert flipflow(*run_words("quickstart", alone, SHORT)).returncode == 0
    done = flipflow(*run_words("quickstart", both, ["duration_s=0.02"]), ranks=2)
    assert done.returncode == 0, done.stderr
    said_plainly(done)
    assert done.stderr.count("where the time went") == 1
    assert done.stderr.count("warning: left out: variation-across: panel.solver") == 1
    assert left_usable(both, "done")["momentum_residual_relative"] < 1e-11
    pictures = {"bushing_loops", "deck", "energy", "frame_motion", "panel_shapes"}
    assert {picture.stem for picture in both.glob("*.png")} == pictures
    with h5py.File(alone / "history.h5") as first, h5py.File(both / "history.h5") as second:
        for name in ("probes/middle-1/position_m", "probes/middle-2/position_m"):
            np.testing.assert_allclose(second[name][:], first[name][:], rtol=0, atol=1e-12)


@pytest.mark.slow
def test_the_real_solvers_give_the_run_of_one(tmp_path: Path) -> None:
    """A panel on each rank, particles decomposed over both, frames on the first.  Impulses and
    energies to 1e-9 of the largest: only the order of sums differs."""
    sets = [*QUICK, "duration_s=0.06", "output.interval_s=0.02", "panel.cells=[12, 4]"]
    sets += ["frames.solver=exudyn", "panel.solver=sheet", "particles.solver=liggghts"]
    alone, both = tmp_path / "alone", tmp_path / "both"
    for folder, ranks in ((alone, 1), (both, 2)):
        done = flipflow(*run_words("quickstart", folder, sets), ranks=ranks)
        assert done.returncode == 0, done.stderr
    of_alone, of_both = summary(alone)["energy_ledger_J"], summary(both)["energy_ledger_J"]
    assert of_both == pytest.approx(of_alone, rel=0, abs=1e-9 * max(map(abs, of_alone.values())))
    assert of_alone["lost.particles.contact_dissipation"] > 0.0
    with h5py.File(alone / "history.h5") as first, h5py.File(both / "history.h5") as second:
        for name in ("forces/deck-1/load_N", "forces/deck-2/load_N"):
            impulse = first[name][:].cumsum(axis=0)
            atol = 1e-9 * np.abs(impulse).max()
            assert atol > 0.0
            np.testing.assert_allclose(
                second[name][:].cumsum(axis=0), impulse, rtol=0, atol=atol, err_msg=name
            )


@pytest.mark.parametrize(
    ("rank", "what", "code", "message"),
    [
        (0, "raise SolverFailed('on purpose')", 4, "on purpose"),
        (1, "raise SolverFailed('on purpose')", 4, "on purpose"),
        (1, "load.force_N[0] = float('nan')", 4, "(strip) failed between t = 0.0002 s and 0.0003 s"),
        (1, "raise KeyError('no such thing')", 1, "internal error: KeyError: 'no such thing'"),
    ],
)
def test_a_failure_on_one_rank_ends_both_with_one_message(
    tmp_path: Path, rank: int, what: str, code: int, message: str
) -> None:
    folder = tmp_path / "run"
    before = ONE_RANK_FAILS.format(rank=rank, what=what)
    done = flipflow(*run_words("quickstart", folder, SHORT), before=before, ranks=2)
    assert done.returncode == code, done.stderr
    said_plainly(done)
    assert done.stderr.count(message) == 1
    assert message in (folder / "run.log").read_text()
    assert message in left_usable(folder, "failed")["reason"]
    wait_until(lambda: of(folder) == [])
    assert time.time() - (folder / "failure.txt").stat().st_mtime < ENDED_S


def test_rank_0_sums_up_where_all_ranks_fail_alike(tmp_path: Path) -> None:
    """Rank 0 alone has the figures, though it has more to close than the others."""
    folder = tmp_path / "run"
    done = flipflow(*run_words("quickstart", folder, SHORT), before=ALL_RANKS_FAIL, ranks=2)
    assert done.returncode == 4, done.stderr
    assert done.stderr.count("on purpose") == 1
    assert left_usable(folder, "failed")["particles"] == 100
    wait_until(lambda: of(folder) == [])


def test_a_summary_that_breaks_does_not_keep_the_other_ranks(tmp_path: Path) -> None:
    """The other ranks wait for rank 0, which ends them whatever happens to it."""
    folder = tmp_path / "run"
    before = f"{ALL_RANKS_FAIL}\nfrom orchestrator.run.ending import Ending\nEnding.write = None"
    done = flipflow(*run_words("quickstart", folder, SHORT), before=before, ranks=2)
    assert done.returncode == 4, done.stderr
    assert "no summary: 'NoneType' object is not callable" in done.stderr
    said_plainly(done)
    wait_until(lambda: of(folder) == [])


def test_a_rank_that_is_killed_takes_the_others_with_it(tmp_path: Path) -> None:
    """Nobody is left to write a summary: mpirun says which rank it was and ends the others by SIGTERM and,
    a second later, SIGKILL. What was written until the last output time is there."""
    folder = tmp_path / "run"
    run = started(*run_words("quickstart", folder, [*QUICK, "duration_s=30"]), ranks=2)
    wait_until(lambda: (folder / "particles/particles_00002.vtu").exists())
    killed = time.monotonic()
    os.kill(max(of(folder)), signal.SIGKILL)
    output = run.communicate(timeout=HANG_S)[1]
    assert time.monotonic() - killed < ENDED_S
    assert run.returncode == 128 + signal.SIGKILL, output
    assert "Traceback" not in output
    assert "exited on signal 9 (Killed)" in " ".join(output.split())  # Open MPI 5 breaks the line
    wait_until(lambda: of(folder) == [] and not is_at_work(folder))
    with h5py.File(folder / "history.h5") as history:
        assert len(history["energy/time_s"]) >= 2
    files = re.findall(r'file="([^"]*)"', (folder / "particles.pvd").read_text())
    assert len(meshio.read(folder / files[-1]).points) == 100


def test_a_wrong_case_is_said_once(tmp_path: Path) -> None:
    done = flipflow(*run_words("quickstart", tmp_path / "run", ["duration_s=-1"]), ranks=2)
    assert done.returncode == 2, done.stderr
    said_plainly(done)
    assert done.stderr.count("1 problem in the case") == 1
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_exists_is_said_once(tmp_path: Path) -> None:
    done = flipflow(*run_words("quickstart", tmp_path, SHORT), ranks=2)
    assert done.returncode == 2, done.stderr
    assert done.stderr.count("exists already") == 1


def test_ranks_that_read_different_cases(tmp_path: Path) -> None:
    """The folders of two computers may not be the same."""
    other = (
        "import sys\nfrom mpi4py import MPI\nif MPI.COMM_WORLD.rank: sys.argv += ['--set', 'duration_s=0.03']"
    )
    done = flipflow(*run_words("quickstart", tmp_path / "run", SHORT), before=other, ranks=2)
    assert done.returncode == 2, done.stderr
    assert done.stderr.count("the ranks have read different cases") == 1
    assert list(tmp_path.iterdir()) == []


def test_a_solver_missing_on_one_rank(tmp_path: Path) -> None:
    sets = [*SHORT, "panel.solver=sheet"]
    words = run_words("empty-machine", tmp_path / "run", sets)
    done = flipflow(*words, before=ONE_RANK_LACKS_A_SOLVER, ranks=2)
    assert done.returncode == 3, done.stderr
    assert done.stderr.count("python3-dolfinx") == 1
    assert list(tmp_path.iterdir()) == []


def test_one_interrupted_rank_stops_both(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    run = started(*run_words("quickstart", folder, [*QUICK, "duration_s=30"]), ranks=2)
    wait_until(lambda: (folder / "particles.pvd").exists())
    os.kill(max(of(folder)), signal.SIGINT)
    output = run.communicate(timeout=HANG_S)[1]
    assert run.returncode == 130, output
    assert output.count("stopped by SIGINT") == 1
    assert left_usable(folder, "interrupted")["energy_ledger_J"]
