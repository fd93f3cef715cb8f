"""``history.h5``: time series with units, readable by h5py and pandas while the run goes on.

Every series is a dataset whose first axis runs along the group's ``time_s``; the attribute
``unit`` gives its unit.  An event table has a row for each event.

HDF5 does not survive a write that fails: the file is lost, and the process may crash when it
ends.  HDF5 therefore writes through ``Reserved``, which reserves some room on the disk beside the file.
If a write finds no room, ``Reserved`` gives up the reserve and remembers the error for the next ``check``.
"""

from __future__ import annotations

import errno
import io
import os
import shutil
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from math import prod
from pathlib import Path
from typing import Any, Literal

import h5py
import numpy as np

from orchestrator.case.bed.saved_bed import GRAINS
from orchestrator.case.tables.quantities import unit_along, unit_of
from orchestrator.ports import Array, Indices

RESERVE_BYTES = 16 * 1024**2  # room for the rows in memory, the file's tables and a summary


class Reserved(io.RawIOBase):
    """A file to read and write, new or existing, with reserved room on the disk.

    Raises OSError if there is no room for the reserve.
    """

    def __init__(self, path: Path, mode: Literal["w+b", "r+b"] = "w+b") -> None:
        self._reserve = path.with_name(f".{path.name}.reserve")
        self._error: OSError | None = None
        with self._reserve.open("wb") as reserve:
            os.posix_fallocate(reserve.fileno(), 0, RESERVE_BYTES)
        self._file = path.open(mode, buffering=0)

    def check(self) -> None:
        """Raise the OSError of the first write that found no room."""
        if self._error is not None:
            raise self._error

    def give_up_reserve(self) -> None:
        """Free the reserved room for the last writes."""
        self._reserve.unlink(missing_ok=True)

    def write(self, data: Any) -> int:
        rest = memoryview(data).cast("B")
        while rest:  # a disk that fills takes a part, and only the next write fails
            rest = rest[self._anyhow(partial(self._file.write, rest), len(rest)) :]
        return len(data)

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
        except OSError:  # the file is lost, but the process must live to report it
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


# the file grows by chunks of so many rows.  HDF5 keeps the places of chunks in up to 17 MB of memory
# (docs/reliability.md, "Long runs"), so that chunks must be few; a small file needs small chunks
CHUNK_ROWS, CHUNK_BYTES = 1024, 32768


