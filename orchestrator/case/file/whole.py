"""Files that are written either completely or not at all."""

from __future__ import annotations

import errno
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def written_whole(file: Path) -> Iterator[Path]:
    """Give another name to write to, which becomes ``file`` at the end; nothing is left after an error.

    Raises OSError where ``file`` is a device, a pipe or a folder.
    """
    if file.exists() and not file.is_file():
        raise OSError(errno.EEXIST, "exists already and is no file", str(file))
    aside = file.with_name(f".{file.name}")
    try:
        yield aside
        aside.replace(file)
    except BaseException:  # half a file is useless and takes room
        aside.unlink(missing_ok=True)
        raise
