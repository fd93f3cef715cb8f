"""A run that Python makes, waits for, and reads."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from html import escape
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from orchestrator.case.file.errors import visible
from orchestrator.case.file.folder import FolderUnusable, admit
from orchestrator.case.provenance import read_provenance
from orchestrator.figures.results import why_transient
from orchestrator.figures.short_names import SHORT_NAMES, Value, named, value_at
from orchestrator.output.records import trust
from orchestrator.output.records.run_folder import SUMMARY
from orchestrator.output.results.run_reader import RunReader
from orchestrator.run.progress import ProgressReport, parse_report
from orchestrator.studies.points import MAIN

if TYPE_CHECKING:
    import pandas

CRASHES = {signal.SIGSEGV, signal.SIGABRT, signal.SIGFPE, signal.SIGBUS, signal.SIGILL}
"""The signals by which a program ends itself."""
REFUSED = 2  # exit code of a command that has begun nothing
LAST_LINES, MOST_LINES = 5, 40  # of a run's output, in the message of an error; the most if nothing was begun
COMPONENTS = ("x", "y", "z")


class RunFailed(Exception):
    """A run ended before its end; ``run`` is what it left behind, or None if it left nothing.

    ``refused`` says that nothing was begun.
    """

    def __init__(self, why: str, run: Run | None = None, refused: bool = False) -> None:
        super().__init__(why)
        self.run, self.refused = run, refused


class RunInterrupted(RunFailed):
    """A signal, such as Ctrl-C, ended a run; ``run.resume()`` continues it."""


class Run:
    """The folder of a run that has ended."""

    def __init__(self, folder: str | Path) -> None:
        """Open a folder.  Raises FolderUnusable if it does not hold an ended run of this version."""
        self.folder = Path(folder).absolute()  # whatever the current folder will be
        try:
            self.summary: Mapping[str, Any] = RunReader(admit(self.folder)).summary
        except (OSError, ValueError) as error:
            why = _why_open(self.folder) or f"holds no run that has ended ({error})"
            raise FolderUnusable(f"{self.folder}: {why}") from None

    @property
    def status(self) -> str:
        """The state of the run: done, doubtful, incomplete, interrupted or failed."""
        return str(self.summary["status"])

    @property
    def is_trusted(self) -> bool:
        """True if the run is complete and nothing in its own figures speaks against it."""
        return trust.is_trusted(self.status)

    @property
    def doubts(self) -> list[str]:
        """The reasons not to trust the run, a sentence each."""
        return list(self.summary.get("doubts", []))

    @property
    def unsteady(self) -> list[str]:
        """The reasons why a bed that is fed is not steady and why the motion of a machine has not settled, so
        that results are of the start, too; a sentence each.
        """
        return [why for why in why_transient(self.summary) if why]

    def __getitem__(self, name: str) -> Value:
        """Return a result with its interval, by its short name (``stroke``) or its keys in ``summary.json``
        with dots.

        The value has the attributes ``value``, ``half_width`` (of the 95 % confidence interval) and
        ``counting`` (the standard deviation that the number of particles explains); the last two are None
        where they are unknown. Raises KeyError if there is no such result, or the run does not have it.
        """
        named(name)
        value = value_at(self.summary, name)
        if value is None:
            raise KeyError(f"the run does not have the result {name}")
        return value

    @property
    def results(self) -> pandas.DataFrame:
        """The results that have short names, one in each row, with their intervals and a description with
        the unit.
        """
        import pandas

        rows = {name: value for name in SHORT_NAMES if (value := value_at(self.summary, name)) is not None}
        table = {
            "value": [row.value for row in rows.values()],
            "half_width": [row.half_width for row in rows.values()],
            "counting": [row.counting for row in rows.values()],
            "meaning": [SHORT_NAMES[name].words for name in rows],
        }
        return pandas.DataFrame(table, index=pandas.Index(rows, name="result")).astype(
            {"half_width": float, "counting": float}
        )

    @property
    def groups(self) -> list[str]:
        """The groups of time series in ``history.h5``, such as ``frames/driven``."""
        with RunReader(self.folder) as reader:
            found: list[str] = []
            reader.history.visit(found.append)
            return [name for name in found if reader.has(f"{name}/time_s")]

    def history(self, group: str) -> pandas.DataFrame:
        """Return the time series of a group, with the time in s as the index.

        Vectors have a column for each component (``displacement_m.x``), other arrays a column for each entry
        (``depth_m.0``).  Raises KeyError if there is no such group.
        """
        import pandas

        with RunReader(self.folder) as reader:
            if not reader.has(f"{group}/time_s"):
                raise KeyError(f'no group "{group}"; there are {", ".join(self.groups)}')
            names = [name for name in reader.names(group) if name != "time_s"]
            columns = {
                column: values
                for name in names
                for column, values in _columns(name, reader.read(f"{group}/{name}"))
            }
            index = pandas.Index(reader.read(f"{group}/time_s"), name="time_s")
        return pandas.DataFrame(columns, index=index)

    @property
    def pictures(self) -> dict[str, Path]:
        """The pictures of the run by name."""
        return {file.stem: file for file in sorted(self.folder.glob("*.png"))}

    def picture(self, name: str) -> Any:
        """Return a picture as an image of Pillow, which a notebook shows.  Raises KeyError if there is
        none.
        """
        from PIL import Image

        if name not in (files := self.pictures):
            raise KeyError(f'no picture "{name}"; there are {", ".join(files) or "none"}')
        return Image.open(files[name])

    def report(self) -> Path:
        """Make the HTML page about the run, and return its file."""
        from orchestrator.output.report.page import report

        report(self.folder)
        return self.folder / "report.html"

    def resume(
        self, settings: Sequence[str] = (), progress: Callable[[ProgressReport], None] | None = None
    ) -> Run:
        """Continue the run from its last checkpoint in its folder, and return it when it has ended.

        It has as many processes as before, because the result is the same on the same number alone.
        ``settings`` are overlays as ``flipflow resume --set`` takes them, such as ``duration_s=2``.  Raises
        RunFailed and RunInterrupted.
        """
        sets = [word for line in settings for word in ("--set", line)]
        ranks = read_provenance(self.folder)["ranks"]
        return _wait(["resume", str(self.folder), *sets], self.folder, progress, ranks)

    def __repr__(self) -> str:
        return f"Run({self.folder.name!r}, {visible(self.status)})"

    def _repr_html_(self) -> str:
        """Return the state and the results for a notebook."""
        doubts = "".join(f"<li>{escape(line)}</li>" for line in (*self.doubts, *self.unsteady))
        head = f"<p>Run <b>{escape(self.folder.name)}</b>: {escape(self.status)}</p>"
        table = self.results.to_html(float_format="%.4g", na_rep="")
        return head + (f"<ul>{doubts}</ul>" if doubts else "") + str(table)


def open_run(folder: str | Path) -> Run:
    """Return the run in a folder.  Raises FolderUnusable if the folder holds no ended run of this version."""
    return Run(folder)


def make_run(
    words: Sequence[str],
    out: str | Path | None,
    progress: Callable[[ProgressReport], None] | None,
    ranks: int,
) -> Run:
    """Carry out the command ``flipflow run`` with its ``words``, and return the run.

    Raises RunFailed and RunInterrupted.
    """
    while True:
        folder = Path(out) if out is not None else _next_folder(Path(words[1]).name)
        try:
            return _wait([*words, "--out", str(folder)], folder, progress, ranks)
        except RunFailed as error:
            was_taken = out is None and error.refused and folder.exists()  # by a run that began meanwhile
            if not was_taken:
                raise


def _next_folder(name: str) -> Path:
    """Return the first folder runs/<name>-<number> that does not exist."""
    folders = (Path("runs") / f"{name}-{number}" for number in count(1))
    return next(folder for folder in folders if not folder.exists())


def _wait(
    words: Sequence[str], folder: Path, progress: Callable[[ProgressReport], None] | None, ranks: int
) -> Run:
    """Carry out a command of flipflow to its end, and return the run in ``folder``.

    Ctrl-C is handed on to the run, which then ends in order, and so does an error of ``progress``.  mpirun
    gives its processes time to save only after SIGUSR1.  Raises RunFailed and RunInterrupted.
    """
    last: list[str] = []
    with subprocess.Popen(
        [*_launcher(ranks), sys.executable, "-P", "-c", MAIN, *words],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        errors="replace",  # libraries may write anything
        env=os.environ | {"TERM": "dumb"},
        start_new_session=True,  # a terminal's Ctrl-C reaches this process alone
    ) as process:
        assert process.stderr is not None
        while True:
            try:
                for line in process.stderr:
                    report = parse_report(line)
                    if report is None:
                        last = [*last, line.rstrip()][-MOST_LINES:]
                    elif progress is not None:
                        progress(report)
                process.wait()
                break
            except KeyboardInterrupt:
                process.send_signal(signal.SIGINT if ranks == 1 else signal.SIGUSR1)
            except BaseException:
                process.send_signal(signal.SIGTERM if ranks == 1 else signal.SIGUSR1)
                raise
    return _ended(process.returncode, folder, last)


def _ended(code: int, folder: Path, last: Sequence[str]) -> Run:
    """Return the run in a folder whose process ended with an exit code, or raise what the code means.

    A process that was refused has left nothing: what the folder holds is of an earlier run.
    """
    run = Run(folder) if code != REFUSED and (folder / SUMMARY).is_file() else None
    if code in trust.EXIT_CODES.values() and run is not None:
        return run
    said = "\n".join(last[-LAST_LINES:])
    if run is None:
        said = "\n".join((*last, "" if code == REFUSED else _why_open(folder))).strip()
    number = -code if code < 0 else code - 128
    if number in CRASHES:
        raise RunFailed(f"{said}\nended by {signal.Signals(number).name}".lstrip(), run)
    if number > 0:
        raise RunInterrupted(said, run)
    raise RunFailed(said, run, refused=code == REFUSED)


def _why_open(folder: Path) -> str:
    """Return why the run in a folder has no summary, and what goes on with it; empty if that is not so."""
    from orchestrator.output.report.page import NEEDED, why_open

    is_open = [name for name in NEEDED if not (folder / name).is_file()] == [SUMMARY]
    return why_open(folder) if is_open else ""


def _launcher(ranks: int) -> list[str]:
    """Return the words that start a program on several processes.

    Raises ValueError for less than one, and RunFailed if there is no ``mpirun``.
    """
    if ranks < 1:  # mpirun would take as many as there are cores
        raise ValueError(f"ranks is {ranks}; a run has one process or more")
    if ranks == 1:
        return []
    if shutil.which("mpirun") is None:
        raise RunFailed("mpirun is not installed; the run needs it for more than one process")
    as_root = ["--allow-run-as-root"] if os.geteuid() == 0 else []
    return ["mpirun", *as_root, "-n", str(ranks)]


def _columns(name: str, values: Any) -> list[tuple[str, Any]]:
    """Return the columns of a dataset, one for each entry of its rows."""
    rows = np.asarray(values).reshape(len(values), int(np.prod(values.shape[1:])))
    if values.ndim == 1:
        return [(name, rows[:, 0])]
    is_vector = values.ndim == 2 and values.shape[1] == len(COMPONENTS)
    tails = COMPONENTS if is_vector else tuple(map(str, range(rows.shape[1])))
    return [(f"{name}.{tail}", rows[:, number]) for number, tail in enumerate(tails)]
