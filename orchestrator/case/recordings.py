"""Recordings of panels: their file, and the plans to play them back on the recorded panels of a case.

The file has a group for each panel (docs/theory/panel_recorded.md).  The machine's angle is the
angle of its slowest exciter after the run-up, from the direction of z about the shaft; in a machine
without exciters it is the speed of the slowest drive times time, and the phase of its largest component.
"""

from __future__ import annotations

import errno
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from orchestrator.case.deck.panels import SinglePanel, single_panels
from orchestrator.case.file.folder import open_hdf5
from orchestrator.case.file.whole import written_whole
from orchestrator.case.tables.case import Case
from orchestrator.case.tables.frames import Exciter
from orchestrator.case.tables.quantities import Vector, unit_of
from orchestrator.ports import Array
from orchestrator.ports.recording import Playback, RecordedGrid, Recording

FORMAT = 3
"""Version of the file in its attribute ``format_version``; files of older versions have no such attribute."""
ALIKE = 1e-6  # Lengths with a smaller relative difference count as equal.
RECTANGLE = ("length_m", "span_m", "width_m", "clamp_m", "clamp_angle_deg")
SERIES = ("shape_m", "rate_m", "rest_m", "pull_N", "rest_pull_N")


class UnreadableRecording(Exception):
    """An error for a file that does not exist or is no recording; the message says what is wrong."""


class NoMatch(Exception):
    """An error for a recording that does not fit; the message names the panel and the reason."""


@dataclass(frozen=True)
class RecordedShape:
    """The recording of one panel, and the panel's lengths in m and angle in degrees by name (``shape``).

    A recording without the clamps' angle or the moulded sag is one of a panel that has none.
    """

    recording: Recording
    shape: dict[str, float]


@dataclass(frozen=True)
class File:
    """The content of a recording: the recorded machine's speed, what turned it, and its panels by name."""

    speed_rad_per_s: float
    turned_by: str
    panels: Mapping[str, RecordedShape]


def write(path: Path, content: File) -> None:
    """Write a recording, either completely or not at all, in the place of another one but of no other file.

    Raises OSError.
    """
    import h5py  # It is imported here because checks of cases without recordings do not need it.

    if path.exists():
        try:
            read(path)
        except UnreadableRecording:
            what = "exists already and is no recording of this version; give another file"
            raise OSError(errno.EEXIST, what, str(path)) from None
    with written_whole(path) as aside, h5py.File(aside, "w") as file:
        file.attrs["format_version"] = FORMAT
        file.attrs["speed_rad_per_s"] = content.speed_rad_per_s
        file.attrs["turned_by"] = content.turned_by
        for name, panel in content.panels.items():
            group, recording = file.create_group(name), panel.recording
            group.attrs.update({**panel.shape, "cycles": recording.cycles})
            arrays = {series: getattr(recording, series) for series in SERIES}
            arrays |= {"rows_m": recording.grid.rows_m, "columns_m": recording.grid.columns_m}
            for series, values in arrays.items():
                dataset = group.create_dataset(series, data=values)
                dataset.attrs["unit"] = "m/rad" if series == "rate_m" else unit_of(series)


def read(path: Path) -> File:
    """Read a recording.  Raises UnreadableRecording."""
    if not path.is_file():
        raise UnreadableRecording(f"{path}: no such file; flipflow record makes one from a run's folder")
    try:
        with open_hdf5(path) as file:
            speed_rad_per_s = float(file.attrs["speed_rad_per_s"])
            version = file.attrs.get("format_version")
            if version != FORMAT:
                has = "no version of its format, as older ones" if version is None else f"format {version}"
                raise UnreadableRecording(
                    f"{path}: has {has}; this flipflow reads {FORMAT}: record the run again"
                )
            panels = {name: _panel(group) for name, group in file.items()}
            return File(speed_rad_per_s, str(file.attrs["turned_by"]), panels)
    except (OSError, KeyError, ValueError, AttributeError) as error:
        raise UnreadableRecording(f"{path}: is no recording ({error})") from None


def _panel(group: Any) -> RecordedShape:
    """Read the recording of one panel from its group in the file."""
    shape = {name: float(value) for name, value in group.attrs.items() if name.endswith(("_m", "_deg"))}
    grid = RecordedGrid(group["rows_m"][:], group["columns_m"][:])
    series = {name: np.asarray(group[name][:]) for name in SERIES}
    return RecordedShape(Recording(grid, int(group.attrs["cycles"]), **series), shape)


