"""The same results in ``history.h5``: the group ``results`` mirrors the table, with units."""

from __future__ import annotations

import errno
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from orchestrator.case.units import unit_of

GROUP = "results"
ROOM_BYTES = 4 * 1024**2


def store(history_file: Path, found: Mapping[str, Any]) -> None:
    """Writes the group anew.  An estimate becomes a number with the attributes ``half_width`` and
    ``batches``, a list of numbers a dataset, a list of tables a group each; NaN is unknown.

    Raises OSError where the disk is too full to be sure: HDF5 would lose the whole file."""
    if shutil.disk_usage(history_file.parent).free < ROOM_BYTES:
        raise OSError(errno.ENOSPC, f"no room for the group {GROUP} of {history_file.name}")
    with h5py.File(history_file, "a") as history:
        if GROUP in history:
            del history[GROUP]
        _put(history.create_group(GROUP), found)


def _put(group: Any, table: Mapping[str, Any]) -> None:
    for name, value in table.items():
        key = str(name).replace("/", "|")
        if isinstance(value, Mapping) and set(value) == {"value", "half_width", "batches"}:
            dataset = _number(group, key, value["value"])
            dataset.attrs["half_width"] = _or_nan(value["half_width"])
            dataset.attrs["batches"] = value["batches"]
        elif isinstance(value, Mapping):
            _put(group.create_group(key), value)
        elif isinstance(value, list) and value and isinstance(value[0], Mapping):
            for number, row in enumerate(value):
                _put(group.create_group(f"{key}/{number + 1}"), row)
        elif isinstance(value, str):
            group[key] = value
        else:
            _number(group, key, value)


def _number(group: Any, key: str, value: Any) -> Any:
    """A number, a list of them or a table; None becomes NaN."""
    group[key] = np.array(value, dtype=float)
    group[key].attrs["unit"] = unit_of(key)
    return group[key]


def _or_nan(value: Any) -> float:
    return float("nan") if value is None else float(value)
