"""flipflow from outside: a process of its own, as a user starts it, and the folder it leaves."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TextIO

import h5py
import numpy as np
import pytest
from markupsafe import escape

from orchestrator.output.report.page import Film, page
from orchestrator.output.results.compute import compute_results

ROOT = Path(__file__).parents[2]
HANG_S = 240  # nothing here takes so long; a guard against processes that wait for ever
EVENTS = ("fed", "removed")  # tables with a row for each particle
QUICK = ("output.pictures=false",)
ENDED_S = 10.0  # every rank has ended by then
needs_mpirun = pytest.mark.skipif(shutil.which("mpirun") is None, reason="no mpirun")
MPIRUN = ("mpirun", "--allow-run-as-root", "--oversubscribe", "-n")


def buffered() -> dict[str, str]:
    """The environment with standard error buffered, as it is unless somebody wishes otherwise."""
    return {name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"}


def command(*words: str, before: str = "", ranks: int = 1) -> list[str]:
    """``flipflow WORDS`` in a fresh process (or ``ranks`` of them under mpirun); ``before`` is
    Python that is run first, to break something on purpose."""
    main = f"{before}\nfrom orchestrator.cli.main import main\nmain()\n"
    launcher = [*MPIRUN, str(ranks)] if ranks > 1 else []
    return [*launcher, sys.executable, "-c", main, *words]


def run_words(case: str, out: Path, sets: Sequence[str] = QUICK) -> list[str]:
    """``run`` a case of this project at its draft level; a path is run without a level."""
    place = [case] if "/" in case else [f"cases/{case}", "--level", "draft"]
    return ["run", *place, "--out", str(out), *(word for key in sets for word in ("--set", key))]


def flipflow(*words: str, before: str = "", ranks: int = 1) -> subprocess.CompletedProcess[str]:
    """Runs to the end; the exit code and what was said."""
    return subprocess.run(
        command(*words, before=before, ranks=ranks),
        cwd=ROOT,
        env=_environment(),
        capture_output=True,
        encoding="utf-8",
        timeout=HANG_S,
        check=False,
    )


def started(
    *words: str, before: str = "", ranks: int = 1, cwd: Path = ROOT, output: TextIO | int = subprocess.PIPE
) -> subprocess.Popen[str]:
    """Starts and returns at once; what it says can be read at the end (64 kB at most), or is
    written to the file ``output``."""
    return subprocess.Popen(
        command(*words, before=before, ranks=ranks),
        cwd=cwd,
        env=_environment(),
        stdout=output,
        stderr=output,
        encoding="utf-8",
    )


def _environment() -> dict[str, str]:
    """One thread for each process, and the width of a terminal that does not wrap."""
    return os.environ | {"OMP_NUM_THREADS": "1", "COLUMNS": "100"}


def of(run: Path) -> list[int]:
    """The ids of all processes that were started for this folder."""
    result = subprocess.run(["pgrep", "-f", str(run)], capture_output=True, encoding="utf-8", check=False)
    return [int(word) for word in result.stdout.split()]


def wait_until(true: Callable[[], bool]) -> None:
    end = time.monotonic() + HANG_S
    while not true():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.05)


def summary(folder: Path) -> dict[str, Any]:
    table: dict[str, Any] = json.loads((folder / "summary.json").read_text())
    return table


def times(folder: Path, group: str) -> Any:
    with h5py.File(folder / "history.h5") as history:
        return history[f"{group}/time_s"][:]


def left_usable(folder: Path, status: str) -> dict[str, Any]:
    """Check what every run that started must leave: a summary with its status, and time series that are
    whole up to the last output time. Returns the summary."""
    table = summary(folder)
    assert table["status"] == status
    with h5py.File(folder / "history.h5") as history:
        for name, kind in history.items():
            if name == "results":  # no time series
                continue
            for group in kind.values() if "time_s" not in kind else [kind]:
                lengths = {len(series) for series in group.values()}
                assert len(lengths) == 1
                steps = np.diff(group["time_s"][:])
                assert (steps >= 0 if name in EVENTS else steps > 0).all()
    return table


def has_results(folder: Path) -> dict[str, Any]:
    """Asserts what every run that came to its end must have: results of which none failed, no
    error in its log, and a report, which is made here without its film.  Returns the results."""
    results: dict[str, Any] = summary(folder)["results"]
    assert results["failed"] == {}
    assert " ERROR " not in (folder / "run.log").read_text()
    text = page(folder, compute_results(folder), lambda *_: Film(b"", reason="left out by the test"))
    assert "</html>" in text
    for part, why in results["missing"].items():
        assert part in text
        assert str(escape(why)) in text
    return results


def said_plainly(done: subprocess.CompletedProcess[str]) -> None:
    """No traceback, no warning of Python: words for a user."""
    for foreign in ("Traceback", "Warning:", "Exception ignored", "Logging error"):
        assert foreign not in done.stderr, done.stderr
