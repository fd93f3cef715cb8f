"""Drives of a machine's frames that move them as a run did, by the first harmonics of their motion."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from orchestrator.case.deck.panels import axes
from orchestrator.case.file.errors import CaseError, CaseProblem
from orchestrator.case.turning import turning
from orchestrator.output.results.harmonics import first_harmonic
from orchestrator.output.results.run_reader import RunReader
from orchestrator.ports import Array


def drives(folder: Path) -> list[str]:
    """Return the ``--set`` overlays of drives, one for each frame, that move the frames as a run did.

    The drives are the first harmonics of the frames' motion in deck axes.  Raises CaseError for a machine
    that does not turn and for a run that is too short.
    """
    overlays = []
    with RunReader(folder) as run:
        case, (start_s, end_s) = run.case, run.second_half_s
        machine = turning(case)
        if machine is None:
            raise _refusal(folder, "nothing turns this machine")
        cycle_s = run.turn_s(start_s, end_s)
        speed_rad_per_s = machine.speed_rad_per_s * run.cycle_s / cycle_s
        if end_s - start_s < 1.5 * cycle_s:
            raise _refusal(folder, "too short to find the frames' steady motion in its second half")
        for name, frame in case.screen.frames.items():
            time_s = run.read(f"frames/{name}/time_s")
            moved, turned = (
                first_harmonic(
                    time_s, run.read(f"frames/{name}/{what}") @ axes(case), cycle_s, start_s, end_s
                ).phasor
                for what in ("displacement_m", "rotation_rad")
            )
            values = {
                "speed_rad_per_s": repr(float(speed_rad_per_s)),
                "center_m": _list(np.array(frame.recorded_point_m)),
                "amplitude_m": _list(np.abs(moved)),
                # drives have the phases of sines, first_harmonic those of cosines
                "phase_rad": _list(np.angle(moved) + np.pi / 2),
                "rotation_rad": _list(np.abs(turned)),
                "rotation_phase_rad": _list(np.angle(turned) + np.pi / 2),
                "run_up_s": repr(float(max(machine.run_up_s, cycle_s))),
            }
            table = ", ".join(f"{key} = {value}" for key, value in values.items())
            overlays.append(f"screen.frames.{name}.drive={{{table}}}")
    return overlays


def _list(values: Array) -> str:
    return str([float(value) for value in values])


def _refusal(run: Path, why: str) -> CaseError:
    return CaseError([CaseProblem((), why, file=str(run))])
