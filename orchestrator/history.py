"""``history.h5``: time series with units, readable by h5py and pandas while the run goes on.

Every series is a dataset whose first axis runs along the group's ``time_s``; the attribute
``unit`` gives its unit and ``columns`` what the other axes mean.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import h5py
import numpy as np

from orchestrator.full_disk import Reserved
from orchestrator.ports import Array

ROWS_IN_MEMORY = 500


class History:
    """Rows are gathered in memory and appended in blocks; ``flush`` writes what is there."""

    def __init__(self, path: Path) -> None:
        self._disk = Reserved(path)
        self._file = h5py.File(self._disk, "w")
        self._rows: dict[str, list[dict[str, Array]]] = {}

    def add(self, group: str, time_s: float, values: Mapping[str, Array | float]) -> None:
        """One row at ``time_s``; the names of a group's values are the same in every row."""
        row = {name: np.asarray(value, dtype=np.float64) for name, value in values.items()}
        rows = self._rows.setdefault(group, [])
        rows.append({"time_s": np.float64(time_s) * np.ones(())} | row)
        if len(rows) >= ROWS_IN_MEMORY:
            self._append(group)

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
            block = np.stack([row[name] for row in rows])
            where = f"{group}/{name}"
            if where not in self._file:
                dataset = self._file.create_dataset(
                    where,
                    shape=(0, *block.shape[1:]),
                    maxshape=(None, *block.shape[1:]),
                    dtype=np.float64,
                )
                dataset.attrs["unit"] = _unit(name)
            dataset = self._file[where]
            dataset.resize(len(dataset) + len(block), axis=0)
            dataset[-len(block) :] = block


def _unit(name: str) -> str:
    """The unit that a name carries: position_m -> m, speed_m_s -> m/s, force_N -> N."""
    for ending, unit in _UNITS.items():
        if name.endswith(ending):
            return unit
    return "1"


_UNITS = {
    "_kg_m_s": "kg m/s",
    "_m_s2": "m/s2",
    "_rad_s": "rad/s",
    "_kg_s": "kg/s",
    "_N_s": "N s",
    "_m_s": "m/s",
    "_kg": "kg",
    "_J": "J",
    "_N": "N",
    "_s": "s",
    "_m": "m",
}
