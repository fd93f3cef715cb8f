"""The folder of a run that a stranger sent: whatever lies in it, no command touches a file elsewhere, waits
for ever, or lets it control the terminal."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import FrameType

import h5py
import numpy as np
import pytest
from click.testing import Result
from typer.testing import CliRunner

from flipflow import FolderUnusable, open_run
from orchestrator.cli import launch
from orchestrator.cli.launch import FAILED, WRONG
from orchestrator.cli.main import app
from orchestrator.output import checkpoints
from tests.runs.outside import QUICK, ROOT

WAITS_S = 20  # a command that is refused takes a tenth of a second
SHORT = ["duration_s=0.01", "checkpoint.every_s=0.004", "output.interval_s=0.002"]
DEEP = "[" * 200_000 + "]" * 200_000
EVIL = "\x1b]0;owned\x07\x9b2J"


@dataclass(frozen=True)
class Stranger:
    """A home, and the folder of a run beside it that a stranger made."""

    home: Path
    run: Path

    def home_now(self, but: Path | None = None) -> dict[Path, str]:
        """Every file of the home and its checksum, but for those in a folder."""
        files = (file for file in self.home.rglob("*") if file.is_file() and but not in file.parents)
        return {file: hashlib.sha256(file.read_bytes()).hexdigest() for file in files}


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run with two checkpoints."""
    folder = tmp_path_factory.mktemp("whole") / "run"
    assert launch.run(ROOT / "cases/panel-cycle", "draft", folder, [*QUICK, *SHORT]) == launch.DONE
    return folder


@pytest.fixture
def stranger(whole: Path, tmp_path: Path) -> Stranger:
    home = tmp_path / "home"
    for name in (".bashrc", ".ssh/authorized_keys", "shapes/old.vtu", "notes/000000000099/mine.txt"):
        (home / name).parent.mkdir(parents=True, exist_ok=True)
        (home / name).write_text("mine")
    return Stranger(home, Path(shutil.copytree(whole, home / "downloads/run")))


def last_checkpoint(run: Path) -> Path:
    return max((run / "checkpoints").iterdir())


def forge(checkpoint: Path, change: Callable[[dict[str, dict[str, str]]], object]) -> None:
    """Changes ``checkpoint.json``, and makes its checksum of history.h5 right again."""
    about = json.loads((checkpoint / "checkpoint.json").read_text())
    history = hashlib.sha256((checkpoint / "history.h5").read_bytes()).hexdigest()
    about["sha256"] |= {"history.h5": history}
    change(about)
    (checkpoint / "checkpoint.json").write_text(json.dumps(about))


def link_beside_history(it: Stranger) -> None:
    for checkpoint in (it.run / "checkpoints").iterdir():
        (checkpoint / "history.h5").write_text("the stranger's")
        forge(checkpoint, lambda about: None)
    (it.run / ".history.h5").symlink_to(it.home / ".bashrc")


def link_beside_page(it: Stranger) -> None:
    (it.run / ".report.html").symlink_to(it.home / ".ssh/authorized_keys")


def checkpoints_elsewhere(it: Stranger) -> None:
    """Folders beside it whose names are later sync points."""
    shutil.copytree(last_checkpoint(it.run), it.home / "notes" / last_checkpoint(it.run).name)
    shutil.rmtree(it.run / "checkpoints")
    (it.run / "checkpoints").symlink_to("../../notes")


def files_elsewhere(it: Stranger) -> None:
    """Replace the folder of surfaces by a link to a folder elsewhere."""
    shutil.rmtree(it.run / "surface")
    (it.run / "surface").symlink_to(it.home / "shapes")


def device_in_checksums(it: Stranger) -> None:
    for checkpoint in (it.run / "checkpoints").iterdir():
        forge(checkpoint, lambda about: about["sha256"].update({"/dev/zero": ""}))


def holes_as_arrays(it: Stranger) -> None:
    """A terabyte, which an archive keeps in some bytes."""
    for checkpoint in (it.run / "checkpoints").iterdir():
        os.truncate(checkpoint / "rank-0.npz", 10**12)


def pipe_as_log(it: Stranger) -> None:
    (it.run / "run.log").unlink()
    os.mkfifo(it.run / "run.log")


def data_elsewhere(it: Stranger) -> None:
    """HDF5 keeps the numbers of a dataset in any file."""
    for checkpoint in (it.run / "checkpoints").iterdir():
        with h5py.File(checkpoint / "history.h5", "a") as history:
            before = history["energy/time_s"][:]
            made = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
            made.set_external(os.fsencode(it.home / ".bashrc"), 0, h5py.h5f.UNLIMITED)
            space = h5py.h5s.create_simple(before.shape, (h5py.h5s.UNLIMITED,))
            del history["energy/time_s"]
            kind = h5py.h5t.py_create(np.dtype(float))
            h5py.h5d.create(history.id, b"energy/time_s", kind, space, made)
        forge(checkpoint, lambda about: None)


LINKS = [link_beside_history, link_beside_page, checkpoints_elsewhere, files_elsewhere, pipe_as_log]
COMMANDS = {
    "resume": ["resume", "{run}", "--set", "duration_s=0.012"],
    "report": ["report", "{run}"],
    "compare": ["compare", "{run}", "{other}"],
    "results": ["results", "{run}"],
    "sweep": ["study", "sweep", "{case}", "--vary", "duration_s=0.01,0.02", "--out", "{downloads}"],
    "from_run": ["check", "{case}", "--set", "bed.from_run={run}"],
}


