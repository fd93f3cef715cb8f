"""The folder of a run: made once, never written over, locked while a process is at work in it."""

from __future__ import annotations

import errno
import fcntl
import hashlib
import logging
import math
import os
import shutil
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from typing import Any

import tomli_w

from orchestrator.case.bed import saved_bed
from orchestrator.case.bed.saved_bed import BED
from orchestrator.case.file.folder import FolderUnusable
from orchestrator.case.file.nested import value_at
from orchestrator.case.file.printable import escape_unprintable
from orchestrator.case.file.whole import write_json, write_text
from orchestrator.case.provenance import provenance, read_provenance
from orchestrator.case.tables.case import Case
from orchestrator.case.tables.deck import DrawnApertures
from orchestrator.preflight.judge import JudgedCase

LOG = logging.getLogger("flipflow")
HISTORY, SUMMARY, PAGE = "history.h5", "summary.json", "report.html"
WALLS = "walls.vtu"
PICTURES = (
    "frame_motion.png",
    "panel_shapes.png",
    "point_orbits.png",
    "panel_instants.png",
    "bushing_loops.png",
    "energy.png",
    "deck.png",
)
"""The files of all pictures that a run makes at its end."""


class FolderExists(FolderUnusable):
    """An error about an output folder that exists already."""


class OtherFormat(FolderUnusable):
    """An error about a file that another version of flipflow wrote in another format."""


def check_format(file: Path, version: Any, expected: int) -> None:
    """Raise OtherFormat if the ``version`` of a file's format is not the ``expected`` version."""
    if version != expected:
        raise OtherFormat(
            f"{file}: has format {version}; this flipflow reads format {expected}: run the case again, or "
            "read it with the flipflow that wrote it (provenance.json names its version)"
        )


def create_run_folder(loaded: JudgedCase, out: Path | None, world: Any) -> Path:
    """Make the new folder of a run, ``out`` or runs/<case>-<n>, and return its path.

    The folder gets the provenance and the resolved case, which can be run again, with its surfaces beside
    it.  Raises FolderUnusable.
    """
    folder = make_folder(out) if out else _next_folder(Path("runs"), loaded.name)
    try:
        for named in named_files(loaded.case.whole_machine):
            shutil.copyfile(loaded.folder / named.file, folder / named.copy)
        if (carried := loaded.case.original.bed.carried) is not None:
            saved_bed.write(folder / BED, carried)
        write_case(folder, loaded)
        about = provenance(world.size if world else 1)
        write_json(folder / "provenance.json", about | _origin_of_bed(loaded.case))
    except OSError as error:
        remove_folder(folder)
        raise FolderUnusable(f"{folder}: cannot be written: {error.strerror or error}") from None
    return folder


def _origin_of_bed(case: Case) -> dict[str, Any]:
    """Return where the particles come from with which the case begins; nothing where it describes them."""
    carried = case.bed.carried
    if carried is None:
        return {}
    source = Path(carried.source).resolve()
    table: dict[str, Any] = {
        "file": str(source),
        "sha256": hashlib.sha256(source.read_bytes()).hexdigest(),
        "time_s": None if math.isnan(carried.time_s) else carried.time_s,
        "particles": len(carried),
        "left_out": len(case.original.bed.carried or ()) - len(carried),
        "velocities": case.bed.velocities,
    }
    if case.bed.from_run is not None:
        run = next(folder for folder in source.parents if (folder / "provenance.json").is_file())
        about = read_provenance(run)
        table |= {"run": str(run), "run_started": about.get("started"), "run_commit": about.get("commit")}
    return {"bed": table}


def changed_files(loaded: JudgedCase, folder: Path) -> Iterator[str]:
    """Yield the keys of the case's files that have changed since the run in a folder took its copies."""
    for named in named_files(loaded.case.whole_machine):
        copy = folder / named.copy
        if not copy.is_file() or (loaded.folder / named.file).read_bytes() != copy.read_bytes():
            yield ".".join(named.key)
    if now := _origin_of_bed(loaded.case).get("bed"):
        then = read_provenance(folder).get("bed", {})
        if any(then.get(key) != now[key] for key in ("sha256", "time_s")):
            yield "bed"


@dataclass(frozen=True)
class NamedFile:
    """A file of a surface or a drawing of a panel: its key, its name, and the name of a run's copy."""

    key: tuple[str, ...]
    file: str
    copy: str


