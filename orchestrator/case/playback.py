"""From a case to what its recorded panels play back: which recording, and when.

The machine's angle is that of its slowest exciter once it has run up, or, in a machine without,
the slowest drive's speed times time.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from orchestrator.case import recording_file
from orchestrator.case.deck.panels import SinglePanel, single_panels
from orchestrator.case.tables.case import Case
from orchestrator.ports.recording import Playback

ALIKE = 1e-6  # relative difference of lengths that counts as none


class NoMatch(Exception):
    """A recording does not fit; the message says which panel, and why."""


@dataclass(frozen=True)
class Turning:
    """``speed_rad_per_s``, when the angle of the running machine passes 0, when it starts, and how
    long it runs up."""

    speed_rad_per_s: float
    zero_s: float
    start_s: float
    run_up_s: float


def turning(case: Case) -> Turning | None:
    """None for a machine that nothing turns."""
    exciters = [
        Turning(
            one.speed_rad_per_s,
            one.start_s + one.run_up_s / 2 - one.phase_rad / one.speed_rad_per_s,
            one.start_s,
            one.run_up_s,
        )
        for one in case.screen.exciters.values()
    ]
    drives = [
        Turning(frame.drive.speed_rad_per_s, 0.0, 0.0, frame.drive.run_up_s)
        for frame in case.screen.frames.values()
        if frame.drive
    ]
    return min(exciters or drives, key=lambda one: one.speed_rad_per_s, default=None)


def playbacks(case: Case, folder: Path) -> dict[str, Playback]:
    """By the panels' names; empty unless the panels are recorded ones.  The motion grows within
    the run-up, but not faster than in a cycle.

    Raises NoMatch, and recording_file.UnreadableRecording.
    """
    if not case.panel.adapter.plays_back:
        return {}
    machine = turning(case)
    if machine is None or case.panel.recording is None:
        raise NoMatch("a recording is played back to the speed of an exciter or drive, and named")
    recorded = recording_file.read(folder / case.panel.recording)
    run_up_s = max(machine.run_up_s, 2 * math.pi / machine.speed_rad_per_s)
    return {
        panel.name: Playback(
            _fitting(panel, recorded).recording,
            machine.speed_rad_per_s,
            machine.zero_s,
            machine.start_s,
            run_up_s,
        )
        for panel in single_panels(case)
    }


def _fitting(panel: SinglePanel, recorded: recording_file.File) -> recording_file.RecordedShape:
    """The recording of the same name, or the only one there is."""
    known = recorded.panels
    found = known.get(panel.name) or (next(iter(known.values())) if len(known) == 1 else None)
    if found is None:
        raise NoMatch(f'panel "{panel.name}" is not recorded; recorded are {", ".join(known)}')
    here = shape_of(panel)
    for name, value in here.items():
        if not np.isclose(found.shape[name], value, rtol=ALIKE, atol=0):
            raise NoMatch(
                f'panel "{panel.name}" has {name} = {value:g}, the recorded one {found.shape[name]:g}'
            )
    return found


def shape_of(panel: SinglePanel) -> dict[str, float]:
    """The lengths that a panel must share with its recording."""
    at = panel.rectangle
    return {
        "length_m": at.length_m,
        "span_m": at.span_m,
        "width_m": at.width_m,
        "clamp_m": at.clamp_m,
        "thickness_m": panel.table.thickness_m,
    }
