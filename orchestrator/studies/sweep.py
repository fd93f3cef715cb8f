"""Runs of a case over values of one key: each in a process and a folder of its own, never twice."""

from __future__ import annotations

import json
import signal
import subprocess
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import IO

from orchestrator.case.file.errors import CaseError
from orchestrator.case.file.overlays import changed
from orchestrator.output.records import trust
from orchestrator.output.records.run_folder import FolderUnusable, is_at_work, resolved_case, write_json
from orchestrator.output.results.run_reader import RunReader
from orchestrator.output.subprocesses import python
from orchestrator.preflight.check import mistakes
from orchestrator.preflight.levels import LoadedCase, load
from orchestrator.studies.points import Vary
from orchestrator.studies.workers import Crew

MAIN = "from orchestrator.cli.main import main; main()"


def status(folder: Path) -> str:
    """Returns the state of the run in a folder, as in its summary; "missing" without one.
    Raises OtherFormat where another version of flipflow wrote it."""
    try:
        return str(RunReader(folder).summary["status"])
    except (OSError, ValueError, KeyError):
        return "missing"


def came_to_its_end(folder: Path) -> bool:
    """Returns whether the run of a folder need not be run again; it may still be doubtful."""
    return trust.came_to_its_end(status(folder))


@dataclass(frozen=True)
class Point:
    """One run of a sweep: what is asked for and where it is or will be.

    ``words``: the command that runs it; ``then``: one more, in the same folder; ``ended`` tells of
    its folder whether nothing is left to be run.
    """

    value: str
    loaded: LoadedCase
    words: tuple[str, ...]
    folder: Path
    then: tuple[str, ...] = ()
    ended: Callable[[Path], bool] = came_to_its_end

    def done(self) -> bool:
        """Whether it has been run to its end.  Raises FolderUnusable if the folder holds a
        finished run of another case."""
        if not self.ended(self.folder):
            return False
        if differing := self._differing():
            raise FolderUnusable(
                f"{self.folder}: holds a run of another case (it differs in {differing}); "
                "give another folder with --out"
            )
        return True

    def _differing(self) -> str:
        """Keys in which the folder's case differs; those that cases got since it was run have
        their defaults there."""
        try:
            there = resolved_case(load(self.folder / "case.toml"))
        except CaseError as error:
            return ", ".join(".".join(map(str, one.key)) for one in error.mistakes[:3])
        keys = list(changed(there, resolved_case(self.loaded)))
        return ", ".join(".".join(key) for key in keys[:3])

    def status(self) -> str:
        """As in its summary; "missing" without one."""
        return status(self.folder)


def point(case: Path, level: str | None, sets: Sequence[str], value: str, folder: Path) -> Point:
    """The run of a case with ``sets`` in ``folder``.  Raises CaseError for a case that is wrong."""
    loaded = load(case, level, sets)
    if wrong := mistakes(loaded):
        raise CaseError(wrong)
    options = [word for each in sets for word in ("--set", each)]
    at_level = ["--level", loaded.level] if loaded.level else []
    words = ("run", str(case.resolve()), *at_level, *options, "--out", str(folder.resolve()))
    return Point(value, loaded, words, folder)


def points(case: Path, level: str | None, overrides: Sequence[str], vary: Vary, out: Path) -> list[Point]:
    """All points, checked: nothing is run if one of them is wrong.  Raises CaseError."""
    return [
        point(case, level, [*overrides, f"{vary.key}={value}"], value, out / vary.folder(value))
        for value in vary.values
    ]


def run(todo: Sequence[Point], crew: Crew, say: Callable[[str], None]) -> None:
    """Runs those that are not done, side by side.  What an unfinished run left is kept under
    another name.  Raises FolderUnusable before anything is run."""
    waiting = []
    for one in todo:
        if is_at_work(one.folder):
            raise FolderUnusable(f"{one.folder}: a run is at work there; wait for its end")
        if one.done():
            say(f"{one.folder.name}: done before")
        else:
            waiting.append(one)
    beside = min(crew.workers, len(waiting))
    work = [partial(_run, (one.words, one.then), one.folder.resolve(), beside) for one in waiting]
    for line in crew.each(work):
        say(line)


def beside(one: Point) -> int:
    """How many points were run at a time when this one was; 0 where nobody wrote it down."""
    try:
        return int(json.loads(_about(one.folder).read_text())["side_by_side"])
    except (OSError, ValueError, KeyError):
        return 0


def _run(commands: Sequence[Sequence[str]], folder: Path, beside: int) -> str:
    _put_aside(folder)
    log = folder.with_name(f"{folder.name}.log")
    log.parent.mkdir(parents=True, exist_ok=True)
    write_json(_about(folder), {"side_by_side": beside})
    with log.open("w", encoding="utf-8") as said:
        codes = (_carried_out(words, said) for words in commands if words)
        code = next((code for code in codes if code), 0)  # the first to fail is the last
    how = f"killed ({signal.Signals(-code).name})" if code < 0 else status(folder)
    return f"{folder.name}: {how}" + (f" ({log})" if code else "")


def _carried_out(words: Sequence[str], said: IO[str]) -> int:
    """A command in a process of its own; its exit code."""
    return python(
        *("-c", MAIN, *words), stdout=said, stderr=subprocess.STDOUT, env={"OMP_NUM_THREADS": "1"}
    ).returncode


def _about(folder: Path) -> Path:
    return folder.with_name(f"{folder.name}.json")


def _put_aside(folder: Path) -> None:
    number = 1
    while folder.exists():
        aside = folder.with_name(f"{folder.name}-unfinished-{number}")
        if not aside.exists():
            folder.rename(aside)
        number += 1
