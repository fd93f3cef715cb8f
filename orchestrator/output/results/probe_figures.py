"""How frames' centres of mass and probes moved: amplitude, mean and peaks, for ``summary.json``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import h5py
import numpy as np

from orchestrator.case.tables.case import Case
from orchestrator.output.records.summary import counted_cycle_s, cycle_s, is_driven
from orchestrator.output.results.sampling import rows_too_seldom
from orchestrator.ports import Array

FIGURES = ("amplitude_m", "mean_m", "peak_m", "peak_speed_m_per_s")
AVERAGED = 2  # cycles


def probe_figures(history_file: Path, case: Case) -> dict[str, dict[str, Any]]:
    """Of every frame's centre of mass and every probe.

    ``amplitude_m`` (3,): half the range over the last two whole cycles of the machine, or over all
    of a run that is shorter or has no cycle; ``mean_m`` (3,): mean displacement over them;
    ``peak_m``: largest size of the displacement from the place at t = 0 over the whole run;
    ``peak_speed_m_per_s`` likewise.  Of points on frames and panels these are taken at sync points,
    however seldom rows are written.  Of a particle the rows of the series are all there is, and the
    time in which it is present is taken for the run.  Where nothing can be said all four are None,
    and ``reason`` says why.
    """
    with h5py.File(history_file) as history:
        points = history.get("point_cycles", {})
        found = {name: _of_cycles(one, case) for name, one in points.items()}
        for name, series in history.get("probes", {}).items():
            if name not in found:
                found[name] = _of_a_particle(series, case)
        return found


def _of_cycles(rows: Any, case: Case) -> dict[str, Any]:
    last = averaged_rows(rows["time_s"][:], cycle_s(case))
    count = rows["sync_points"][:][last]
    return {
        "amplitude_m": (rows["most_m"][:][last].max(axis=0) - rows["least_m"][:][last].min(axis=0)) / 2,
        "mean_m": count @ rows["mean_m"][:][last] / count.sum(),
        "peak_m": rows["farthest_m"][:].max(),
        "peak_speed_m_per_s": rows["fastest_m_per_s"][:].max(),
        "reason": "",
    }


def averaged_rows(end_s: Array, cycle_s: float) -> slice:
    """Which of the rows of cycles that end at ``end_s`` are of the last whole ones; all where
    there are not so many."""
    numbers = np.ceil(end_s / cycle_s - 1e-9)
    begun = int(numbers[-1])
    whole = begun if end_s[-1] > (begun - 1e-6) * cycle_s else begun - 1
    if whole < AVERAGED:
        return slice(None)
    first, last = np.searchsorted(numbers, [whole - AVERAGED + 0.5, whole + 0.5])
    return slice(int(first), int(last))


def _of_a_particle(series: Any, case: Case) -> dict[str, Any]:
    time_s, place_m = series["time_s"][:], series["position_m"][:]
    there = np.isfinite(place_m).all(axis=1)
    if not there.any():
        return _unknown("it never was there")
    span = "a cycle" if is_driven(case) else "a fiftieth of the run,"
    interval_s = case.coupling.sync_interval_s
    if why := rows_too_seldom(time_s, counted_cycle_s(case), interval_s, span, 0):
        return _unknown(why)
    moved_m, time_s = place_m[there] - place_m[there][0], time_s[there]
    last = moved_m[time_s >= time_s[-1] - AVERAGED * cycle_s(case)]
    return {
        "amplitude_m": np.ptp(last, axis=0) / 2,
        "mean_m": last.mean(axis=0),
        "peak_m": np.linalg.norm(moved_m, axis=1).max(),
        "peak_speed_m_per_s": np.linalg.norm(series["velocity_m_per_s"][:][there], axis=1).max(),
        "reason": "",
    }


def _unknown(why: str) -> dict[str, Any]:
    return dict.fromkeys(FIGURES) | {"reason": why}
