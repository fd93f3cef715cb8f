"""Runs in processes of their own, and short ones in folders that are removed afterwards."""

from __future__ import annotations

import math
import resource
import signal
import subprocess
import tempfile
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

from orchestrator.output.results.run_reader import RunReader
from orchestrator.output.subprocesses import python

MAIN = "from orchestrator.cli.main import main; main()"
ONE_THREAD = {"OMP_NUM_THREADS": "1"}  # environment of a run: others run beside it


def run_words(case: Path, level: str, sets: Sequence[str], out: Path) -> tuple[str, ...]:
    """Return the command that runs a case in a folder."""
    options = [word for each in sets for word in ("--set", each)]
    at_level = ["--level", level] if level else []
    return ("run", str(case.resolve()), *at_level, *options, "--trial-s", "0", "--out", str(out.resolve()))


class NoResult(Exception):
    """An error of a run that gave no result; the message says why."""


def run_in_scratch(
    case: Path,
    level: str,
    sets: Sequence[str],
    patience_s: float | None = None,
    processor_s: float = math.inf,
) -> dict[str, Any]:
    """Make a run in a folder that is removed afterwards, and return its summary.

    Raises NoResult where the run leaves no summary, takes longer than ``patience_s``, or takes more processor
    time than ``processor_s``, in whole seconds.
    """
    more: dict[str, Any] = {}
    if math.isfinite(processor_s):
        limit_s = max(1, math.ceil(processor_s))
        limits_s = (limit_s, limit_s + 1)  # then asked to end, then killed
        more["preexec_fn"] = partial(resource.setrlimit, resource.RLIMIT_CPU, limits_s)
    with tempfile.TemporaryDirectory(prefix="flipflow-trial-") as scratch:
        folder = Path(scratch) / "run"
        words = ("-c", MAIN, *run_words(case, level, sets, folder))
        try:
            done = python(*words, alone=True, capture_output=True, env=ONE_THREAD, timeout=patience_s, **more)
        except subprocess.TimeoutExpired:
            raise NoResult(f"took more than {patience_s:g} s and was ended") from None
        if done.returncode in (-signal.SIGXCPU, -signal.SIGKILL) and more:
            raise NoResult(f"took more than {limit_s} s of processor time and was ended")
        try:
            return dict(RunReader(folder).summary)
        except (OSError, ValueError):
            last = done.stderr.strip().splitlines()[-1:] or [f"exit code {done.returncode}"]
            raise NoResult(f"left nothing: {last[0]}") from None
