"""Recorded panels: a file that can be read, of panels like the case's."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from orchestrator.case import recording_file
from orchestrator.case.file.errors import CaseProblem
from orchestrator.case.file.layers import is_outside
from orchestrator.case.playback import NoMatch, playbacks, turning
from orchestrator.case.tables.case import Case

KEY = ("panel", "recording")
OTHER_SPEED = 0.01


def named_recording(case: Case) -> Iterator[CaseProblem]:
    """A solver that plays back needs a file, and a machine whose angle it can follow."""
    if not case.panel.adapter.plays_back:
        return
    if case.panel.recording is None:
        yield CaseProblem(KEY, "missing: what is to be played back?", "flipflow record makes a file")
    if turning(case) is None:
        yield CaseProblem(("panel", "solver"), f"{case.panel.solver} needs an exciter or a drive to follow")


def own_recording(case: Case, folder: Path, source: str) -> Iterator[CaseProblem]:
    """A file of somebody else, named by a file of the case and not by the user: ``source``."""
    if not case.panel.adapter.plays_back or case.panel.recording is None or source == "--set":
        return
    file = folder / case.panel.recording
    if file.is_file() and is_outside(file, folder):
        yield CaseProblem(KEY, "is outside of the case's folder", "copy it there, or name it by --set")


def fitting_recording(case: Case, folder: Path) -> Iterator[CaseProblem]:
    """A file that is none, or of other panels."""
    try:
        playbacks(case, folder)
    except (NoMatch, recording_file.UnreadableRecording) as error:
        yield CaseProblem(KEY, str(error))


def other_speed(case: Case, folder: Path) -> Iterator[str]:
    """A recording made at another speed than it is played back at."""
    machine = turning(case)
    if not case.panel.adapter.plays_back or case.panel.recording is None or machine is None:
        return
    recorded = recording_file.read(folder / case.panel.recording).speed_rad_per_s
    if abs(machine.speed_rad_per_s / recorded - 1) > OTHER_SPEED:
        yield (
            f"panel.recording was made at {recorded:.4g} rad/s and is played back at "
            f"{machine.speed_rad_per_s:.4g} rad/s: panels would move otherwise there"
        )
