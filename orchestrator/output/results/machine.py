"""The machine's motion: orbits of frames, accelerations and pull of panels, ranges of probes."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from orchestrator.case.deck.panels import SinglePanel, single_panels
from orchestrator.case.tables.case import Case
from orchestrator.output.records.summary import counted_cycle_s, cycle_s, is_driven
from orchestrator.output.results.estimate import Estimate, mean
from orchestrator.output.results.run_reader import RunData
from orchestrator.output.results.sampling import rows_too_seldom
from orchestrator.output.results.vibration import (
    BAND_HZ,
    LARGEST_BAND,
    STANDARD_GRAVITY_M_PER_S2,
    Orbit,
    acceleration_m_per_s2,
    band_hz,
    orbit,
    shaking,
)
from orchestrator.ports import Array, Indices

LARGEST_DRIFT = 0.05  # of an amplitude, from the first half of the window to the second
FEWEST_CYCLES = 4  # of a window whose halves are compared


def not_settled(data: RunData, start_s: float, end_s: float) -> str:
    """Why the frames' motion from ``start_s`` to ``end_s`` is no steady one; empty if it is."""
    if not data.is_driven:
        return "nothing drives the machine: it has no steady motion"
    for name in data.names("frames"):
        rows = data.cycles(f"point_cycles/{name}", start_s, end_s)
        each_m = np.linalg.norm(rows["most_m"] - rows["least_m"], axis=1) / 2
        count = len(each_m)
        if count < FEWEST_CYCLES:
            cycles = f"{count} cycle{'' if count == 1 else 's'}"
            return f"averaged over {cycles}; {FEWEST_CYCLES} are needed to see it settle"
        early_m, late_m = each_m[: count // 2].mean(), each_m[-(count // 2) :].mean()
        drift = float(abs(late_m - early_m) / early_m) if early_m > 0 else 0.0
        if drift > LARGEST_DRIFT:
            return (
                f"the amplitude of {name} still changes: by {100 * drift:.2g} % from the first "
                f"half of the {count} cycles to the second; up to {100 * LARGEST_DRIFT:g} % "
                "counts as settled"
            )
    return ""


def band_missed(data: RunData) -> str:
    """Why the series tell no acceleration up to BAND_HZ, although sync points would; empty where
    they do, or where sync points are no nearer to each other."""
    time_s = data.series_s()
    if len(time_s) < 2:
        return "the series have one row only (output.series_s)"
    step_s = float(time_s[1] - time_s[0])
    if band_hz(step_s) == BAND_HZ or step_s < 1.5 * data.case.coupling.sync_interval_s:
        return ""
    return (
        f"the series have a row every {step_s:.2g} s: too seldom for accelerations up to "
        f"{BAND_HZ:g} Hz (output.series_s of at most {LARGEST_BAND / (2 * BAND_HZ):.2g} s)"
    )


def frame_points(data: RunData, start_s: float, end_s: float) -> dict[str, Any]:
    """Orbits, in deck axes, of every frame's centre of mass and of the probes on frames."""
    found = {}
    for name, path in _on_frames(data):
        time, place = _within(data, path, start_s, end_s)
        found[name] = _orbit_table(orbit(time, place, 2 * np.pi / data.cycle_s))
    return found


def relative_motion(data: RunData, start_s: float, end_s: float) -> dict[str, Any]:
    """Of every two frames' centres of mass: the orbit of the second seen from the first, and
    ``along_m``, the amplitude along the deck cycle by cycle, with its interval."""
    found = {}
    for one, two in combinations(data.names("frames"), 2):
        time, first = _within(data, f"frames/{one}/displacement_m", start_s, end_s)
        second = _within(data, f"frames/{two}/displacement_m", start_s, end_s)[1]
        speed = 2 * np.pi / data.cycle_s
        table = _orbit_table(orbit(time, second - first, speed))
        each = [
            orbit(time[part], (second - first)[part], speed).amplitude_m[0]
            for part in _cycles(time, data.cycle_s)
        ]
        found[f"{one}-{two}"] = table | {"along_m": mean(np.array(each))}
    return found


def panel_points(data: RunData, start_s: float, end_s: float) -> dict[str, Any]:
    """Accelerations, in g, of the probes on panels; ``band_Hz`` is how far they reach."""
    normals = {panel.name: _normal(panel) for panel in single_panels(data.case)}
    found = {}
    for name, probe in data.case.probes.items():
        if probe.panel is None or name not in data.names("probes"):
            continue
        time = data.read(f"probes/{name}/time_s")
        step_s = float(time[1] - time[0])
        acceleration = acceleration_m_per_s2(data.read(f"probes/{name}/velocity_m_per_s"), step_s)
        window = (time >= start_s) & (time <= end_s)
        time, acceleration = time[window], acceleration[window]
        shaken = shaking(acceleration, normals[probe.panel])
        parts = _cycles(time, data.cycle_s)
        size = np.linalg.norm(acceleration, axis=1) / STANDARD_GRAVITY_M_PER_S2
        square = mean(np.array([float(np.mean(size[part] ** 2)) for part in parts]))
        found[name] = {
            "panel": probe.panel,
            "at": list(probe.at or ()),
            "band_Hz": band_hz(step_s),
            "peak_g": shaken.peak,
            "rms_g": _root(square, shaken.rms),
            "peak_normal_g": shaken.peak_normal,
            "rms_normal_g": shaken.rms_normal,
            "cycle_peak_g": mean(np.array([float(size[part].max()) for part in parts])),
        }
    return found


def panel_loads(data: RunData, start_s: float, end_s: float) -> dict[str, Any]:
    """Pull on the clamps, load of the bed and stretch along the middle line, of every panel: from
    every sync point of the cycles averaged over."""
    found = {}
    for name in data.names("panel_cycles"):
        rows = data.cycles(f"panel_cycles/{name}", start_s, end_s)
        weight = rows["sync_points"] / rows["sync_points"].sum()
        found[name] = {
            "tension_mean_N": float(weight @ rows["pull_mean_N"]),
            "tension_largest_N": float(rows["pull_most_N"].max()),
            "tension_smallest_N": float(rows["pull_least_N"].min()),
            "largest_clamp_force_N": float(rows["clamp_most_N"].max()),
            "stretch_largest_percent": 100 * float(rows["stretch_most"].max()),
            "stretch_smallest_percent": 100 * float(rows["stretch_least"].min()),
            "load_N": (weight @ rows["load_mean_N"] @ data.deck_axes).tolist(),
        }
    return found


def _normal(panel: SinglePanel) -> Array:
    return np.cross(panel.rectangle.along, panel.rectangle.across)


def _on_frames(data: RunData) -> Iterator[tuple[str, str]]:
    for name in data.names("frames"):
        yield name, f"frames/{name}/displacement_m"
    for name, probe in data.case.probes.items():
        if probe.frame is not None and name in data.names("probes"):
            yield name, f"probes/{name}/position_m"


def _within(data: RunData, path: str, start_s: float, end_s: float) -> tuple[Array, Array]:
    """Times and places from start to end, in deck axes."""
    time = data.read(path.rsplit("/", 1)[0] + "/time_s")
    window = (time >= start_s) & (time <= end_s)
    return time[window], data.read(path)[window] @ data.deck_axes


def _cycles(time_s: Array, cycle_s: float) -> list[Indices]:
    """Rows of each whole cycle that has some; the times span whole ones, up to a sync interval at
    the ends."""
    number = np.floor((time_s - time_s[0]) / cycle_s + 1e-6).astype(int)
    whole = round((time_s[-1] - time_s[0]) / cycle_s)
    return [np.flatnonzero(number == cycle) for cycle in range(whole) if (number == cycle).any()]


def _root(square: Estimate, value: float) -> Estimate:
    """Of a mean square."""
    width = square.half_width
    return Estimate(value, width / (2 * value) if width is not None and value else None)


def _orbit_table(found: Orbit) -> dict[str, Any]:
    return {
        "amplitude_m": found.amplitude_m.tolist(),
        "phase_rad": found.phase_rad.tolist(),
        "major_m": found.major_m,
        "minor_m": found.minor_m,
        "tilt_deg": float(np.degrees(found.tilt_rad)),
        "other_m": found.other_m.tolist(),
    }


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
