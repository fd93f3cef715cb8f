"""A recording of a run's panels, and drives of its frames, which play the run's motion back.

A recording has the last whole cycles of a run, made periodic.  The shapes of the panels (``shapes`` in
history.h5) are taken relative to their clamps.  At the end of the window they fade, over a quarter of a
cycle, into the shapes one window earlier, so that shape and velocity are continuous from cycle to cycle.
They are sampled at equal angles of the machine.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from orchestrator.case import recordings
from orchestrator.case.deck.panels import SinglePanel, axes, single_panels
from orchestrator.case.file.errors import CaseError, CaseProblem
from orchestrator.case.file.folder import admit
from orchestrator.case.recordings import Turning, shape_of, turning
from orchestrator.case.tables.case import Case
from orchestrator.output.results.harmonics import first_harmonic
from orchestrator.output.results.run_reader import RunReader
from orchestrator.ports import Array
from orchestrator.ports.recording import RecordedGrid, Recording
from orchestrator.preflight.judge import load_judged
from orchestrator.preflight.judgement.catalogue import has_effect

FADE = 0.25  # length of the fading, in cycles
MOST_CYCLES = 8  # the largest number of cycles after which a panel may repeat itself
ALIKE = 0.01  # the difference, relative to the motion, up to which a panel repeats itself


class TooShort(Exception):
    """An error of a run that is too short for the requested number of cycles."""


@dataclass(frozen=True)
class Window:
    """The window of a recording: the last whole cycles of a run.

    It is ``length_s`` long and sampled at the times ``sampled_s``, which belong to equal angles from 0.  The
    motion at ``earlier_s``, one window before, is faded in with a ``share`` (samples,), which changes at the
    rate ``rate_per_s``.
    """

    sampled_s: Array
    length_s: float
    share: Array
    rate_per_s: Array

    @property
    def earlier_s(self) -> Array:
        """The times one window earlier."""
        return self.sampled_s - self.length_s


@dataclass(frozen=True)
class Recorded:
    """A recording of all panels in a ``file``, over a number of ``cycles``.

    ``change`` has, by panel, the change of the shape from window to window (rms) where the windows are
    faded, relative to the panel's motion.
    """

    cycles: int
    file: recordings.File
    change: dict[str, float]


def record(run: Path, cycles: int | None) -> Recorded:
    """Return a recording of all panels over a number of cycles.

    Without ``cycles``, it has the number of cycles after which the panels repeat themselves, or come nearest
    to that.  Raises CaseError for a run without the necessary data.
    """
    case = load_judged(admit(run)).case
    machine = turning(case)
    if machine is None:
        raise _refusal(run, "nothing turns this machine: it has no cycle")
    if has_effect(case, "motor-slip"):
        raise _refusal(run, "a motor turns the shaft, which lags: record a run without the motor")
    if not single_panels(case):
        raise _refusal(run, "the case has no panels")
    best = None
    for count in range(1, MOST_CYCLES + 1) if cycles is None else (cycles,):
        panels, change = {}, {}
        try:
            with RunReader(run) as reader:
                for panel in single_panels(case):
                    if f"shapes/{panel.name}" not in reader.history:
                        raise _refusal(run, "no shapes were recorded; run it with --set output.shapes_s=")
                    recording, change[panel.name] = _panel(case, reader.history, panel, machine, count)
                    panels[panel.name] = recordings.RecordedShape(recording, shape_of(panel))
        except (OSError, KeyError, RuntimeError) as error:  # HDF5 raises them for a damaged file
            raise _refusal(run, f"history.h5 cannot be read: {error}") from None
        except TooShort as short:
            if best is None:
                raise _refusal(run, str(short)) from None
            return best
        if best is None or max(change.values()) < max(best.change.values()):
            file = recordings.File(machine.speed_rad_per_s, machine.turned_by, panels)
            best = Recorded(count, file, change)
        if max(best.change.values()) < ALIKE:
            break
    assert best is not None
    return best


def _panel(
    case: Case, history: Any, panel: SinglePanel, machine: Turning, cycles: int
) -> tuple[Recording, float]:
    shapes = {name: values[:] for name, values in history[f"shapes/{panel.name}"].items()}
    time_s = shapes["time_s"]
    window = _window(time_s, machine, cycles)
    grid, at = RecordedGrid.of(panel.rectangle, case.panel.surface_cells), panel.rectangle
    carried, turn = grid.carried(at), np.stack([at.along, at.across, at.normal], axis=1)
    corners = [int(number) for number in carried.argmax(axis=0)]
    # a solid's surface lies above its middle: the clamps' corners stand for the middle
    above_m = shapes["position_m"][0, corners] - at.mounted(grid.corners_m(at))
    clamps_m = shapes["position_m"][:, corners] - above_m
    shape_m = (shapes["position_m"] - carried @ clamps_m) @ turn
    rate_m_per_s = (shapes["velocity_m_per_s"] - carried @ shapes["velocity_m_per_s"][:, corners]) @ turn
    middle_s, pull_N, rest_pull_N = _pull(history, case, panel, shapes, grid)
    sampled_m, sampled_m_per_s, change = _close(window, CubicHermiteSpline(time_s, shape_m, rate_m_per_s))
    share = window.share[:, None]
    now_N, earlier_N = (_interpolate(at_s, middle_s, pull_N) for at_s in (window.sampled_s, window.earlier_s))
    recording = Recording(
        grid,
        cycles,
        sampled_m,
        sampled_m_per_s / machine.speed_rad_per_s,
        shape_m[0],
        (1 - share) * now_N + share * earlier_N,
        rest_pull_N,
    )
    return recording, change


def _interpolate(at_s: Array, time_s: Array, values: Array) -> Array:
    return np.column_stack([np.interp(at_s, time_s, column) for column in values.T])


def _window(time_s: Array, machine: Turning, cycles: int) -> Window:
    cycle_s, end_s = 2 * math.pi / machine.speed_rad_per_s, float(time_s.max(initial=0.0))
    length_s, fade_s = cycles * cycle_s, FADE * cycle_s
    start_s = end_s - length_s
    if start_s - fade_s < machine.start_s + machine.run_up_s:
        raise TooShort(
            f"{cycles} cycles of {cycle_s:.4g} s and a quarter do not fit between the run-up and "
            f"the end at {end_s:g} s"
        )
    samples = math.ceil(length_s / float(np.diff(time_s).min()))
    angle_s = length_s * np.arange(samples) / samples
    sampled_s = start_s + (angle_s - (start_s - machine.zero_s)) % length_s
    turn = np.pi * np.clip(1 - (end_s - sampled_s) / fade_s, 0.0, 1.0)
    return Window(sampled_s, length_s, (1 - np.cos(turn)) / 2, np.pi / (2 * fade_s) * np.sin(turn))


def _close(window: Window, spline: CubicHermiteSpline) -> tuple[Array, Array, float]:
    """Return shape in m and velocity in m/s (samples, points, 3), and the relative size of the difference."""
    velocity, before_s = spline.derivative(), np.maximum(window.earlier_s, spline.x[0])
    share, rate_per_s = window.share[:, None, None], window.rate_per_s[:, None, None]
    now_m = spline(window.sampled_s)
    away_m = spline(before_s) - now_m
    rate_m_per_s = (1 - share) * velocity(window.sampled_s) + share * velocity(before_s)
    moving_m = float(np.std(now_m, axis=0).max())
    changed_m = float(np.sqrt(np.mean(away_m[window.share > 0] ** 2, axis=0).max()))
    change = changed_m / moving_m if moving_m else 0.0
    return now_m + share * away_m, rate_m_per_s + rate_per_s * away_m, change


def _pull(
    history: Any, case: Case, panel: SinglePanel, shapes: dict[str, Array], grid: RecordedGrid
) -> tuple[Array, Array, Array]:
    """Return times (n,) in s, the pull (n, 3) in N in the panel's axes, and the pull at rest (3,).

    The pull is half the difference of the clamps' forces, less the contributions of weight and inertia by the
    lever rule.
    """
    at, time_s = panel.rectangle, shapes["time_s"]
    share = panel.apertures.material_share(at) if panel.apertures else 1.0
    per_area = case.materials[panel.table.material].density_kg_per_m3 * panel.table.thickness_m
    mass_kg = grid.mass_kg(at, per_area, share)[:, None]
    acceleration_m_per_s2 = np.diff(shapes["velocity_m_per_s"], axis=0) / np.diff(time_s)[:, None, None]
    forces = history[f"forces/{panel.name}"]
    difference_N = forces["first_clamp_N"][:] - forces["second_clamp_N"][:]
    impulse_N_s = np.cumsum(np.diff(forces["time_s"][:])[:, None] * difference_N[1:], axis=0)
    impulse_N_s = np.vstack([np.zeros(3), impulse_N_s])
    at_rows_N_s = _interpolate(time_s, forces["time_s"][:], impulse_N_s)
    mean_N = np.diff(at_rows_N_s, axis=0) / np.diff(time_s)[:, None]
    weight_N = mass_kg * np.array(case.gravity_m_per_s2)
    ends = at.end(grid.corners_m(at))
    lever = grid.carried(at) @ (1.0 - 2.0 * ends)  # 1 at the first clamp, -1 at the second
    turn = np.stack([at.along, at.across, at.normal], axis=1)
    inertial_N = np.einsum("p,npi->ni", lever, weight_N - mass_kg * acceleration_m_per_s2)
    pull_N = (mean_N - inertial_N) / 2 @ turn
    rest_N = (difference_N[0] - lever @ weight_N) / 2 @ turn
    return (time_s[1:] + time_s[:-1]) / 2, pull_N, rest_N


def _refusal(run: Path, why: str) -> CaseError:
    return CaseError([CaseProblem((), why, file=str(run))])


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
                "speed_rad_per_s": repr(speed_rad_per_s),
                "center_m": _list(np.array(frame.recorded_point_m)),
                "amplitude_m": _list(np.abs(moved)),
                # drives have the phases of sines, first_harmonic those of cosines
                "phase_rad": _list(np.angle(moved) + np.pi / 2),
                "rotation_rad": _list(np.abs(turned)),
                "rotation_phase_rad": _list(np.angle(turned) + np.pi / 2),
                "run_up_s": repr(max(machine.run_up_s, cycle_s)),
            }
            table = ", ".join(f"{key} = {value}" for key, value in values.items())
            overlays.append(f"screen.frames.{name}.drive={{{table}}}")
    return overlays


def _list(values: Array) -> str:
    return str([float(value) for value in values])
