"""One series of ``history.h5``: a dataset whose first axis grows."""

from __future__ import annotations

from math import prod
from typing import Any

import h5py
import numpy as np

from orchestrator.case.units import unit_of
from orchestrator.ports import Array, Indices

# room on the disk is taken for so many rows at once.  HDF5 remembers up to 2 MB of where chunks
# are, in 17 MB of memory (docs/reliability.md, "Long runs"): few chunks, for a small file
CHUNK_ROWS, CHUNK_BYTES = 1024, 32768


class Column:
    """Stays open, and writes without h5py's selections: both would take longer than the rows."""

    def __init__(self, file: h5py.File, where: str, inner: tuple[int, ...], dtype: np.dtype[Any]) -> None:
        """The one that is there, or a new one with rows of shape ``inner``."""
        if where not in file:
            row_bytes = dtype.itemsize * prod(inner)
            rows = max(1, min(CHUNK_ROWS, CHUNK_BYTES // max(1, row_bytes)))
            chunks = (rows, *inner) if row_bytes else True  # HDF5 has no chunks of nothing
            most = (None, *inner)
            dataset = file.create_dataset(where, (0, *inner), dtype, chunks=chunks, maxshape=most)
            dataset.attrs["unit"] = unit_of(where)
        self._dataset = file[where].id
        self._rows = int(self._dataset.shape[0])

    def append(self, block: Array | Indices) -> None:
        """Any number of rows; ``block`` (rows, *inner)."""
        first, self._rows = self._rows, self._rows + len(block)
        inner = block.shape[1:]
        self._dataset.set_extent((self._rows, *inner))
        if not block.size:
            return
        there = self._dataset.get_space()
        there.select_hyperslab((first, *(0 for _ in inner)), block.shape)
        rows = h5py.h5s.create_simple(block.shape)
        self._dataset.write(rows, there, np.ascontiguousarray(block))