@dataclass(frozen=True)
class Turning:
    """The rotation of a machine.

    ``speed_rad_per_s`` is the speed after the run-up.  ``zero_s`` is a time at which the angle of the
    running machine is 0.  The machine starts at ``start_s`` and runs up for ``run_up_s``.  ``turned_by`` says
    what has this angle; angles of other things cannot be compared with it.
    """

    speed_rad_per_s: float
    zero_s: float
    start_s: float
    run_up_s: float
    turned_by: str


def turning(case: Case) -> Turning | None:
    """Return the rotation of a case's machine; None if the machine has no exciters and no drives."""
    exciters = [
        Turning(
            exciter.speed_rad_per_s,
            exciter.start_s + exciter.run_up_s / 2 - _angle_rad(exciter) / exciter.speed_rad_per_s,
            exciter.start_s,
            exciter.run_up_s,
            f"a shaft about {_text(exciter.axis)}",
        )
        for exciter in case.screen.exciters.values()
    ]
    drives = [
        Turning(
            drive.speed_rad_per_s,
            -drive.largest_phase_rad / drive.speed_rad_per_s,
            0.0,
            drive.run_up_s,
            f"a drive of frame {name} {drive.largest_component}",
        )
        for name, frame in case.screen.frames.items()
        if (drive := frame.drive) and drive.moves
    ]
    return min(exciters or drives, key=lambda machine: machine.speed_rad_per_s, default=None)


def _angle_rad(exciter: Exciter) -> float:
    """Return the angle of an exciter's force at t = 0, from z, or from x if the shaft is along z."""
    axis, start = _unit(exciter.axis), _unit(exciter.start)
    upward = np.array([0.0, 0.0, 1.0]) if abs(axis[2]) < 1 - ALIKE else np.array([1.0, 0.0, 0.0])
    zero = _unit(upward - (upward @ axis) * axis)
    return exciter.phase_rad + math.atan2(float(start @ np.cross(axis, zero)), float(start @ zero))


def _unit(direction: Vector | Array) -> Array:
    return np.asarray(np.asarray(direction) / np.linalg.norm(direction))


def _text(direction: Vector) -> str:
    """Return the direction as a unit vector to three decimals, without a minus at zeros."""
    return "(" + ", ".join(f"{value + 0.0:g}" for value in np.round(_unit(direction), 3)) + ")"


def playbacks(case: Case, folder: Path) -> dict[str, Playback]:
    """Return the playback of each panel, by name; nothing for panels that are not recorded.

    The motion grows during the run-up, or during one cycle if the run-up is shorter.
    Raises NoMatch and UnreadableRecording.
    """
    if not case.panel.adapter.plays_back:
        return {}
    machine = turning(case)
    if machine is None or case.panel.recording is None:
        raise NoMatch("a recording is played back to the speed of an exciter or drive, and named")
    file = read(folder / case.panel.recording)
    if machine.turned_by != file.turned_by:
        raise NoMatch(f"{file.turned_by} turned the recorded machine, and {machine.turned_by} turns this one")
    speed_rad_per_s = machine.speed_rad_per_s
    run_up_s = max(machine.run_up_s, 2 * math.pi / speed_rad_per_s)
    return {
        panel.name: Playback(
            _find_recording(panel, file.panels), speed_rad_per_s, machine.zero_s, machine.start_s, run_up_s
        )
        for panel in single_panels(case)
    }


def _find_recording(panel: SinglePanel, recorded: Mapping[str, RecordedShape]) -> Recording:
    """Return the recording with the panel's name, or else the only recording.  Raises NoMatch."""
    only = next(iter(recorded.values())) if len(recorded) == 1 else None
    shape = recorded.get(panel.name, only)
    if shape is None:
        raise NoMatch(f'panel "{panel.name}" is not recorded; recorded are {", ".join(recorded)}')
    for name, value in shape_of(panel).items():
        recorded_value = shape.shape.get(name, 0.0)
        if not np.isclose(recorded_value, value, rtol=ALIKE, atol=0):
            what = f'panel "{panel.name}" has {name} = {value:g}, the recorded one {recorded_value:g}'
            raise NoMatch(what)
    return shape.recording


def shape_of(panel: SinglePanel) -> dict[str, float]:
    """Return the lengths and the angle that a panel must share with its recording."""
    of_rectangle = {name: getattr(panel.rectangle, name) for name in RECTANGLE}
    sheet = {"thickness_m": panel.table.thickness_m, "moulded_sag_m": panel.table.moulded_sag_m}
    return of_rectangle | sheet
