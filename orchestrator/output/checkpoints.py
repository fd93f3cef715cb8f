"""Checkpoints on the disk: the folder ``saves/<sync point>/`` in the folder of a run.

Each holds the arrays of every rank, a copy of what the run had recorded by then, and
``save.json``, which says what it is of and has the checksum of every other file.  A checkpoint is
written aside and renamed when all of it is on the disk; the last ``KEPT`` stay, and the last good one.
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from orchestrator.coupling.mpi import first_rank_does
from orchestrator.output.records.run_folder import check_format
from orchestrator.ports import Saved


def array_names(saved: Saved) -> set[str]:
    """Returns the names of all arrays in a state, as a checkpoint has them."""
    return set(_flat(saved))


def _flat(saved: Saved, within: str = "") -> dict[str, Any]:
    """Names with slashes; one that ends with a slash stands for "nothing in here"."""
    table: dict[str, Any] = {} if saved else {within: np.empty(0)}
    for name, value in saved.items():
        table |= _flat(value, f"{within}{name}/") if isinstance(value, dict) else {within + name: value}
    return table


def _nested(table: dict[str, Any]) -> Saved:
    """What ``_flat`` was made of."""
    saved: Saved = {}
    for path, value in table.items():
        *parents, name = path.split("/")
        inner = saved
        for parent in parents:
            inner = inner.setdefault(parent, {})
        if name:
            inner[name] = value
    return saved


KEPT = 2
FOLDER, ABOUT = "saves", "save.json"
FORMAT = 3
"""Version of a checkpoint: to be raised with every change of the names of its arrays (a test holds
them against tests/runs/checkpoint_names.txt), of their meaning, or of ``save.json``."""
SAID_OF_ORIGIN = ("ranks", "host", "machine", "python", "versions", "commit")


class TornCheckpoint(Exception):
    """A save that is not as it was written; the message says what is wrong with it."""


@dataclass(frozen=True)
class Checkpoint:
    """A whole save; ``about``: what ``save.json`` says, ``torn``: what is wrong with later ones."""

    folder: Path
    about: dict[str, Any]
    torn: tuple[str, ...] = ()

    @property
    def sync_points(self) -> int:
        return int(self.about["sync_points"])

    @property
    def good(self) -> int:
        """Sync point of the last save, up to this one, at which nothing was amiss; -1: of none."""
        return int(self.about.get("good", self.sync_points))

    @property
    def simulated_s(self) -> float:
        return float(self.about["progress"]["figures"]["simulated_s"])

    def state(self, world: Any) -> Saved:
        """Returns this rank's arrays."""
        with np.load(self.folder / _of_rank(world), allow_pickle=False) as file:
            return _nested({name: file[name] for name in file.files})

    def put_back(self, run: Path) -> None:
        """Copies the recorded files back, into the folder of the run."""
        for name in self.about["copies"]:
            aside = run / f".{name}"
            shutil.copyfile(self.folder / name, aside)
            aside.replace(run / name)


def write(run: Path, state: Saved, copies: Sequence[Path], about: dict[str, Any], world: Any) -> None:
    """Writes a new checkpoint into the folder of a run, of every rank of ``world``; ``about`` needs
    ``sync_points``, and those of the last ``good`` one.  Raises OSError on every rank where one cannot
    write; the saves before stay."""
    name = _name(about["sync_points"])
    aside = run / FOLDER / f".{name}"
    try:
        first_rank_does(world, lambda: _open(aside))
        sums = _parts(aside / _of_rank(world), state, world)
        first_rank_does(world, lambda: _complete(aside, name, copies, about, sums))
    except OSError:  # what is half written takes the room that the run's last words need
        first_rank_does(world, lambda: shutil.rmtree(aside, ignore_errors=True))
        raise


def _open(aside: Path) -> None:
    shutil.rmtree(aside, ignore_errors=True)
    aside.parent.mkdir(exist_ok=True)  # but not the run's own folder, should that have gone
    aside.mkdir()


def _parts(mine: Path, state: Saved, world: Any) -> dict[str, str]:
    """Writes the part of every rank; their checksums.  What one of them cannot write, all raise,
    when none is at work on its own any more."""
    try:
        np.savez(mine, **_flat(state))
        written: dict[str, str] | OSError = {mine.name: _on_disk(mine)}
    except OSError as error:
        written = error
    sums: dict[str, str] = {}
    for part in [written] if world is None else world.allgather(written):
        if isinstance(part, OSError):
            raise part
        sums |= part
    return sums