class Column:
    """A dataset to append to, existing or new, with rows of shape ``inner``.

    The dataset stays open and is written without h5py's selections: reopening and selecting would take
    longer than writing the rows.
    """

    def __init__(self, file: h5py.File, where: str, inner: tuple[int, ...], dtype: np.dtype[Any]) -> None:
        if where not in file:
            row_bytes = dtype.itemsize * prod(inner)
            rows = max(1, min(CHUNK_ROWS, CHUNK_BYTES // max(1, row_bytes)))
            chunks = (rows, *inner) if row_bytes else True  # HDF5 refuses chunks of no bytes
            most = (None, *inner)
            dataset = file.create_dataset(where, (0, *inner), dtype, chunks=chunks, maxshape=most)
            dataset.attrs["unit"] = unit_of(where)
        self._dataset = file[where].id
        self._rows = int(self._dataset.shape[0])

    def append(self, block: Array | Indices) -> None:
        """Append the rows of ``block`` (rows, *inner)."""
        first, self._rows = self._rows, self._rows + len(block)
        inner = block.shape[1:]
        self._dataset.set_extent((self._rows, *inner))
        if not block.size:
            return
        there = self._dataset.get_space()
        there.select_hyperslab((first, *(0 for _ in inner)), block.shape)
        rows = h5py.h5s.create_simple(block.shape)
        self._dataset.write(rows, there, np.ascontiguousarray(block))


ROWS_IN_MEMORY = 500
HISTORY_FORMAT = 6
"""The version of the file's format, in its attribute ``format_version``.  Raise it with every change of
a group's columns or of their meaning (docs/run-folder.md, "history.h5").  The oldest files have none."""
COLUMNS: dict[str, tuple[str, ...]] = {
    "frames": ("displacement_m", "velocity_m_per_s", "rotation_rad", "spin_rad_per_s"),
    "probes": ("position_m", "velocity_m_per_s"),
    "accelerations": ("acceleration_m_per_s2",),
    "point_cycles": ("sync_points", "least_m", "most_m", "mean_m", "farthest_m", "fastest_m_per_s"),
    "panel_cycles": (
        *("sync_points", "pull_least_N", "pull_mean_N", "pull_most_N", "clamp_most_N", "load_mean_N"),
        *("stretch_least", "stretch_most", "sag_most_m", "middle_least_m", "middle_most_m"),
    ),
    "forces": ("load_N", "reaction_N", "first_clamp_N", "second_clamp_N", "stops_N"),
    "bushings": ("deformation_m", "force_N"),
    "loads": (
        *("center_m", "rotation_rad", "spin_rad_per_s"),
        *("acceleration_m_per_s2", "angular_acceleration_rad_per_s2"),
        *("lag_N_m", "place_m", "force_N"),
    ),
    "shafts": ("angle_rad",),
    "shapes": ("position_m", "velocity_m_per_s"),
    "panels": ("centre_line_m",),
    "fed": ("id", *GRAINS),
    "removed": (
        *("id", "position_m", "velocity_m_per_s", *GRAINS, "exit"),
        *("contacts", "over_s", "within_reach_s", "last_panel"),
    ),
    "feeds": ("due_kg", "fed_kg"),
    "bed": ("particles", "mass_kg", "mean_speed_m_per_s", "mean_velocity_m_per_s", "highest_m"),
    "overlaps": ("between_m", "between_per_diameter", "surface_m", "surface_per_diameter"),
    "profile": ("along_m", "mass_kg", "velocity_m_per_s", "depth_m"),
    "bulk": ("mass_kg", "density_kg_per_m3", "slope_deg"),
    "wear": ("worn_m3", "mean_m", "depth_m"),
    "held": ("stickers", "mass_kg", "pegged_kg", "openings"),
}
"""The datasets of every kind of group beside ``time_s``.  The group ``energy`` has a dataset for each term of
the ledger, and ``results`` mirrors the results."""


def columns(kind: str, record: object) -> dict[str, Any]:
    """Return the values of a record by the column names of a kind of group, without the time."""
    return {name: getattr(record, name) for name in COLUMNS[kind]}


Groups = Iterator[tuple[str, dict[str, Array]]]
"""Names of groups, each with the values of its columns."""


def groups(kind: str, names: Iterable[str], columns: Mapping[str, Array]) -> Groups:
    """Yield the group of each name with its values; the first axis of every column goes with the names."""
    for name, *values in zip(names, *columns.values(), strict=True):
        yield f"{kind}/{name}", dict(zip(columns, values, strict=True))


class History:
    """The time series in a new file, or with ``goes_on`` in an existing file.

    Rows are collected in memory and appended in blocks; ``flush`` writes the rows in memory.  ``derived`` has
    functions by the names of groups whose rows are not written, but the groups made of their columns.
    """

    def __init__(self, path: Path, goes_on: bool = False) -> None:
        self._disk = Reserved(path, "r+b" if goes_on else "w+b")
        # a cache of chunks would take up to 1 MB for each column that stays open
        self._file = h5py.File(self._disk, "r+" if goes_on else "w", rdcc_nbytes=0)
        self._rows: dict[str, list[dict[str, Array | float]]] = {}
        self._columns: dict[str, Column] = {}
        self.derived: dict[str, Callable[[Mapping[str, Array]], Groups]] = {}
        if not goes_on:
            self._file.attrs["format_version"] = HISTORY_FORMAT
        self._file.flush()  # so that a run that is killed before its first row leaves a valid file

    def add(self, group: str, time_s: float, values: Mapping[str, Array | float]) -> None:
        """Add one row at ``time_s``; the names of a group's values are the same in every row."""
        rows = self._rows.setdefault(group, [])
        rows.append({"time_s": time_s, **values})
        if len(rows) >= ROWS_IN_MEMORY:
            self._append(group)

    def add_events(self, group: str, values: Mapping[str, Array | Indices]) -> None:
        """Append any number of rows to an event table; whole numbers stay whole numbers."""
        for name, rows in values.items():
            self._extend(f"{group}/{name}", rows)

    def describe(self, group: str, name: str, values: Sequence[str] | Array) -> None:
        """Write a list of words, or an array of numbers, as an attribute of a group."""
        attributes = self._file.require_group(group).attrs
        if isinstance(values, np.ndarray):
            attributes.create(name, values)
        else:
            attributes.create(name, list(values), shape=len(values), dtype=h5py.string_dtype())

    def flush(self) -> None:
        """Write all rows to the disk.  Raises OSError if the disk is full; all rows so far are kept."""
        for group in self._rows:
            self._append(group)
        self._file.flush()
        self._disk.check()

    def close(self) -> None:
        """Write all rows and close the file."""
        for group in self._rows:
            self._append(group)
        self._file.close()
        self._disk.close()

    def _append(self, group: str) -> None:
        rows = self._rows[group]
        if not rows:
            return
        columns = {name: np.array([row[name] for row in rows], np.float64) for name in rows[0]}
        made = list(self.derived[group](columns)) if group in self.derived else [(group, columns)]
        self._rows[group] = []
        for where, values in made:
            for name, block in (values | {"time_s": columns["time_s"]}).items():
                self._extend(f"{where}/{name}", block)

    def _extend(self, where: str, block: Array | Indices) -> None:
        if where not in self._columns:
            kind, name = where.split("/")[0], where.split("/")[-1]
            if kind in COLUMNS and name not in (*COLUMNS[kind], "time_s"):
                raise KeyError(f"{where} is not in the schema of history.h5")
            self._columns[where] = Column(self._file, where, block.shape[1:], block.dtype)
        self._columns[where].append(block)


GROUP, ACCELERATIONS = "results", "accelerations"
ROOM_BYTES = 4 * 1024**2


def write_accelerations(
    history_file: Path, accelerations: Mapping[str, tuple[Array, Array]], band_Hz: float
) -> None:
    """Write the group ``accelerations`` anew: for each point, times (n,) and accelerations (n, 3) in m/s2.

    ``band_Hz``, the highest frequency that they show, is an attribute of the group.  Raises OSError if the
    disk is nearly full: a failed write would lose the whole file.
    """
    needed = sum(time_s.nbytes + values.nbytes for time_s, values in accelerations.values())
    _check_room(history_file, ACCELERATIONS, needed)
    with h5py.File(history_file, "a") as history:
        if ACCELERATIONS in history:
            del history[ACCELERATIONS]
        history.create_group(ACCELERATIONS).attrs["band_Hz"] = band_Hz
        for name, (time_s, values) in accelerations.items():
            for column, data in zip(("time_s", *COLUMNS[ACCELERATIONS]), (time_s, values), strict=True):
                dataset = history.create_dataset(f"{ACCELERATIONS}/{name}/{column}", data=data)
                dataset.attrs["unit"] = unit_of(column)


def write_results(history_file: Path, results: Mapping[str, Any]) -> None:
    """Write the group ``results`` anew.

    An estimate becomes a number with the attributes ``half_width`` and ``batches``, a list of numbers
    becomes a dataset, and each table of a list becomes a group; None becomes NaN.  Raises OSError if the
    disk is nearly full: a failed write would lose the whole file.
    """
    _check_room(history_file, GROUP)
    with h5py.File(history_file, "a") as history:
        if GROUP in history:
            del history[GROUP]
        _put(history.create_group(GROUP), results)


def _check_room(history_file: Path, group: str, needed_bytes: int = 0) -> None:
    if shutil.disk_usage(history_file.parent).free < ROOM_BYTES + needed_bytes:
        raise OSError(errno.ENOSPC, f"no room for the group {group} of {history_file.name}")


def _put(group: Any, table: Mapping[str, Any]) -> None:
    for name, value in table.items():
        key = str(name).replace("/", "|")
        if isinstance(value, Mapping) and set(value) >= {"value", "half_width", "batches"}:
            dataset = _number(group, key, value["value"])
            dataset.attrs["half_width"] = np.array(value["half_width"], float)
            dataset.attrs["batches"] = value["batches"]
            for told in {"counting", "standard_error"} & set(value):
                dataset.attrs[told] = value[told]
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
    """Write a number, or a list or table of numbers, and return its dataset; None becomes NaN."""
    group[key] = np.array(value, dtype=float)
    group[key].attrs["unit"] = unit_along([*group.name.split("/"), key])
    return group[key]
