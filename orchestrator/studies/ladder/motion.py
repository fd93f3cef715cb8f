"""From the run of free frames to drives that move them alike: first harmonics in deck axes."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from orchestrator.case.deck.panels import axes
from orchestrator.case.file.errors import CaseError, CaseProblem
from orchestrator.case.playback import turning
from orchestrator.output.results.harmonics import first_harmonic
from orchestrator.output.results.run_reader import RunReader
from orchestrator.ports import Array


def drives(folder: Path) -> Iterator[str]:
    """``--set`` overlays, one for each frame.  Raises CaseError for a run too short."""
    with RunReader(folder) as run:
        yield from _drives(run)


def _drives(run: RunReader) -> Iterator[str]:
    case = run.case
    machine = turning(case)
    if machine is None:
        raise CaseError([CaseProblem((), "nothing turns this machine", file=str(run.folder))])
    speed, turn = machine.speed_rad_per_s, axes(case)
    cycle_s = 2 * math.pi / speed
    start_s, end_s = run.second_half_s
    if end_s - start_s < 1.5 * cycle_s:
        what = "too short to find the frames' steady motion in its second half"
        raise CaseError([CaseProblem((), what, file=str(run.folder))])
    for name, frame in case.screen.frames.items():
        time_s = run.read(f"frames/{name}/time_s")
        moved, turned = (
            first_harmonic(time_s, run.read(f"frames/{name}/{what}") @ turn, cycle_s, start_s, end_s).phasor
            for what in ("displacement_m", "rotation_rad")
        )
        values = {
            "speed_rad_per_s": repr(speed),
            "center_m": _list(np.array(frame.center_of_mass_m)),
            "amplitude_m": _list(np.abs(moved)),
            "phase_rad": _list(_sine(moved)),
            "rotation_rad": _list(np.abs(turned)),
            "rotation_phase_rad": _list(_sine(turned)),
            "run_up_s": repr(max(machine.run_up_s, 2 * math.pi / speed)),
        }
        table = ", ".join(f"{key} = {value}" for key, value in values.items())
        yield f"screen.frames.{name}.drive={{{table}}}"


def _sine(phasor: Array) -> Array:
    """Phases of sines; ``first_harmonic``'s are those of cosines."""
    return np.asarray(np.angle(phasor) + np.pi / 2)


def _list(values: Array) -> str:
    return str([float(value) for value in values])