def named_files(case: Case) -> Iterator[NamedFile]:
    """Yield the files of surfaces and the drawings of panels that a case names."""
    for name, surface in case.screen.surfaces.items():
        if surface.file is not None:
            ending = Path(surface.file).suffix.lower()
            yield NamedFile(("screen", "surfaces", name, "file"), surface.file, f"{name}{ending}")
        elif surface.stl is not None:
            yield NamedFile(("screen", "surfaces", name, "stl"), surface.stl, f"{name}.stl")
    for name, panel in case.screen.panels.items():
        if isinstance(panel.apertures, DrawnApertures):
            yield NamedFile(
                ("screen", "panels", name, "apertures", "file"), panel.apertures.file, f"{name}.dxf"
            )


def write_case(folder: Path, loaded: JudgedCase) -> None:
    """Write the resolved case as ``case.toml``."""
    write_text(folder / "case.toml", tomli_w.dumps(resolved_case(loaded)))


def resolved_case(loaded: JudgedCase) -> dict[str, Any]:
    """Return the case for the run's folder, with its level, every ``--set`` and every default applied."""
    case_bed = loaded.case.original.bed
    table = loaded.case.original.model_dump(mode="json", exclude_none=True)
    for named in named_files(loaded.case.original):
        value_at(table, named.key[:-1])[named.key[-1]] = named.copy
    if case_bed.carried is not None:
        for key in ("from_run", "from_time_s"):
            table["bed"].pop(key, None)
        table["bed"]["table"] = BED
    return table | {"default_level": ""}


def claim(path: Path, text: str, rank: int) -> bool:
    """Write ``path`` if no rank has written it yet, and return whether this rank is the first.

    If the file cannot be written, each rank waits in turn for the lower ranks to act, and all count as
    first.
    """
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(text + "\n")
    except FileExistsError:
        return False
    except OSError:  # a full disk must not silence the message
        time.sleep(2.0 * rank)
    return True


def remove_folder(folder: Path) -> None:
    """Remove the folder of a run that has computed nothing."""
    shutil.rmtree(folder, ignore_errors=True)


def make_folder(folder: Path) -> Path:
    """Make a new folder, and return its path.  Raises FolderUnusable if it exists or cannot be made."""
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
    """Make a new folder ``<parent>/<case>-<n>`` with the first free number n, and return its path.

    Two processes that ask at the same time get different folders.  Raises FolderUnusable if the folder
    cannot be made.
    """
    for number in count(1):
        with suppress(FolderExists):
            return make_folder(parent / f"{case}-{number}")
    raise AssertionError("numbers do not end")


class _PrintableFormatter(logging.Formatter):
    """A formatter that escapes characters that would control a terminal, such as ESC in a folder's name."""

    def format(self, record: logging.LogRecord) -> str:
        return escape_unprintable(super().format(record))


@contextmanager
def logging_to(folder: Path, first: bool) -> Iterator[None]:
    """Log to ``run.log`` with times while inside; ranks other than the first log errors only."""
    handler = logging.FileHandler(folder / "run.log", delay=True, encoding="utf-8")
    handler.setFormatter(_PrintableFormatter("%(asctime)s %(levelname)-7s %(message)s"))
    LOG.addHandler(handler)
    LOG.setLevel(logging.INFO if first else logging.ERROR)
    LOG.propagate = False  # the console gets messages of its own
    logging.raiseExceptions = False  # a log that cannot be written must not stop the run
    try:
        yield
    finally:
        LOG.removeHandler(handler)
        handler.close()


PAGES = (".html", ".htm")


def write_page(path: Path, page: str) -> None:
    """Write an HTML page, whole or not at all, in the place of an older page but of no other file.

    Raises OSError.
    """
    if path.exists() and path.suffix.lower() not in PAGES:
        raise OSError(errno.EEXIST, f"exists already and is not a page ({PAGES[0]})", str(path))
    write_text(path, page)


RUN_LOCK = "run.log"
STUDY_LOCK = ".lock"


@contextmanager
def lock(file: Path) -> Iterator[None]:
    """Lock ``file`` while inside, and make it if it is missing.

    Raises FolderUnusable if another process has locked it.  On a file system without locks, this does
    not keep other processes out.
    """
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
    """Make the folder of a study if it is missing, and lock it while inside.  Raises FolderUnusable."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FolderUnusable(f"{folder}: cannot be made: {error.strerror}") from None
    with lock(folder / STUDY_LOCK):
        yield


def is_at_work(folder: Path) -> bool:
    """Return whether a run is going on in a folder; False if this process may not write there."""
    if not (folder / RUN_LOCK).exists() or not os.access(folder / RUN_LOCK, os.W_OK):
        return False
    try:
        with lock(folder / RUN_LOCK):
            return False
    except FolderUnusable:
        return True
