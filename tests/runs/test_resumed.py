"""A run that is resumed is, to the last bit, the run that never stopped."""

from __future__ import annotations

import os
import random
import shutil
import signal
import subprocess
import time
from collections.abc import Sequence
from pathlib import Path

import pytest

from orchestrator.cli import launch
from orchestrator.cli.launch import resume
from orchestrator.output import checkpoints
from tests.runs.outside import HANG_S, QUICK, ROOT, flipflow, run_words, started, summary, wait_until
from tests.runs.same_run import run_differences

UNSAVED = ["checkpoint.every_s=0", "checkpoint.wall_min=0"]  # but at the end
OFTEN = ["checkpoint.every_s=0.0003"]
# 30 pieces of coal fall onto two panels from 1 ms on; 120 sync intervals
FEW = ["bed.blocks.coal.count=30", "duration_s=0.012", "output.interval_s=0.003"]
QUICKSTART = ["quickstart", *QUICK, *FEW]
STICKY = [*QUICKSTART, "contacts.1.work_of_adhesion_J_per_m2=5", "contacts.2.work_of_adhesion_J_per_m2=5"]
# LIGGGHTS, fed from the start, with openings and exits; periodic sides
FED = ["ffs0827-slice", *QUICK, "duration_s=0.05", "output.interval_s=0.01"]
FED += ["bed.feeds.coal.start_s=0.0"]
REPEATED = [*FED, "coupling.scheme=aitken"]
# LIGGGHTS, the sheet and Exudyn
DEAR = [
    *QUICKSTART,
    "particles.solver=liggghts",
    "panel.solver=sheet",
    "panel.cells=[8, 3]",
    "frames.solver=exudyn",
]
ROBIN = [*DEAR, "coupling.scheme=robin"]


def run(folder: Path, case: Sequence[str], sets: Sequence[str]) -> Path:
    name, *changes = case
    code = launch.run(ROOT / "cases" / name, "draft", folder, [*changes, *sets])
    assert code == launch.DONE
    return folder


def checkpoint_folders(folder: Path) -> list[Path]:
    """Return the checkpoint folders in order of time."""
    return sorted(
        checkpoint for checkpoint in (folder / "checkpoints").iterdir() if checkpoint.name.isdigit()
    )


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The quickstart's run, not stopped, not saved."""
    return run(tmp_path_factory.mktemp("whole") / "run", QUICKSTART, UNSAVED)


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same, saved at 0.0077 s and at its end."""
    folder = tmp_path_factory.mktemp("saved") / "run"
    return run(folder, QUICKSTART, ["checkpoint.every_s=0.0077"])


@pytest.fixture
def stopped(saved: Path, tmp_path: Path) -> Path:
    """A copy of that, as if it had been killed after 0.0077 s."""
    folder = Path(shutil.copytree(saved, tmp_path / "stopped"))
    shutil.rmtree(checkpoint_folders(folder)[-1])
    return folder


def test_saving_changes_nothing(whole: Path, saved: Path) -> None:
    assert [save.name for save in checkpoint_folders(saved)] == [f"{77:012d}", f"{120:012d}"]
    assert run_differences(whole, saved) == []


def test_it_is_the_run_that_never_stopped(whole: Path, stopped: Path) -> None:
    assert resume(stopped, []) == launch.DONE
    assert run_differences(whole, stopped) == []


@pytest.mark.solver
@pytest.mark.slow
@pytest.mark.parametrize(
    "case", [STICKY, FED, REPEATED, DEAR, ROBIN], ids=["sticky", "fed", "repeated", "dear", "robin"]
)
def test_so_it_is_with_other_physics_and_solvers(tmp_path: Path, case: list[str]) -> None:
    whole = run(tmp_path / "whole", case, UNSAVED)
    part_s = "0.0071" if QUICKSTART[0] in case else "0.031"
    stopped = run(tmp_path / "stopped", case, [f"checkpoint.every_s={part_s}"])
    shutil.rmtree(checkpoint_folders(stopped)[-1])
    assert resume(stopped, []) == launch.DONE
    assert run_differences(whole, stopped) == []


def test_a_finished_run_may_go_on_to_a_later_end(whole: Path, tmp_path: Path) -> None:
    longer = run(tmp_path / "longer", QUICKSTART, [*UNSAVED, "duration_s=0.006"])
    assert resume(longer, ["duration_s=0.012"]) == launch.DONE
    assert run_differences(whole, longer) == []


def test_pages_and_pictures_of_the_former_end_are_gone(stopped: Path) -> None:
    """The pages would stand beside the results of the later end."""
    own = stopped / "notes.png"
    for file in (stopped / "report.html", stopped / "energy.png", own):
        file.touch()
    assert resume(stopped, ["output.pictures=false"]) == launch.DONE
    assert [*stopped.glob("*.html"), *stopped.glob("*.png")] == [own]


@pytest.mark.parametrize("torn", ["cut", "changed", "half"])
def test_a_torn_save_is_left_for_the_one_before(whole: Path, saved: Path, tmp_path: Path, torn: str) -> None:
    folder = Path(shutil.copytree(saved, tmp_path / "torn"))
    last = checkpoint_folders(folder)[-1]
    arrays, about = last / "rank-0.npz", last / "checkpoint.json"
    match torn:
        case "cut":
            arrays.write_bytes(arrays.read_bytes()[:-100])
        case "changed":
            changed = bytearray(arrays.read_bytes())
            changed[len(changed) // 2] ^= 1  # a single bit
            arrays.write_bytes(changed)
        case "half":
            about.write_text(about.read_text()[:-20])
    assert resume(folder, []) == launch.DONE
    assert f"{last}" in (folder / "run.log").read_text()
    assert "going on from t = 0.0077 s" in (folder / "run.log").read_text()
    assert run_differences(whole, folder) == []


def test_a_save_of_another_flipflow_is_said_to_be_one(
    stopped: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """One that knew nothing of what the particles need today; nothing of the save is lost."""
    monkeypatch.setattr("adapters.particles.liggghts.ledger.ParticleLedger.STATE", ("_mass_kg", "_periodic"))
    assert resume(stopped, []) == launch.FAILED
    output = capsys.readouterr().err
    assert "cannot be put back (KeyError: 'periodic'): it was saved by another flipflow" in output
    monkeypatch.undo()
    assert resume(stopped, []) == launch.DONE


def test_a_save_that_names_a_file_elsewhere_is_torn(
    saved: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The file would be written over."""
    folder, other = Path(shutil.copytree(saved, tmp_path / "evil")), tmp_path / "mine.txt"
    other.write_text("mine")
    for save in checkpoint_folders(folder):
        about = save / "checkpoint.json"
        about.write_text(about.read_text().replace('"history.h5"', '"../../../mine.txt"'))
    assert resume(folder, []) == launch.WRONG
    assert "names a file elsewhere: ../../../mine.txt" in capsys.readouterr().err
    assert other.read_text() == "mine"


