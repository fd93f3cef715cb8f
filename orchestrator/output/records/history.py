"""``history.h5``: time series with units, readable by h5py and pandas while the run goes on.

Every series is a dataset whose first axis runs along the group's ``time_s``; the attribute
``unit`` gives its unit.  An event table has a row for each event.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import h5py
import numpy as np

from orchestrator.output.records.column import Column
from orchestrator.output.records.full_disk import Reserved
from orchestrator.ports import Array, Indices

ROWS_IN_MEMORY = 500


class History:
    """Rows are gathered in memory and appended in blocks; ``flush`` writes what is there."""

    def __init__(self, path: Path, goes_on: bool = False) -> None:
        """A new file, or one that goes on."""
        self._disk = Reserved(path, "r+b" if goes_on else "w+b")
        # without a cache of chunks, of up to 1 MB for each column that stays open
        self._file = h5py.File(self._disk, "r+" if goes_on else "w", rdcc_nbytes=0)
        self._rows: dict[str, list[dict[str, Array | float]]] = {}
        self._columns: dict[str, Column] = {}
        self._file.flush()  # what is killed before its first row leaves a file that opens

    def add(self, group: str, time_s: float, values: Mapping[str, Array | float]) -> None:
        """One row at ``time_s``; the names of a group's values are the same in every row."""
        rows = self._rows.setdefault(group, [])
        rows.append({"time_s": time_s, **values})
        if len(rows) >= ROWS_IN_MEMORY:
            self._append(group)

    def events(self, group: str, values: Mapping[str, Array | Indices]) -> None:
        """Rows of an event table, of any number, appended at once; whole numbers stay whole."""
        for name, rows in values.items():
            self._extend(f"{group}/{name}", rows)

    def describe(self, group: str, name: str, words: Sequence[str]) -> None:
        """An attribute of a group: a list of words."""
        attributes = self._file.require_group(group).attrs
        attributes.create(name, list(words), shape=len(words), dtype=h5py.string_dtype())

    def flush(self) -> None:
        """Raises OSError when the disk is full; all that was added until then is kept."""
        for group in self._rows:
            self._append(group)
        self._file.flush()
        self._disk.check()

    def close(self) -> None:
        for group in self._rows:
            self._append(group)
        self._file.close()
        self._disk.close()

    def _append(self, group: str) -> None:
        rows, self._rows[group] = self._rows[group], []
        if not rows:
            return
        for name in rows[0]:
            self._extend(f"{group}/{name}", np.array([row[name] for row in rows], np.float64))

    def _extend(self, where: str, block: Array | Indices) -> None:
        if where not in self._columns:
            self._columns[where] = Column(self._file, where, block.shape[1:], block.dtype)
        self._columns[where].append(block)
