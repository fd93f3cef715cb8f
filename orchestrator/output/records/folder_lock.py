"""One process at a time in a folder: a lock that the system lets go of, however its holder ends."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from orchestrator.output.records.run_folder import FolderUnusable

OF_A_RUN = "run.log"
OF_A_STUDY = ".lock"


@contextmanager
def held(file: Path) -> Iterator[None]:
    """Holds ``file``, made where it is missing, while inside.  Raises FolderUnusable where another
    process holds it.  On a file system without locks nobody is kept out."""
    with file.open("a") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise FolderUnusable(
                f"{file.parent}: another flipflow is at work there; wait for its end, or give "
                "another folder with --out"
            ) from None
        except OSError:  # no locks on this file system
            pass
        yield


@contextmanager
def study(folder: Path) -> Iterator[None]:
    """Makes the folder of a study, or goes on in it; nobody else does meanwhile.  Raises
    FolderUnusable."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FolderUnusable(f"{folder}: cannot be made: {error.strerror}") from None
    with held(folder / OF_A_STUDY):
        yield


def at_work(folder: Path) -> bool:
    """Whether a run is going on in this folder; none does where nobody may write."""
    if not (folder / OF_A_RUN).exists() or not os.access(folder / OF_A_RUN, os.W_OK):
        return False
    try:
        with held(folder / OF_A_RUN):
            return False
    except FolderUnusable:
        return True
