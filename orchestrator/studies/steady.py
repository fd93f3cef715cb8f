"""The steady motion of a machine's frames, from the folder of a run."""

from __future__ import annotations

import json
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path

import h5py
import numpy as np

from orchestrator.case.deck.panels import axes
from orchestrator.output.results.sampling import rows_too_seldom
from orchestrator.ports import Array
from orchestrator.preflight.levels import load

CYCLES = 10


class NotSteady(Exception):
    """A run without frames, too short to have two whole cycles in its second half, or written too
    seldom to tell what happens in a cycle."""


@dataclass(frozen=True)
class Steady:
    """First harmonics in deck axes: x(t) = Re(amplitude * exp(i speed t)), (3,) complex.

    ``points``: every frame's centre of mass and every probe on a frame, by name; ``relative``: the
    second frame's centre against the first's, by "second-first".  ``drift``: how much the largest
    of these changed from the window before to the last one, relative to itself.
    """

    speed_rad_per_s: float
    points: dict[str, Array]
    relative: dict[str, Array]
    drift: float


def steady(folder: Path) -> Steady:
    """Over the last ten cycles, or as many as the run's second half has.  Raises NotSteady."""
    cycle_s = json.loads((folder / "summary.json").read_text())["cycle_s"]
    case = load(folder).case
    turn, speed = axes(case), 2 * np.pi / cycle_s
    with h5py.File(folder / "history.h5") as history:
        if "frames" not in history:
            raise NotSteady("the case has no frames")
        frames = {name: group["displacement_m"][:] @ turn for name, group in history["frames"].items()}
        time_s = next(iter(history["frames"].values()))["time_s"][:]
        for name, probe in case.probes.items():
            if probe.frame is not None:
                frames[name] = history[f"probes/{name}/position_m"][:] @ turn
    cycles = min(CYCLES, int(time_s[-1] / 2 / cycle_s + 1e-9))
    if cycles < 2:
        raise NotSteady(f"{folder}: {time_s[-1]:g} s are too short for cycles of {cycle_s:.3g} s")
    if why := rows_too_seldom(time_s, cycle_s, case.coupling.sync_interval_s):
        raise NotSteady(f"{folder}: {why}")
    last = time_s >= time_s[-1] - cycles * cycle_s * (1 + 1e-9)
    before = np.roll(last, -int(last.sum()) // 2)
    points = {name: harmonic(time_s[last], x[last], speed) for name, x in frames.items()}
    earlier = {name: harmonic(time_s[before], x[before], speed) for name, x in frames.items()}
    drifts = [np.abs(points[name] - earlier[name]).max() for name in points]
    return Steady(
        speed,
        points,
        {f"{b}-{a}": points[b] - points[a] for a, b in combinations(case.screen.frames, 2)},
        float(max(drifts) / max(np.abs(x).max() for x in points.values())),
    )


def harmonic(time_s: Array, place_m: Array, speed_rad_per_s: float) -> Array:
    """Complex amplitude (columns,) of (n,) equidistant times and (n, columns) places.

    Hann's window keeps out what else rings: a machine on soft springs swings for seconds at a
    frequency of its own (Harris, Proc. IEEE 66, 1978, 51-83, doi 10.1109/PROC.1978.10837).
    Constant and both quadratures are fitted together, so that they do not leak into each other.
    """
    weight = np.sqrt(np.hanning(len(time_s)))[:, None]
    phase = speed_rad_per_s * time_s
    terms = np.column_stack([np.ones_like(phase), np.cos(phase), -np.sin(phase)])
    _, real, imaginary = np.linalg.lstsq(weight * terms, weight * place_m, rcond=None)[0]
    return np.asarray(real + 1j * imaginary)
