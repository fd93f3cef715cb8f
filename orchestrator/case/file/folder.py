"""Folders that a stranger may have filled: what the folder of a run or study may hold, and how its files are
opened.

A link, a pipe or a device in such a folder could lead a command to files elsewhere, or make it wait for ever.
"""

from __future__ import annotations

import json
import os
import stat
from pathlib import Path
from typing import Any

from orchestrator.case.file.layers import TOO_DEEP, is_too_deep

MOST_ENTRIES, DEEPEST = 5_000_000, 20
"""The files and folders that may lie in a folder, and in each other: an hour of a run leaves 10 000 files,
and the folder of a study has folders within four others."""
SHOWN = 10


class FolderUnusable(Exception):
    """An error about a folder that exists already, cannot be written, or cannot be used (exit code 2)."""


class UnreadableFile(ValueError):
    """An error about a damaged file in the folder of a run or study (exit code 2)."""


def admit(folder: Path) -> Path:
    """Return a folder in which nothing but files and folders of its own lies.

    Each command calls this before it reads or writes in the folder of a run or study.  The folder may itself
    be reached by a link, and it may be missing.  Raises FolderUnusable with the links, pipes and devices.
    """
    waiting, entries, foreign = [(os.fspath(folder), 1)], 0, []
    while waiting:
        place, depth = waiting.pop()
        try:
            with os.scandir(place) as inside:
                for entry in inside:
                    entries += 1
                    if entry.is_dir(follow_symlinks=False):
                        waiting.append((entry.path, depth + 1))
                    elif not entry.is_file(follow_symlinks=False) and os.path.lexists(entry.path):
                        foreign.append(f"  {entry.path} is {'a link' if entry.is_symlink() else 'no file'}")
        except (FileNotFoundError, NotADirectoryError):  # or removed by a run that is at work
            pass
        except OSError as error:
            raise FolderUnusable(f"{place}: cannot be read: {error.strerror}") from None
        if entries > MOST_ENTRIES or depth > DEEPEST:
            what = (
                f"more than {MOST_ENTRIES} files" if entries > MOST_ENTRIES else f"{depth} folders in another"
            )
            raise FolderUnusable(f"{folder}: holds {what}; it is not a folder of a run or study")
    if foreign:
        more = [f"  and {len(foreign) - SHOWN} more"] if len(foreign) > SHOWN else []
        raise FolderUnusable(
            f"{folder}: holds links, pipes or devices, which no run makes; nothing was read or written. Put "
            "files in their places, or remove them:\n" + "\n".join([*sorted(foreign)[:SHOWN], *more])
        )
    return folder


def part_of(folder: Path, name: str) -> Path:
    """Return the file of this name in an admitted folder.  Raises UnreadableFile if it would be elsewhere."""
    if Path(name).is_absolute() or ".." in Path(name).parts:
        raise UnreadableFile(f"names a file elsewhere: {name}")
    return folder / name


def read_json(file: Path) -> Any:
    """Return the content of a JSON file.

    Raises UnreadableFile for another kind of file, or one nested too deeply, and OSError.
    """
    try:
        with open(os.open(file, os.O_RDONLY | os.O_NONBLOCK), encoding="utf-8") as opened:
            if not stat.S_ISREG(os.fstat(opened.fileno()).st_mode):
                raise UnreadableFile(f"{file}: is not a file")
            content = json.load(opened)
    except UnreadableFile:
        raise
    except ValueError as error:
        raise UnreadableFile(f"{file}: is not JSON: {error}") from None
    except RecursionError:
        raise UnreadableFile(f"{file}: {TOO_DEEP}") from None
    if is_too_deep(content):
        raise UnreadableFile(f"{file}: {TOO_DEEP}")
    return content


def open_hdf5(file: Path) -> Any:
    """Return an HDF5 file, open for reading, all of whose data lie in itself.

    Raises UnreadableFile where a part of it is a link or lies in another file, and OSError.
    """
    import h5py  # It is imported here because most commands open no such file.

    if file.exists() and not file.is_file():
        raise UnreadableFile(f"{file}: is not a file")
    opened = h5py.File(file)

    def is_elsewhere(name: bytes, link: Any) -> bytes | None:
        if link.type == h5py.h5l.TYPE_HARD:
            part = h5py.h5o.open(opened.id, name)
            if not isinstance(part, h5py.h5d.DatasetID):
                return None
            made = part.get_create_plist()
            if not made.get_external_count() and made.get_layout() != h5py.h5d.VIRTUAL:
                return None
        return name

    try:
        elsewhere = opened.id.links.visit(is_elsewhere, info=True)  # the first that is
    except (KeyError, RuntimeError, SystemError) as error:
        opened.close()
        raise UnreadableFile(f"{file}: is damaged ({error})") from None
    if elsewhere is not None:
        opened.close()
        raise UnreadableFile(f"{file}: {elsewhere.decode(errors='replace')} is a link or lies elsewhere")
    return opened
