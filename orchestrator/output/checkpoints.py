"""Checkpoints on the disk: the folder ``checkpoints/<sync point>/`` in the folder of a run.

Each folder holds the arrays of every rank, a copy of the records up to that moment, and
``checkpoint.json``, which describes the run and has the checksum of every other file.  A checkpoint is
written under another name and renamed when all of it is on the disk.  The last ``KEPT`` checkpoints stay,
and so does the last good one.
"""

from __future__ import annotations

import errno
import hashlib
import json
import os
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from orchestrator.case.bed import saved_bed
from orchestrator.case.bed.saved_bed import BED
from orchestrator.case.file.folder import read_json
from orchestrator.case.file.whole import written_whole
from orchestrator.case.tables.carried_bed import CarriedBed
from orchestrator.coupling.mpi import first_rank_does
from orchestrator.output.records.run_folder import OtherFormat, check_format
from orchestrator.ports import Saved

KEPT = 2
FOLDER, ABOUT = "checkpoints", "checkpoint.json"
FORMAT = 15
"""Version of a checkpoint: to be raised with every change of the names of its arrays (a test holds
them against tests/runs/checkpoint_names.txt), of their meaning, or of ``checkpoint.json``."""
LARGE_BYTES, SPARSE = 2**30, 1000
"""The size from which on a file of a checkpoint has data in more than the ``SPARSE``-th part of it."""
BLOCK_BYTES = 512  # in which Linux counts the room of a file
ORIGIN_KEYS = ("ranks", "host", "machine", "python", "versions", "commit")


class OtherCheckpoint(OtherFormat):
    """An error about a checkpoint that another version of flipflow wrote, in another format (exit code 4)."""


class TornCheckpoint(Exception):
    """An error about a checkpoint whose files are not as they were written."""


def array_names(saved: Saved) -> set[str]:
    """Return the names of all arrays of a state in a checkpoint."""
    return set(_flatten(saved))


def _flatten(saved: Saved, within: str = "") -> dict[str, Any]:
    """Return the arrays by names with slashes; a name that ends with a slash stands for an empty table."""
    table: dict[str, Any] = {} if saved else {within: np.empty(0)}
    for name, value in saved.items():
        table |= _flatten(value, f"{within}{name}/") if isinstance(value, dict) else {within + name: value}
    return table


@dataclass(frozen=True)
class Checkpoint:
    """A whole checkpoint with the content of ``checkpoint.json``; ``torn`` names damaged later ones."""

    folder: Path
    about: dict[str, Any]
    torn: tuple[str, ...] = ()

    @property
    def sync_points(self) -> int:
        """The number of sync intervals before the checkpoint."""
        return int(self.about["sync_points"])

    @property
    def good(self) -> int:
        """The sync point of the last checkpoint, up to this one, at which nothing was amiss; -1 if none."""
        return int(self.about.get("good", self.sync_points))

    @property
    def simulated_s(self) -> float:
        """The time that had been simulated by then."""
        return float(self.about["progress"]["figures"]["simulated_s"])

    def state(self, world: Any) -> Saved:
        """Return the arrays of this rank as nested tables."""
        saved: Saved = {}
        with np.load(self.folder / _of_rank(world), allow_pickle=False) as file:
            for path in file.files:
                *parents, name = path.split("/")
                inner = saved
                for parent in parents:
                    inner = inner.setdefault(parent, {})
                if name:
                    inner[name] = file[path]
        return saved

    def put_back(self, run: Path) -> None:
        """Copy the recorded files back, into the folder of the run."""
        for name in self.about["copies"]:
            with written_whole(run / name) as aside:
                shutil.copyfile(self.folder / name, aside)


def write(
    run: Path,
    state: Saved,
    copies: Sequence[Path],
    about: dict[str, Any],
    world: Any,
    bed: CarriedBed | None = None,
) -> None:
    """Write a checkpoint of all ranks of ``world`` into the folder of a run.

    The particles of the ``bed`` are written in a form of their own, from which other runs may begin.
    ``about`` must have the number of ``sync_points``, and the number at the last ``good`` checkpoint.  Raises
    OSError on every rank if one of them cannot write; earlier checkpoints then stay.
    """
    folder = _folder(run, about["sync_points"])
    aside = folder.with_name(f".{folder.name}")
    try:
        first_rank_does(world, lambda: _open(aside))
        sums = _write_arrays(aside / _of_rank(world), state, world)
        first_rank_does(world, lambda: _complete(aside, folder, copies, about, sums, bed))
    except OSError:  # half a checkpoint takes the room that the run's last messages need
        first_rank_does(world, lambda: shutil.rmtree(aside, ignore_errors=True))
        raise


def _open(aside: Path) -> None:
    shutil.rmtree(aside, ignore_errors=True)
    aside.parent.mkdir(exist_ok=True)  # without parents: a run's folder that is gone stays gone
    aside.mkdir()


def _write_arrays(mine: Path, state: Saved, world: Any) -> dict[str, str]:
    """Write the arrays of every rank, and return their checksums.

    If one rank cannot write, all raise its OSError after every rank has finished.
    """
    try:
        np.savez(mine, **_flatten(state))
        written: dict[str, str] | OSError = {mine.name: _sync(mine)}
    except OSError as error:
        written = error
    sums: dict[str, str] = {}
    for part in [written] if world is None else world.allgather(written):
        if isinstance(part, OSError):
            raise part
        sums |= part
    return sums