def _complete(
    aside: Path, name: str, copies: Sequence[Path], about: dict[str, Any], sums: dict[str, str]
) -> None:
    """The rest of the save, its ``name``, and one of the saves before less."""
    parent = aside.parent
    for copy in copies:
        shutil.copyfile(copy, aside / copy.name)
        sums = sums | {copy.name: _on_disk(aside / copy.name)}
    about = {"format_version": FORMAT} | about | {"copies": [copy.name for copy in copies], "sha256": sums}
    (aside / ABOUT).write_text(json.dumps(about, indent=2, default=float), encoding="utf-8")
    _on_disk(aside / ABOUT)
    _sync(aside)
    shutil.rmtree(parent / name, ignore_errors=True)
    aside.replace(parent / name)
    _sync(parent)
    for old in _names(parent)[:-KEPT]:
        if old != _name(about["good"]):
            shutil.rmtree(parent / old)


def newest(run: Path) -> Checkpoint | None:
    """Returns the last checkpoint that is whole."""
    torn: list[str] = []
    for name in reversed(_names(run / FOLDER)):
        try:
            return Checkpoint(run / FOLDER / name, _checked(run / FOLDER / name), tuple(torn))
        except TornCheckpoint as wrong:
            torn.append(f"{wrong}; the one before is taken")
    return None


def find_damage(run: Path) -> list[str]:
    """Returns what is wrong with the checkpoints that are not whole."""
    damage = []
    for name in _names(run / FOLDER):
        try:
            _checked(run / FOLDER / name)
        except TornCheckpoint as wrong:
            damage.append(str(wrong))
    return damage


def at_sync_point(run: Path, sync_points: int) -> Checkpoint | None:
    """Returns the checkpoint of a sync point, if there is one and it is whole."""
    folder = run / FOLDER / _name(sync_points)
    try:
        return Checkpoint(folder, _checked(folder))
    except TornCheckpoint:
        return None


def remove_later(run: Path, save: Checkpoint) -> None:
    """Removes what came after ``save``, and what was left half written."""
    for folder in (run / FOLDER).iterdir():
        if folder.name.startswith(".") or folder.name > save.folder.name:
            shutil.rmtree(folder)


def _checked(folder: Path) -> dict[str, Any]:
    """What ``save.json`` says, if the files are as it says.  Raises TornCheckpoint."""
    try:
        about: dict[str, Any] = json.loads((folder / ABOUT).read_text(encoding="utf-8"))
        check_format(folder / ABOUT, about.get("format_version"), FORMAT)
        _must_say(about)
        for name in about["copies"]:
            if Path(name).name != name:
                raise TornCheckpoint(f"{folder / ABOUT} names a file elsewhere: {name}")
        for name, digest in about["sha256"].items():
            if _digest(folder / name) != digest:
                raise TornCheckpoint(f"{folder / name} is not what was written")
    except KeyError as error:
        raise TornCheckpoint(f"{folder / ABOUT} does not say {error}") from error
    except (OSError, ValueError, AttributeError, TypeError) as error:
        raise TornCheckpoint(f"{folder} cannot be read: {error}") from error
    return about


def _must_say(about: dict[str, Any]) -> None:
    """Raises KeyError for what is missing of that which a run is taken up with; ValueError or
    TypeError for what is something else."""
    for key in ("name", "level", "case", "files", "copies", "sha256"):
        about[key]
    for key in SAID_OF_ORIGIN:
        about["provenance"][key]
    int(about["provenance"]["ranks"])
    int(about["sync_points"])
    float(about["progress"]["figures"]["simulated_s"])


def _names(parent: Path) -> list[str]:
    """Saves in order of time."""
    if not parent.is_dir():
        return []
    return sorted(folder.name for folder in parent.iterdir() if folder.name.isdigit())


def _name(sync_points: int) -> str:
    return f"{sync_points:012d}"


def _of_rank(world: Any) -> str:
    return f"rank-{0 if world is None else world.rank}.npz"


def _on_disk(file: Path) -> str:
    """Waits until the file is there to stay; its checksum."""
    _sync(file)
    return _digest(file)


def _digest(file: Path) -> str:
    with file.open("rb") as opened:
        return hashlib.file_digest(opened, "sha256").hexdigest()


def _sync(path: Path) -> None:
    number = os.open(path, os.O_RDONLY)
    try:
        os.fsync(number)
    finally:
        os.close(number)
