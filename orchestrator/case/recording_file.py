"""The file of a recording: a group for each panel (docs/theory/panel_recorded.md)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from orchestrator.case.tables.quantities import unit_of
from orchestrator.ports.recording import RecordedGrid, Recording

FORMAT = 2
"""Version of the file, as its attribute ``format_version``; files of older versions have none."""
LENGTHS = ("length_m", "span_m", "width_m", "clamp_m", "thickness_m")
SERIES = ("shape_m", "rate_m", "rest_m", "pull_N", "rest_pull_N")


class UnreadableRecording(Exception):
    """No such file, or no recording; the message says what is wrong."""


@dataclass(frozen=True)
class RecordedShape:
    """What is recorded of one panel, and its lengths in m by name."""

    recording: Recording
    shape: dict[str, float]


@dataclass(frozen=True)
class File:
    """``speed_rad_per_s`` of the machine that was recorded, and its panels by name."""

    speed_rad_per_s: float
    panels: Mapping[str, RecordedShape]


def write(path: Path, content: File) -> None:
    """Whole or not at all.  Raises OSError."""
    import h5py  # here because checks of cases without recordings do not need it

    aside = path.with_name(f".{path.name}")
    with h5py.File(aside, "w") as file:
        file.attrs["format_version"] = FORMAT
        file.attrs["speed_rad_per_s"] = content.speed_rad_per_s
        for name, panel in content.panels.items():
            group, recording = file.create_group(name), panel.recording
            lengths_m = {name: panel.shape[name] for name in LENGTHS}
            group.attrs.update({**lengths_m, "cycles": recording.cycles})
            arrays = {series: getattr(recording, series) for series in SERIES}
            arrays |= {"rows_m": recording.grid.rows_m, "columns_m": recording.grid.columns_m}
            for series, values in arrays.items():
                dataset = group.create_dataset(series, data=values)
                dataset.attrs["unit"] = "m/rad" if series == "rate_m" else unit_of(series)
    aside.replace(path)


def read(path: Path) -> File:
    """Raises Unreadable."""
    if not path.is_file():
        raise UnreadableRecording(f"{path}: no such file; flipflow record makes one from a run's folder")
    import h5py  # here because checks of cases without recordings do not need it

    try:
        with h5py.File(path) as file:
            speed_rad_per_s = float(file.attrs["speed_rad_per_s"])
            version = file.attrs.get("format_version")
            if version != FORMAT:
                has = "no version of its format, as older ones" if version is None else f"format {version}"
                raise UnreadableRecording(
                    f"{path}: has {has}; this flipflow reads {FORMAT}: record the run again"
                )
            return File(speed_rad_per_s, {name: _panel(group) for name, group in file.items()})
    except (OSError, KeyError, ValueError, AttributeError) as error:
        raise UnreadableRecording(f"{path}: is no recording ({error})") from None


def _panel(group: Any) -> RecordedShape:
    shape = {name: float(group.attrs[name]) for name in LENGTHS}
    grid = RecordedGrid(group["rows_m"][:], group["columns_m"][:])
    series = {name: np.asarray(group[name][:]) for name in SERIES}
    return RecordedShape(Recording(grid, int(group.attrs["cycles"]), **series), shape)