def _complete(
    aside: Path,
    folder: Path,
    copies: Sequence[Path],
    about: dict[str, Any],
    sums: dict[str, str],
    bed: CarriedBed | None,
) -> None:
    """Write the other files, give the checkpoint its name, and remove older checkpoints."""
    for copy in copies:
        shutil.copyfile(copy, aside / copy.name)
        sums = sums | {copy.name: _sync(aside / copy.name)}
    if bed is not None:
        saved_bed.write(aside / BED, bed)
        sums = sums | {BED: _sync(aside / BED)}
    about = {"format_version": FORMAT} | about | {"copies": [copy.name for copy in copies], "sha256": sums}
    (aside / ABOUT).write_text(json.dumps(about, indent=2, default=float), encoding="utf-8")
    _sync(aside / ABOUT)
    _sync(aside)
    shutil.rmtree(folder, ignore_errors=True)
    aside.replace(folder)
    _sync(folder.parent)
    good = _folder(folder.parents[1], about["good"])
    for old in _in_order(folder.parents[1])[:-KEPT]:
        if old != good:
            shutil.rmtree(old)


def find_newest(run: Path) -> Checkpoint | None:
    """Return the last checkpoint that is whole, or None if there is none."""
    torn: list[str] = []
    for folder in reversed(_in_order(run)):
        try:
            return Checkpoint(folder, _read_about(folder), tuple(torn))
        except TornCheckpoint as wrong:
            torn.append(f"{wrong}; the one before is taken")
    return None


def find_damage(run: Path) -> list[str]:
    """Return a message about each checkpoint that is not whole."""
    damage = []
    for folder in _in_order(run):
        try:
            _read_about(folder)
        except TornCheckpoint as wrong:
            damage.append(str(wrong))
    return damage


def find_at_sync_point(run: Path, sync_points: int) -> Checkpoint | None:
    """Return the checkpoint of a sync point, or None if there is none or it is not whole."""
    folder = _folder(run, sync_points)
    try:
        return Checkpoint(folder, _read_about(folder))
    except TornCheckpoint:
        return None


def remove_later(run: Path, checkpoint: Checkpoint) -> None:
    """Remove what came after ``checkpoint``, and what was left half written."""
    for folder in (run / FOLDER).iterdir():
        if folder.name.startswith(".") or folder.name > checkpoint.folder.name:
            shutil.rmtree(folder)


def _read_about(folder: Path) -> dict[str, Any]:
    """Return the content of ``checkpoint.json``, having checked it and the other files' checksums.

    Raises TornCheckpoint where something that a resumed run needs is missing or damaged.
    """
    try:
        about: dict[str, Any] = read_json(folder / ABOUT)
        _check_format(folder / ABOUT, about)
        for key in ("name", "level", "case", "files", "left_out"):
            about[key]
        for key in ORIGIN_KEYS:
            about["provenance"][key]
        int(about["provenance"]["ranks"])
        int(about["sync_points"])
        float(about["progress"]["figures"]["simulated_s"])
        for name in (*about["copies"], *about["sha256"]):
            if Path(name).name != name:
                raise TornCheckpoint(f"{folder / ABOUT} names a file elsewhere: {name}")
        for name, checksum in about["sha256"].items():
            if _checksum(folder / name) != checksum:
                raise TornCheckpoint(f"{folder / name} is not what was written")
    except KeyError as error:
        raise TornCheckpoint(f"{folder / ABOUT} does not say {error}") from error
    except (OSError, ValueError, AttributeError, TypeError) as error:
        raise TornCheckpoint(f"{folder} cannot be read: {error}") from error
    return about


def _check_format(file: Path, about: Mapping[str, Any]) -> None:
    """Raise OtherCheckpoint, with the commit that wrote a checkpoint, if it has another format."""
    try:
        check_format(file, about.get("format_version"), FORMAT)
    except OtherFormat as error:
        commit = about.get("provenance", {}).get("commit") or "unknown"
        raise OtherCheckpoint(f"{error}; its commit is {commit}") from None


def _in_order(run: Path) -> list[Path]:
    return sorted(folder for folder in (run / FOLDER).glob("*") if folder.name.isdigit())


def _folder(run: Path, sync_points: int) -> Path:
    return run / FOLDER / f"{sync_points:012d}"


def _of_rank(world: Any) -> str:
    return f"rank-{0 if world is None else world.rank}.npz"


def _checksum(file: Path) -> str:
    """Return the checksum of a file.  Raises OSError, also for one that is nearly all holes.

    Such a file takes no room in an archive, and hours to be read.
    """
    about = file.stat()
    if about.st_size > LARGE_BYTES and SPARSE * BLOCK_BYTES * about.st_blocks < about.st_size:
        raise OSError(errno.EFBIG, "has hardly any data for its size", str(file))
    with file.open("rb") as opened:
        return hashlib.file_digest(opened, "sha256").hexdigest()


def _sync(path: Path) -> str:
    """Wait until a file or folder is safely on the disk, and return the checksum of a file."""
    number = os.open(path, os.O_RDONLY)
    try:
        os.fsync(number)
    finally:
        os.close(number)
    return _checksum(path) if path.is_file() else ""
