"""Files that are written either completely or not at all."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def written_whole(file: Path) -> Iterator[Path]:
    """Give another name to write to, which becomes ``file`` at the end; nothing is left after an error."""
    aside = file.with_name(f".{file.name}")
    try:
        yield aside
        aside.replace(file)
    except BaseException:  # half a file is useless and takes room
        aside.unlink(missing_ok=True)
        raise
