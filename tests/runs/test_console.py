"""The console: progress, help, and how soon it says them."""

from __future__ import annotations

import os
import pty
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.runs.outside import HANG_S, QUICK, ROOT, buffered, command, flipflow, run_words

AT_ONCE = "from orchestrator.run import progress; progress.LINE_EVERY_S = 0.0"
SHORT = [*QUICK, "duration_s=0.002"]
LINE = r"t = 0\.0010 of 0\.002 s, 50 %, \d+ s spent, about \d+ s left"


def test_progress_in_a_file_is_a_line_now_and_then(tmp_path: Path) -> None:
    done = flipflow(*run_words("quickstart", tmp_path / "run", SHORT), before=AT_ONCE)
    assert re.search(LINE, done.stderr), done.stderr
    log = (tmp_path / "run/run.log").read_text()
    assert re.search(LINE, log)
    for frame in ("driving", "driven"):  # their estimated motion, in the screen's terms
        assert f"frame {frame}: stroke " in done.stderr
        assert f"frame {frame}: stroke " in log
    assert done.stderr.startswith("Two panels "), "what the case shows comes first"
    assert "\x1b[" not in done.stderr
    assert done.stdout == ""


def test_progress_on_a_terminal_is_a_bar(tmp_path: Path) -> None:
    ours, theirs = pty.openpty()
    words = command(*run_words("quickstart", tmp_path / "run", SHORT), before=AT_ONCE)
    run = subprocess.Popen(
        words, cwd=ROOT, stderr=theirs, stdin=theirs, env=os.environ | {"TERM": "xterm-256color"}
    )
    os.close(theirs)
    shown = _all_of(ours)
    assert run.wait(timeout=HANG_S) == 0
    assert "simulating" in shown
    assert "100%" in shown
    assert "s left" not in shown
    assert re.search(LINE, (tmp_path / "run/run.log").read_text())


def _all_of(terminal: int) -> str:
    """Return what appears on a terminal until everybody has left it (Linux then says EIO)."""
    shown = b""
    try:
        while part := os.read(terminal, 4096):
            shown += part
    except OSError:
        pass
    os.close(terminal)
    return shown.decode()


def test_help_names_every_exit_code_and_manual() -> None:
    output = flipflow("--help").stdout
    for code in (
        "0 done",
        "1 an internal error",
        "2 the case",
        "3 a solver",
        "4 a solver",
        "129",
        "130",
        "143",
    ):
        assert code in output
    for page in re.findall(r"docs/[\w-]+\.md", output):
        assert (ROOT / page).is_file()
    for word in ("run", "check", "list"):
        assert flipflow(word, "--help").returncode == 0


HEAVY = frozenset(
    [
        "scipy",
        "h5py",
        "matplotlib",
        "pyvista",
        "vtk",
        "PIL",
        "jinja2",
        "pyarrow",
        "distributed",
        "mpi4py",
        "petsc4py",
        "dolfinx",
        "exudyn",
        "gmsh",
    ]
)
LOADED = "import atexit, sys; atexit.register(lambda: print('loaded:', *sys.modules, file=sys.stderr))"


@pytest.mark.parametrize(
    ("words", "used"),
    [
        (["--help"], set()),
        (["list", "{folder}"], set()),
        (["check", "{folder}/quickstart", "--level", "draft"], {"scipy", "mpi4py"}),
        # the modes of its panels' mesh limit the sync interval; where solvers are is seen by loading them
        (["check", "{folder}/quickstart"], {"scipy", "petsc4py", "mpi4py", "dolfinx", "exudyn"}),
    ],
)
def test_quick_commands_load_only_what_they_use(tmp_path: Path, words: list[str], used: set[str]) -> None:
    """Commands stay quick because they load no more; no clock is asked."""
    shutil.copytree(ROOT / "cases/quickstart", tmp_path / "quickstart")
    done = flipflow(*(word.format(folder=tmp_path) for word in words), before=LOADED)
    assert done.returncode == 0, done.stderr
    loaded = {name.split(".")[0] for name in done.stderr.split("loaded:")[1].split()}
    assert loaded & HEAVY <= used
    if words == ["--help"]:
        assert not loaded & {"numpy", "pydantic"}


def test_a_folder_s_name_commands_no_terminal(tmp_path: Path) -> None:
    folder = tmp_path / "red \x1b[31m\x1b]0;owned\x07"
    done = flipflow(*run_words("quickstart", folder, SHORT))
    assert done.returncode == 0, done.stderr
    for text in (done.stderr, (folder / "run.log").read_text()):
        assert "\x1b" not in text
        assert "\x07" not in text
        assert r"red \x1b[31m\x1b]0;owned\x07" in text
    done = flipflow(*run_words("quickstart", folder, SHORT))
    assert done.returncode == 2
    assert "\x1b" not in done.stderr
    assert "exists already" in done.stderr


def test_progress_on_a_terminal_that_draws_nothing_is_lines(tmp_path: Path) -> None:
    ours, theirs = pty.openpty()
    words = command(*run_words("quickstart", tmp_path / "run", SHORT), before=AT_ONCE)
    run = subprocess.Popen(words, cwd=ROOT, stderr=theirs, stdin=theirs, env=os.environ | {"TERM": "dumb"})
    os.close(theirs)
    shown = _all_of(ours)
    assert run.wait(timeout=HANG_S) == 0
    assert re.search(LINE, shown)


def test_nobody_reads_what_is_said(tmp_path: Path) -> None:
    """A pipe that is closed at its other end, as by ``| head``, is no reason to stop."""
    read, write = os.pipe()
    os.close(read)
    words = command(*run_words("quickstart", tmp_path / "run", SHORT), before=AT_ONCE)
    run = subprocess.Popen(words, cwd=ROOT, stderr=write, stdout=write, env=buffered())
    os.close(write)
    assert run.wait(timeout=HANG_S) == 0
    assert re.search(LINE, (tmp_path / "run/run.log").read_text())