@contextmanager
def in_time() -> Iterator[None]:
    """Fail where something waits for ever."""

    def fail(number: int, frame: FrameType | None) -> None:
        raise AssertionError(f"took more than {WAITS_S} s")

    before = signal.signal(signal.SIGALRM, fail)
    signal.alarm(WAITS_S)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def flipflow(it: Stranger, *words: str) -> Result:
    places = {"run": it.run, "downloads": it.run.parent, "case": ROOT / "cases/panel-cycle"}
    with in_time():
        done = CliRunner().invoke(
            app, [word.format(**places, other=it.run.with_name("other")) for word in words]
        )
    for text in (done.stdout, done.stderr):
        assert all(char.isprintable() or char in "\r\n" for char in text), repr(text)
    return done


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("spoil", LINKS, ids=lambda spoil: spoil.__name__)
def test_links_and_pipes_are_refused_by_every_command(
    stranger: Stranger, spoil: Callable[[Stranger], None], command: str
) -> None:
    spoil(stranger)
    if command == "from_run":  # it is refused by the place of the particles, not by their lack
        (stranger.run / "particles.pvd").write_text("<VTKFile/>")
    before = stranger.home_now()
    done = flipflow(stranger, *COMMANDS[command])
    assert stranger.home_now() == before
    assert done.exit_code == WRONG, done.stderr
    assert "holds links, pipes or devices" in done.stderr


FORGED = {device_in_checksums: "elsewhere", data_elsewhere: "elsewhere", holes_as_arrays: "hardly any data"}


@pytest.mark.parametrize("spoil", FORGED, ids=lambda spoil: spoil.__name__)
def test_a_forged_checkpoint_reaches_nothing_elsewhere_and_ends(
    stranger: Stranger, spoil: Callable[[Stranger], None]
) -> None:
    spoil(stranger)
    before = stranger.home_now(but=stranger.run)
    done = flipflow(stranger, *COMMANDS["resume"])
    assert stranger.home_now(but=stranger.run) == before
    assert done.exit_code == WRONG, done.stderr
    assert FORGED[spoil] in done.stderr


READERS = {
    "summary.json": ["report", "compare", "results"],
    "provenance.json": ["resume", "report"],
    "checkpoints/*/checkpoint.json": ["resume"],
}


@pytest.mark.parametrize(("name", "command"), [(name, c) for name, those in READERS.items() for c in those])
def test_json_that_is_nested_too_deeply_is_refused(stranger: Stranger, name: str, command: str) -> None:
    shutil.copytree(stranger.run, stranger.run.with_name("other"))
    for file in stranger.run.glob(name):
        file.write_text(DEEP)
    before = stranger.home_now()
    done = flipflow(stranger, *COMMANDS[command])
    assert done.exit_code == WRONG, done.stderr
    assert stranger.home_now() == before


@pytest.mark.parametrize("words", [["compare"], ["compare", "--json"], ["results"], ["results", "--json"]])
def test_words_of_a_summary_do_not_control_the_terminal(stranger: Stranger, words: list[str]) -> None:
    folders = [stranger.run.with_name(name) for name in ("one", "two")]
    for size, folder in enumerate(folders):
        shutil.copytree(stranger.run, folder)
        summary = json.loads((folder / "summary.json").read_text())
        summary |= {"case": EVIL, "level": EVIL, "status": EVIL}
        summary["results"] = {EVIL: {EVIL: size}, "motion": {"reason": EVIL}}
        (folder / "summary.json").write_text(json.dumps(summary))
        with (folder / "case.toml").open("a") as case:
            case.write(f'\n["\\u001b[2J"]\nword = "{size}\\u001b[2J"\n')
    command, *options = words
    done = flipflow(stranger, command, *map(str, folders), *options)
    assert done.exit_code == 0, done.stderr
    assert "owned" in done.stdout + done.stderr


@pytest.mark.parametrize("version", [None, 1, 99])
def test_a_checkpoint_of_another_format_is_kept(stranger: Stranger, version: int | None) -> None:
    """The message names the flipflow that can go on with it (docs/reliability.md)."""
    checkpoint = last_checkpoint(stranger.run)
    forge(checkpoint, lambda about: about.update(format_version=version, provenance={"commit": "0ld"}))
    before = stranger.home_now()
    done = flipflow(stranger, *COMMANDS["resume"])
    assert done.exit_code == FAILED, done.stderr
    assert f"this flipflow reads format {checkpoints.FORMAT}" in done.stderr
    assert "its commit is 0ld" in done.stderr
    log = stranger.run / "run.log"
    assert stranger.home_now() | {log: ""} == before | {log: ""}


def test_words_of_a_path_do_not_control_the_terminal(stranger: Stranger) -> None:
    (stranger.run / EVIL).symlink_to(stranger.home)
    for command in ("resume", "report", "results"):
        done = flipflow(stranger, *COMMANDS[command])
        assert done.exit_code == WRONG
        assert f"{stranger.run}/\\x1b]0;owned\\x07\\x9b2J is a link" in done.stderr


def test_python_refuses_it_too(stranger: Stranger) -> None:
    link_beside_page(stranger)
    with pytest.raises(FolderUnusable, match="links"):
        open_run(stranger.run)


def test_a_folder_may_be_reached_by_a_link(stranger: Stranger) -> None:
    """A user's own, such as to a larger disk."""
    (stranger.home / "runs").symlink_to(stranger.run.parent)
    done = flipflow(stranger, "resume", str(stranger.home / "runs/run"), "--set", "duration_s=0.012")
    assert done.exit_code == 0, done.stderr
