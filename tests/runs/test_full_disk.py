"""Exit code 4 where the disk is full: what was written before is whole, and the run can go on when
there is room again."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.runs.failures import failed
from tests.runs.outside import QUICK, flipflow, run_words, said_plainly, times
from tests.runs.same_run import run_differences

# 120 sync intervals, a save after every third
SAVED = [*QUICK, "bed.blocks.coal.count=30", "duration_s=0.012", "output.interval_s=0.003"]
SAVED += ["checkpoint.every_s=0.0003"]
# something else takes what is left of the disk when the checkpoint at 0.0057 s begins
FILLED = """
from orchestrator.output import checkpoints
parts = checkpoints._write_arrays
def filled(mine, *rest):
    if mine.parent.name == ".000000000057":
        with open({filler!r}, "wb", buffering=0) as filler:
            try:
                while filler.write(bytes(4096)) == 4096:
                    pass
            except OSError:
                pass
    return parts(mine, *rest)
checkpoints._write_arrays = filled
"""


@pytest.fixture
def small_disk(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Path]:
    """Disk of so many MB, by default 20; 16 are kept in reserve."""
    place = tmp_path / "disk"
    place.mkdir()
    size = f"size={getattr(request, 'param', 20)}m"
    mount = ["mount", "-t", "tmpfs", "-o", size, "tmpfs", str(place)]
    if os.geteuid() != 0 or subprocess.run(mount, capture_output=True, check=False).returncode:
        pytest.skip("only root can mount a small disk")
    yield place
    subprocess.run(["umount", str(place)], check=True)


def test_a_full_disk(small_disk: Path) -> None:
    folder = small_disk / "run"
    done = flipflow(*run_words("quickstart", folder, [*QUICK, "output.interval_s=1e-4"]))
    failed(folder, done, "the results at t = ", "cannot be written: [Errno 28]")
    series = sorted((folder / "surface").glob("*.vtu"))
    assert len(series) > 10
    assert all(file.read_text().rstrip().endswith("</VTKFile>") for file in series)
    energy, probe = times(folder, "energy"), times(folder, "probes/middle-1")
    assert energy[-1] == pytest.approx(probe[-1])


@pytest.mark.parametrize("small_disk", [60], indirect=True)
def test_a_full_disk_while_saving(small_disk: Path, tmp_path: Path) -> None:
    """The checkpoint before is whole, and what goes on from it is the run that never stopped."""
    whole, folder, filler = tmp_path / "whole", small_disk / "run", small_disk / "filler"
    assert flipflow(*run_words("quickstart", whole, SAVED)).returncode == 0
    before = FILLED.format(filler=str(filler))
    done = flipflow(*run_words("quickstart", folder, SAVED), before=before)
    failed(folder, done, "the checkpoint at t = 0.0057 s cannot be written: [Errno 28]")
    kept = sorted(checkpoint.name for checkpoint in (folder / "checkpoints").iterdir())
    assert kept == [f"{51:012d}", f"{54:012d}"]
    filler.unlink()
    done = flipflow("resume", str(folder))
    assert done.returncode == 0, done.stderr
    assert run_differences(whole, folder) == []


def test_a_limit_on_the_size_of_files(tmp_path: Path) -> None:
    """A write that fails where no reserve helps: the series are lost, the process is not.

    MPI, which LIGGGHTS needs, has files of its own that are larger.
    """
    folder = tmp_path / "run"
    before = (
        "import resource; from orchestrator.output.records import history\n"
        "history.RESERVE_BYTES = 4096\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))"
    )
    words = run_words("quickstart", folder, [*QUICK, "particles.solver=spheres"])
    done = flipflow(*words, before=before)
    assert done.returncode == 4, done.stderr
    said_plainly(done)
    assert "cannot be written: [Errno 27] File too large" in done.stderr


def test_a_summary_that_cannot_be_written(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    before = (
        "from orchestrator.run import ending\n"
        "def full(path, value): raise OSError(28, 'No space left on device')\n"
        "ending.summary.write_summary = full"
    )
    done = flipflow(*run_words("panel-cycle", folder, [*QUICK, "duration_s=0.01"]), before=before)
    assert done.returncode == 4, done.stderr
    said_plainly(done)
    assert f"No space left on device\nall else is in {folder}" in done.stderr
    assert times(folder, "energy")[-1] == pytest.approx(0.01)
