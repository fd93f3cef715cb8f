"""Runs of a case over values of one key: each in a process and a folder of its own, never twice."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from orchestrator.casefile.errors import CaseError
from orchestrator.casefile.levels import LoadedCase, load
from orchestrator.casefile.overlays import changed
from orchestrator.casefile.toml_file import read_toml
from orchestrator.checks import mistakes
from orchestrator.children import python
from orchestrator.records.folder_lock import at_work
from orchestrator.records.run_folder import FolderUnusable, resolved
from orchestrator.studies.points import Vary

MAIN = "from orchestrator.commands.cli import main; main()"


@dataclass(frozen=True)
class Point:
    """One run of a sweep: what is asked for and where it is or will be."""

    value: str
    loaded: LoadedCase
    words: tuple[str, ...]
    folder: Path

    def done(self) -> bool:
        """Whether it has been run to its end.  Raises FolderUnusable if the folder holds a
        finished run of another case."""
        if self.status() != "done":
            return False
        differing = list(changed(read_toml(self.folder / "case.toml"), resolved(self.loaded)))
        if differing:
            keys = ", ".join(".".join(key) for key in differing[:3])
            raise FolderUnusable(
                f"{self.folder}: holds a run of another case (it differs in {keys}); "
                "give another folder with --out"
            )
        return True

    def status(self) -> str:
        """As in its summary; "missing" without one."""
        try:
            return str(json.loads((self.folder / "summary.json").read_text())["status"])
        except (OSError, ValueError, KeyError):
            return "missing"


def points(
    case: Path, level: str | None, overrides: Sequence[str], vary: Vary, out: Path
) -> list[Point]:
    """All points, checked: nothing is run if one of them is wrong.  Raises CaseError."""
    found = []
    for value in vary.values:
        sets = [*overrides, f"{vary.key}={value}"]
        loaded = load(case, level, sets)
        if wrong := mistakes(loaded):
            raise CaseError(wrong)
        folder = out / vary.folder(value)
        options = [word for each in sets for word in ("--set", each)]
        at_level = ["--level", loaded.level] if loaded.level else []
        words = ("run", str(case), *at_level, *options, "--out", str(folder))
        found.append(Point(value, loaded, words, folder))
    return found


def run(todo: Sequence[Point], jobs: int, say: Callable[[str], None]) -> None:
    """Runs those that are not done, ``jobs`` at a time.  What an unfinished run left is kept
    under another name.  Raises FolderUnusable before anything is run."""
    waiting = []
    for point in todo:
        if at_work(point.folder):
            raise FolderUnusable(f"{point.folder}: a run is at work there; wait for its end")
        if point.done():
            say(f"{point.folder.name}: done before")
        else:
            waiting.append(point)
    with ThreadPoolExecutor(max_workers=jobs) as pool:
        try:
            for line in pool.map(_run, waiting):
                say(line)
        except KeyboardInterrupt:  # which the runs have got, too, and end at a sync point
            pool.shutdown(cancel_futures=True)
            raise


def _run(point: Point) -> str:
    _put_aside(point.folder)
    log = point.folder.with_name(f"{point.folder.name}.log")
    log.parent.mkdir(parents=True, exist_ok=True)
    with log.open("w", encoding="utf-8") as said:
        code = python(
            *("-c", MAIN, *point.words),
            stdout=said,
            stderr=subprocess.STDOUT,
            env={"OMP_NUM_THREADS": "1"},
        ).returncode
    return f"{point.folder.name}: {point.status()}" + (f" ({log})" if code else "")


def _put_aside(folder: Path) -> None:
    number = 1
    while folder.exists():
        aside = folder.with_name(f"{folder.name}-unfinished-{number}")
        if not aside.exists():
            folder.rename(aside)
        number += 1
