"""The folder of a run: made once, never written over, locked while a process is at work in it."""

from __future__ import annotations

import fcntl
import json
import logging
import os
import shutil
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from itertools import count
from pathlib import Path
from typing import Any

import tomli_w

from orchestrator.case.provenance import provenance
from orchestrator.preflight.judge import JudgedCase

LOG = logging.getLogger("flipflow")
HISTORY, SUMMARY, RECORDING = "history.h5", "summary.json", "recording.h5"


class FolderUnusable(Exception):
    """The output folder exists already, cannot be written or holds what cannot be used (exit code 2)."""


class FolderExists(FolderUnusable):
    """The output folder exists already."""


class OtherFormat(FolderUnusable):
    """A file that another version of flipflow wrote, in another format."""


def check_format(file: Path, written: Any, wanted: int) -> None:
    """Raise OtherFormat where the version of a file's format is not the ``wanted`` one."""
    if written != wanted:
        version = "no version of its format, as older ones" if written is None else f"format {written}"
        raise OtherFormat(
            f"{file}: has {version}; this flipflow reads format {wanted}: run the case again, or read it "
            "with the flipflow that wrote it (provenance.json names its version)"
        )


def create_run_folder(loaded: JudgedCase, out: Path | None, world: Any) -> Path:
    """Make the run's new folder, ``out`` or runs/<case>-<n>, with the resolved case (itself a case that
    can be run again, with its surfaces beside it) and the provenance.  Raises FolderUnusable."""
    folder = make_folder(out) if out else _next_folder(Path("runs"), loaded.name)
    try:
        for name, surface in loaded.case.whole.screen.surfaces.items():
            if surface.stl is not None:
                shutil.copyfile(loaded.folder / surface.stl, folder / f"{name}.stl")
        if loaded.case.panel.recording is not None:
            shutil.copyfile(loaded.folder / loaded.case.panel.recording, folder / RECORDING)
        write_case(folder, loaded)
        write_json(folder / "provenance.json", provenance(world.size if world else 1))
    except OSError as error:
        remove_folder(folder)
        raise FolderUnusable(f"{folder}: cannot be written: {error.strerror or error}") from None
    return folder


def write_case(folder: Path, loaded: JudgedCase) -> None:
    """Write the resolved case."""
    write_text(folder / "case.toml", tomli_w.dumps(resolved_case(loaded)))


def resolved_case(loaded: JudgedCase) -> dict[str, Any]:
    """Return the case with its level, every ``--set`` and every default, as the run's folder has it."""
    table = loaded.case.as_given.model_dump(mode="json", exclude_none=True)
    for name, surface in table["screen"]["surfaces"].items():
        if "stl" in surface:
            surface["stl"] = f"{name}.stl"
    if "recording" in table["panel"]:
        table["panel"]["recording"] = RECORDING
    return table | {"default_level": ""}


def claim(path: Path, text: str, rank: int) -> bool:
    """Write ``path`` if nobody did before; False for everybody but the first.  Where nobody can
    write, ranks that wait in turn for the lower ones to act are all first."""
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(text + "\n")
    except FileExistsError:
        return False
    except OSError:  # a full disk must not silence the message
        time.sleep(2.0 * rank)
    return True


def remove_folder(folder: Path) -> None:
    """Remove a run's folder in which nothing has been computed."""
    shutil.rmtree(folder, ignore_errors=True)


def make_folder(folder: Path) -> Path:
    """Make a new folder; raise FolderUnusable if it is there already or cannot be made."""
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        folder.mkdir()
    except OSError as error:
        if os.path.lexists(folder):
            raise FolderExists(
                f"{folder}: exists already; nothing was written. "
                "Give another folder with --out, or remove this one."
            ) from None
        raise FolderUnusable(f"{folder}: cannot be made: {error.strerror}") from None
    return folder


def _next_folder(parent: Path, case: str) -> Path:
    """Make a new folder ``<parent>/<case>-<n>`` with the first free number, of nobody else, whoever asks
    at the same time.  Raises FolderUnusable if it cannot be made."""
    for number in count(1):
        with suppress(FolderExists):
            return make_folder(parent / f"{case}-{number}")
    raise AssertionError("numbers do not end")


class _PrintableFormatter(logging.Formatter):
    """Characters that would command a terminal, such as ESC in the name of a folder, are written
    as Python writes them."""

    def format(self, record: logging.LogRecord) -> str:
        return printable(super().format(record))


def printable(text: str) -> str:
    """Return lines as they are, and other characters that do not print as Python writes them."""
    return "".join(
        char if char.isprintable() or char in "\n\t" else char.encode("unicode_escape").decode()
        for char in text
    )


@contextmanager
def logging_to(folder: Path, first: bool) -> Iterator[None]:
    """Write ``run.log`` with times while inside; of ranks other than the first it has errors only."""
    handler = logging.FileHandler(folder / "run.log", delay=True, encoding="utf-8")
    handler.setFormatter(_PrintableFormatter("%(asctime)s %(levelname)-7s %(message)s"))
    LOG.addHandler(handler)
    LOG.setLevel(logging.INFO if first else logging.ERROR)
    LOG.propagate = False  # the console has its own words
    logging.raiseExceptions = False  # a log that cannot be written must not stop the run
    try:
        yield
    finally:
        LOG.removeHandler(handler)
        handler.close()


def write_json(path: Path, value: Any) -> None:
    """Write a table as JSON, whole or not at all."""
    write_text(path, json.dumps(value, indent=2, default=float) + "\n")


def write_text(path: Path, text: str) -> None:
    """Write a file, whole or not at all: written aside, then renamed."""
    aside = path.with_name(f".{path.name}")
    try:
        aside.write_text(text, encoding="utf-8")
        aside.replace(path)
    except OSError:  # half a file has no use, and takes room
        aside.unlink(missing_ok=True)
        raise


OF_A_RUN = "run.log"
OF_A_STUDY = ".lock"


@contextmanager
def lock(file: Path) -> Iterator[None]:
    """Holds ``file``, made where it is missing, while inside.  Raises FolderUnusable where another
    process holds it.  On a file system without locks nobody is kept out."""
    with file.open("a") as opened:
        try:
            fcntl.flock(opened, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise FolderUnusable(
                f"{file.parent}: another flipflow is at work there; wait for its end, or give "
                "another folder with --out"
            ) from None
        except OSError:  # no locks on this file system
            pass
        yield


@contextmanager
def study_folder(folder: Path) -> Iterator[None]:
    """Make the folder of a study, or go on in it; nobody else does meanwhile.  Raises FolderUnusable."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FolderUnusable(f"{folder}: cannot be made: {error.strerror}") from None
    with lock(folder / OF_A_STUDY):
        yield


def is_at_work(folder: Path) -> bool:
    """Whether a run is going on in this folder; none does where nobody may write."""
    if not (folder / OF_A_RUN).exists() or not os.access(folder / OF_A_RUN, os.W_OK):
        return False
    try:
        with lock(folder / OF_A_RUN):
            return False
    except FolderUnusable:
        return True
