"""flipflow in a child of this process: as from outside, but without the seconds of starting.

A child has its own limits of time and memory, may crash or hang, and is looked at from outside:
exit code, what it said, and what it wrote.  What the commands import only when they are called is
imported here, once for all children.
"""

from __future__ import annotations

import io
import os
import resource
import signal
import sys
import time
import traceback
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

from orchestrator.cli import main as cli
from orchestrator.output.report import page
from orchestrator.output.report.page import Film
from orchestrator.run import ending, run

MEMORY_BYTES = 5 * 1024**3 // 2  # of addresses, besides those of the process that asks
PROCESSOR_S = 60  # the dearest check, of 140 000 triangles, takes 15
HANG_S = 600.0  # of the clock on the wall: the machine may have other work
INTERVALS = 3  # of a run


@dataclass(frozen=True)
class Ended:
    """``code`` as a shell has it (128 + signal where it was killed, for its limit of time, too)."""

    code: int
    out: str
    err: str
    written: frozenset[str]


def flipflow(words: Sequence[str], place: Path) -> Ended:
    """Runs ``flipflow WORDS`` in ``place``, a run for three intervals only.  ``written``: what is
    in the folder afterwards and was not before, or has changed."""
    before, started = _files(place), time.monotonic()
    child = os.fork()
    if child == 0:
        _be(words, place)
    code = _waited(child, started + HANG_S)
    texts = [_taken(place.parent / name) for name in ("out", "err")]
    return Ended(code, *texts, frozenset(_files(place) - before))


def _be(words: Sequence[str], place: Path) -> None:
    """The child: never returns."""
    code = 1
    try:
        os.setsid()
        for number, name in ((1, "out"), (2, "err")):
            os.dup2(os.open(place.parent / name, os.O_WRONLY | os.O_CREAT | os.O_TRUNC), number)
        sys.stdout = io.TextIOWrapper(io.FileIO(1, "w"), encoding="utf-8")
        sys.stderr = io.TextIOWrapper(io.FileIO(2, "w"), "utf-8", "backslashreplace")
        os.chdir(place)
        (place.parent / "tmp").mkdir(exist_ok=True)
        os.environ |= {"TMPDIR": str(place.parent / "tmp"), "COLUMNS": "100"}
        most_bytes = _addresses_bytes() + MEMORY_BYTES
        resource.setrlimit(resource.RLIMIT_AS, (most_bytes, most_bytes))
        resource.setrlimit(resource.RLIMIT_CPU, (PROCESSOR_S, PROCESSOR_S))
        code = _main(words)
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)


def _addresses_bytes() -> int:
    """Return the size of this process's address space."""
    return int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()


def _main(words: Sequence[str]) -> int:
    intervals = run.intervals
    run.intervals = lambda *times: islice(intervals(*times), INTERVALS)
    ending._draw = lambda folder: None
    page.make_film = lambda *_: Film(b"", reason="not drawn")
    sys.argv = ["flipflow", *words]
    try:
        cli.main()
    except SystemExit as ended:
        return ended.code if isinstance(ended.code, int) else 1
    return 0


def _waited(child: int, end: float) -> int:
    """The exit code; a child that takes too long is killed."""
    pause_s = 0.002
    while True:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            code = os.waitstatus_to_exitcode(status)
            return code if code >= 0 else 128 - code
        if time.monotonic() > end:
            os.killpg(child, signal.SIGKILL)
        time.sleep(pause_s)
        pause_s = min(2 * pause_s, 0.05)


def _taken(file: Path) -> str:
    text = file.read_text(encoding="utf-8", errors="replace")
    file.unlink()
    return text


def _files(place: Path) -> set[str]:
    files = set()
    for folder, _, names in os.walk(place):
        for name in names:
            path = os.path.join(folder, name)
            at = os.lstat(path)
            files.add(f"{os.path.relpath(path, place)} {at.st_size} {at.st_mtime_ns}")
    return files
