"""Files that are written either completely or not at all."""

from __future__ import annotations

import errno
import json
import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any


@contextmanager
def written_whole(file: Path) -> Iterator[Path]:
    """Give the name of a new, empty file, which becomes ``file`` at the end; nothing is left after an error.

    Nobody can foresee that name, and a link in the place of ``file`` is replaced, not followed.  Raises
    OSError where ``file`` is a device, a pipe or a folder.
    """
    if file.exists() and not file.is_file():
        raise OSError(errno.EEXIST, "exists already and is not a file", str(file))
    aside = file.with_name(f".{file.name}.{secrets.token_hex(4)}")
    try:
        os.close(os.open(aside, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW, 0o666))
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(file)) from None
    try:
        yield aside
        aside.replace(file)
    except BaseException:  # half a file is useless and takes room
        aside.unlink(missing_ok=True)
        raise


def write_json(path: Path, value: Any) -> None:
    """Write a table as a JSON file, whole or not at all."""
    write_text(path, json.dumps(value, indent=2, default=float) + "\n")


def write_text(path: Path, text: str) -> None:
    """Write a text file, whole or not at all."""
    with written_whole(path) as aside:
        aside.write_text(text, encoding="utf-8")
