"""A file that outlives a full disk.

HDF5 does not survive a write that fails: the file is lost and the process may crash when it
ends.  So it writes through ``Reserved``, which keeps some room on the disk beside the file, gives
that up for the write that found no room, and remembers the error for the next ``check``.
"""

from __future__ import annotations

import io
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, Literal

RESERVE_BYTES = 16 * 1024**2  # enough for the rows in memory, the file's tables and a summary


class Reserved(io.RawIOBase):
    """The file ``path``, to read and write: a new one, or the one that is there.  Raises OSError if
    there is no room at all."""

    def __init__(self, path: Path, mode: Literal["w+b", "r+b"] = "w+b") -> None:
        self._reserve = path.with_name(f".{path.name}.reserve")
        self._error: OSError | None = None
        with self._reserve.open("wb") as reserve:
            os.posix_fallocate(reserve.fileno(), 0, RESERVE_BYTES)
        self._file = path.open(mode, buffering=0)

    def check(self) -> None:
        """Raises the OSError of the first write that found no room."""
        if self._error is not None:
            raise self._error

    def give_up_reserve(self) -> None:
        """Room for what must still be written."""
        self._reserve.unlink(missing_ok=True)

    def write(self, data: Any) -> int:
        return self._anyhow(lambda: self._file.write(data), len(data))

    def truncate(self, size: int | None = None) -> int:
        return self._anyhow(lambda: self._file.truncate(size), size or 0)

    def _anyhow(self, act: Callable[[], int], otherwise: int) -> int:
        try:
            return act()
        except OSError as error:
            self._error = self._error or error
        self.give_up_reserve()
        try:
            return act()
        except OSError:  # the file is lost, but the process must be able to say so
            return otherwise

    def readinto(self, buffer: Any) -> int:
        return self._file.readinto(buffer)

    def seek(self, offset: int, whence: int = 0) -> int:
        return self._file.seek(offset, whence)

    def tell(self) -> int:
        return self._file.tell()

    def close(self) -> None:
        self.give_up_reserve()
        self._file.close()
        super().close()
