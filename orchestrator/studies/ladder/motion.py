"""From the run of free frames to drives that move them alike: first harmonics in deck axes."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import h5py
import numpy as np

from orchestrator.case.deck.panels import axes
from orchestrator.case.file.errors import CaseError, CaseProblem
from orchestrator.case.playback import turning
from orchestrator.ports import Array
from orchestrator.preflight.levels import load
from orchestrator.studies.steady import CYCLES, harmonic


def drives(folder: Path) -> Iterator[str]:
    """``--set`` overlays, one for each frame.  Raises CaseError for a run too short."""
    case = load(folder).case
    machine = turning(case)
    if machine is None:
        raise CaseError([CaseProblem((), "nothing turns this machine", file=str(folder))])
    speed, turn = machine.speed_rad_per_s, axes(case)
    with h5py.File(folder / "history.h5") as history:
        for name, frame in case.screen.frames.items():
            group = history[f"frames/{name}"]
            time_s = group["time_s"][:]
            cycles = min(CYCLES, int(time_s[-1] / 2 / (2 * math.pi / speed) + 1e-9))
            if cycles < 2:
                what = "too short to find the frames' steady motion in its second half"
                raise CaseError([CaseProblem((), what, file=str(folder))])
            last = time_s >= time_s[-1] - cycles * 2 * math.pi / speed * (1 + 1e-9)
            moved = harmonic(time_s[last], group["displacement_m"][last] @ turn, speed)
            turned = harmonic(time_s[last], group["rotation_rad"][last] @ turn, speed)
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
    """Phases of sines; ``harmonic``'s are those of cosines."""
    return np.asarray(np.angle(phasor) + np.pi / 2)


def _list(values: Array) -> str:
    return str([float(value) for value in values])