@pytest.mark.parametrize("key", ["ranks", "commit", "sync_points", "case"])
def test_a_save_that_does_not_say_all_of_itself_is_torn(
    saved: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], key: str
) -> None:
    """The one before is taken; if there is none, the reason is said."""
    folder = Path(shutil.copytree(saved, tmp_path / "run"))
    for left, save in enumerate(reversed(checkpoint_folders(folder))):
        about = save / "checkpoint.json"
        about.write_text(about.read_text().replace(f'"{key}"', '"another"'))
        assert (left == 0) == (checkpoints.find_newest(folder) is not None)
    assert resume(folder, []) == launch.WRONG
    output = capsys.readouterr().err
    assert "no checkpoint that is whole:\n" in output
    assert f"checkpoint.json does not say '{key}'\n" in output


def test_a_run_on_a_disk_that_is_read_only(
    saved: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    disk = tmp_path / "disk"
    disk.mkdir()
    if os.geteuid() != 0 or subprocess.run(["mount", "-t", "tmpfs", "tmpfs", disk]).returncode:
        pytest.skip("only root can mount a disk")
    try:
        shutil.copytree(saved, disk / "run")
        subprocess.run(["mount", "-o", "remount,ro", disk], check=True)
        assert resume(disk / "run", ["duration_s=0.013"]) == launch.WRONG
        output = capsys.readouterr().err
        assert "Read-only file system" in output
        assert str(disk) in output
        assert "mistake" not in output
    finally:
        subprocess.run(["umount", disk], check=True)


def test_another_case_is_refused_with_all_that_changed(
    stopped: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = {file: file.read_bytes() for file in stopped.rglob("*") if file.is_file()}
    sets = ["duration_s=0.005", "coupling.sync_interval_s=2e-4", "output.series_s=1e-3"]
    sets += ["output.shapes_s=1e-3", "output.interval_s=1e-3", "output.cut_size_m=0.01"]
    assert resume(stopped, sets) == launch.WRONG
    output = capsys.readouterr().err
    assert "duration_s: 0.012 was saved, now it is 0.005" in output  # before the save
    assert "coupling.sync_interval_s: 0.0001 was saved, now it is 0.0002" in output
    assert "output.shapes_s: 0.0 was saved, now it is 0.001" in output
    assert "output.series_s: 0.0 was saved, now it is 0.001" in output  # accelerations need even steps
    assert "output.interval_s: 0.003 was saved, now it is 0.001" in output
    assert "cut_size_m" not in output
    assert {file: file.read_bytes() for file in stopped.rglob("*") if file.is_file()} == before


def test_what_is_no_run_or_was_not_saved_is_refused(
    stopped: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert resume(tmp_path, []) == launch.WRONG
    assert "is not the folder of a run" in capsys.readouterr().err
    provenance = stopped / "provenance.json"
    whole = provenance.read_bytes()
    for damaged in (b"", b"[1]", b"\xff", b'{"resumed": 1}'):
        provenance.write_bytes(damaged)
        assert resume(stopped, []) == launch.WRONG
        assert "provenance.json: is damaged" in capsys.readouterr().err
    provenance.write_bytes(whole)
    shutil.rmtree(stopped / "checkpoints")
    assert resume(stopped, []) == launch.WRONG
    assert "nothing was saved" in capsys.readouterr().err


# the run waits after an output, so that the signal meets it before its end
WAITING = """
import time
import meshio
write = meshio.write
def wait(file, *others, **options):
    write(file, *others, **options)
    if file.name == "particles_00001.vtu":
        time.sleep(2)
meshio.write = wait
"""


@pytest.mark.process
@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM"])
def test_told_to_stop_it_saves_and_says_how_to_go_on(whole: Path, tmp_path: Path, name: str) -> None:
    folder, number = tmp_path / "run", getattr(signal, name)
    words = run_words(QUICKSTART[0], folder, [*QUICKSTART[1:], *UNSAVED])
    stopping = started(*words, before=WAITING)
    wait_until(lambda: (folder / "particles" / "particles_00001.vtu").exists())
    stopping.send_signal(number)
    output = stopping.communicate(timeout=HANG_S)[1]
    assert stopping.returncode == 128 + number, output
    assert f"to go on: flipflow resume {folder}\n" in output
    done = flipflow("resume", str(folder))
    assert done.returncode == 0, done.stderr
    assert run_differences(whole, folder) == []


# the first rank waits where everything is written but the name that makes a save one
STUCK = """
import pathlib, time
from orchestrator.output import checkpoints
sync = checkpoints._sync
def stuck(path):
    if path.is_dir() and path.name == ".{at:012d}":
        pathlib.Path({marker!r}).touch()
        time.sleep(300)
    return sync(path)
checkpoints._sync = stuck
"""


@pytest.mark.process
def test_killed_inside_a_save_it_goes_on_from_the_one_before(whole: Path, tmp_path: Path) -> None:
    folder, marker = tmp_path / "run", tmp_path / "stuck"
    words = run_words(QUICKSTART[0], folder, [*QUICKSTART[1:], *OFTEN])
    killed = started(*words, before=STUCK.format(at=60, marker=str(marker)))
    wait_until(marker.exists)
    killed.kill()
    killed.communicate(timeout=HANG_S)
    done = flipflow("resume", str(folder))
    assert done.returncode == 0, done.stderr
    assert "going on from t = 0.0057 s" in done.stderr
    assert run_differences(whole, folder) == []


@pytest.mark.process
@pytest.mark.slow
def test_killed_again_and_again_it_comes_to_the_same_end(whole: Path, tmp_path: Path) -> None:
    """The run is killed at four random instants, half of them in the midst of a save."""
    folder, chance = tmp_path / "run", random.Random(4)
    words = run_words(QUICKSTART[0], folder, [*QUICKSTART[1:], *OFTEN])
    for _ in range(4):
        there = newest(folder)
        going = started(*words)
        wait_until(lambda: newest(folder) != there)  # noqa: B023
        time.sleep(chance.uniform(0.0, 0.3))
        assert going.poll() is None
        going.kill()
        going.communicate(timeout=HANG_S)
        words = ["resume", str(folder)]
    done = flipflow(*words)
    assert done.returncode == 0, done.stderr
    assert run_differences(whole, folder) == []


def newest(folder: Path) -> str:
    return (
        checkpoint_folders(folder)[-1].name
        if (folder / "checkpoints").is_dir() and checkpoint_folders(folder)
        else ""
    )


def test_what_was_left_out_stays_named(tmp_path: Path) -> None:
    """The folder's case has no motor, contact friction or run-up any more."""
    case = ["motor-start", *QUICK, "effects=[]", "output.interval_s=0.01"]
    folder = run(tmp_path / "run", case, ["duration_s=0.02"])
    first = summary(folder)
    assert resume(folder, ["duration_s=0.03"]) == launch.DONE
    last = summary(folder)
    assert {"motor-slip", "run-up", "sliding-friction"} <= set(first["left_out"])
    assert last["left_out"] == first["left_out"]
    for name in first["left_out"]:
        assert last["effects"][name]["before"] == first["effects"][name]["before"]
