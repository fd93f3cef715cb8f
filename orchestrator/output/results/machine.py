"""The machine's motion: orbits of frames, accelerations and pull of panels, ranges of points."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import numpy as np
from scipy.signal import butter, sosfiltfilt

from orchestrator.case.deck.panels import single_panels
from orchestrator.output.cycles import cycle_numbers, within
from orchestrator.output.results.estimate import Estimate, mean
from orchestrator.output.results.harmonics import Harmonic, drift, first_harmonic
from orchestrator.output.results.run_reader import RunReader
from orchestrator.output.results.sampling import rows_too_seldom
from orchestrator.ports import Array
from orchestrator.ports.physics import STANDARD_GRAVITY_M_PER_S2

BAND_HZ = 500.0
LARGEST_BAND = 0.9  # of half the rows' rate: up to there a filter can be made
LARGEST_DRIFT = 0.05  # of an amplitude or a range, from the first half of the window to the second
FEWEST_CYCLES = 4  # of a window whose halves are compared
RANGE_CYCLES = 2  # the last whole ones, of which the ranges of points are taken
UNKNOWN = dict.fromkeys(("half_range_m", "mean_m", "peak_m", "peak_speed_m_per_s"))


def orbits(run: RunReader, start_s: float, end_s: float) -> dict[str, Any]:
    """Return first harmonics in deck axes: ``frames``, of every frame's centre of mass and every
    probe on a frame; ``relative``, of every two frames, in the case's order, the motion of the second
    seen from the first, with its amplitude along the deck as an estimate; and their ``drift``."""
    frames = [name for name in run.case.screen.frames if run.has(f"frames/{name}")]
    probes = [name for name, probe in run.case.probes.items() if probe.frame and run.has(f"probes/{name}")]
    moved_m = {name: run.read(f"frames/{name}/displacement_m") for name in frames}
    moved_m |= {name: run.read(f"probes/{name}/position_m") for name in probes}
    pairs = {f"{two}-{one}": moved_m[two] - moved_m[one] for one, two in combinations(frames, 2)}
    time_s = run.series_s()

    def harmonics(motions: dict[str, Array]) -> dict[str, Harmonic]:
        return {
            name: first_harmonic(time_s, place_m @ run.deck_axes, run.cycle_s, start_s, end_s)
            for name, place_m in motions.items()
        }

    single, relative = harmonics(moved_m), harmonics(pairs)
    return {
        "frames": {name: motion.orbit() for name, motion in single.items()},
        "relative": {
            name: motion.orbit() | {"along_m": motion.estimate(0)} for name, motion in relative.items()
        },
        "drift": drift(list(single.values())),
    }


def why_not_settled(run: RunReader, start_s: float, end_s: float, drift_share: float | None) -> str:
    """Return why the frames' motion from ``start_s`` to ``end_s`` is no steady one; empty if it is.

    ``drift_share`` is the change of the first harmonics.  What is no harmonic is looked at by its range
    in each cycle, from every sync point.
    """
    if not run.is_driven:
        return "nothing drives the machine: it has no steady motion"
    for name in run.names("frames"):
        rows = run.read_cycles(f"point_cycles/{name}", start_s, end_s)
        range_m = np.linalg.norm(rows["most_m"] - rows["least_m"], axis=1)
        count = len(range_m)
        if count < FEWEST_CYCLES:
            cycles = f"{count} cycle{'' if count == 1 else 's'}"
            return f"averaged over {cycles}; {FEWEST_CYCLES} are needed to see it settle"
        early_m, late_m = range_m[: count // 2].mean(), range_m[-(count // 2) :].mean()
        changed = float(abs(late_m - early_m) / early_m) if early_m > 0 else 0.0
        if changed > LARGEST_DRIFT:
            return _describe_change(f"the range of {name} in a cycle", changed, count)
    if drift_share is not None and drift_share > LARGEST_DRIFT:
        return _describe_change("the first harmonic", drift_share, round((end_s - start_s) / run.cycle_s))
    return ""


def _describe_change(what: str, share: float, cycles: int) -> str:
    return (
        f"{what} still changes: by {100 * share:.2g} % from the first half of the {cycles} cycles to the "
        f"second; up to {100 * LARGEST_DRIFT:g} % counts as settled"
    )


def why_no_band(run: RunReader) -> str:
    """Return why the series tell no acceleration up to BAND_HZ, although sync points would; empty
    where they do, or where sync points are no nearer to each other."""
    time_s = run.series_s()
    if len(time_s) < 2:
        return "the series have one row only (output.series_s)"
    step_s = float(time_s[1] - time_s[0])
    if band_hz(step_s) == BAND_HZ or step_s < 1.5 * run.case.coupling.sync_interval_s:
        return ""
    return (
        f"the series have a row every {step_s:.2g} s: too seldom for accelerations up to "
        f"{BAND_HZ:g} Hz (output.series_s of at most {LARGEST_BAND / (2 * BAND_HZ):.2g} s)"
    )


def acceleration_m_per_s2(velocity_m_per_s: Array, step_s: float) -> Array:
    """Return (n, 3) accelerations from (n, 3) velocities at equal steps.

    They are band-limited to ``BAND_HZ`` by a Butterworth filter of fourth order run to and fro (no
    phase shift), then differentiated by central differences.
    """
    limit = 2 * BAND_HZ * step_s
    if limit < LARGEST_BAND:  # else the steps themselves are the limit
        velocity_m_per_s = sosfiltfilt(butter(4, limit, output="sos"), velocity_m_per_s, axis=0)
    return np.asarray(np.gradient(velocity_m_per_s, step_s, axis=0))


def band_hz(step_s: float) -> float:
    """Return up to which frequency ``acceleration_m_per_s2`` tells something."""
    return BAND_HZ if 2 * BAND_HZ * step_s < LARGEST_BAND else 0.5 / step_s


def panel_points(run: RunReader, start_s: float, end_s: float) -> dict[str, Any]:
    """Return the accelerations, in g, of the probes on panels; ``band_Hz`` is how far they reach."""
    normals = {panel.name: panel.rectangle.normal for panel in single_panels(run.case)}
    table = {}
    for name, probe in run.case.probes.items():
        if probe.panel is None or not run.has(f"probes/{name}"):
            continue
        time_s = run.read(f"probes/{name}/time_s")
        step_s = float(time_s[1] - time_s[0])
        window = within(time_s, start_s, end_s, run.cycle_s)
        acceleration = acceleration_m_per_s2(run.read(f"probes/{name}/velocity_m_per_s"), step_s)[window]
        size_g = np.linalg.norm(acceleration, axis=1) / STANDARD_GRAVITY_M_PER_S2
        normal_g = acceleration @ normals[probe.panel] / STANDARD_GRAVITY_M_PER_S2
        cycle = cycle_numbers(time_s[window], run.cycle_s, start_s)
        parts = [size_g[cycle == number] for number in np.unique(cycle)]
        rms_g, square = rms(size_g), mean(np.array([float(np.mean(part**2)) for part in parts]))
        width = square.half_width
        table[name] = {
            "panel": probe.panel,
            "at": list(probe.at or ()),
            "band_Hz": band_hz(step_s),
            "peak_g": float(size_g.max()),
            "rms_g": Estimate(rms_g, width / (2 * rms_g) if width is not None and rms_g else None),
            "peak_normal_g": float(np.abs(normal_g).max()),
            "rms_normal_g": rms(normal_g),
            "cycle_peak_g": mean(np.array([float(part.max()) for part in parts])),
        }
    return table


def rms(values: Array) -> float:
    """Return the root of the mean square."""
    return float(np.sqrt(np.mean(values**2)))


def panel_loads(run: RunReader, start_s: float, end_s: float) -> dict[str, Any]:
    """Return the pull on the clamps, the load of the bed and the stretch along the middle line of
    every panel, from every sync point of the cycles averaged over."""
    table = {}
    for name in run.names("panel_cycles"):
        rows = run.read_cycles(f"panel_cycles/{name}", start_s, end_s)
        weight = rows["sync_points"] / rows["sync_points"].sum()
        table[name] = {
            "tension_mean_N": float(weight @ rows["pull_mean_N"]),
            "tension_largest_N": float(rows["pull_most_N"].max()),
            "tension_smallest_N": float(rows["pull_least_N"].min()),
            "largest_clamp_force_N": float(rows["clamp_most_N"].max()),
            "stretch_largest_percent": 100 * float(rows["stretch_most"].max()),
            "stretch_smallest_percent": 100 * float(rows["stretch_least"].min()),
            "load_N": weight @ rows["load_mean_N"] @ run.deck_axes,
        }
    return table


def point_ranges(run: RunReader) -> dict[str, dict[str, Any]]:
    """Return how far every frame's centre of mass and every probe moved, whatever its harmonics.

    ``half_range_m`` (3,) is half the range over the last two whole cycles of the machine, or over all
    of a run that is shorter or has no cycle; ``mean_m`` (3,) the mean displacement over them;
    ``peak_m`` the largest size of the displacement from the place at t = 0 over the whole run;
    ``peak_speed_m_per_s`` likewise.  Of points on frames and panels these are taken at sync points,
    however seldom rows are written.  Of a particle the rows of the series are all there is, and the
    time in which it is present is taken for the run.  Where nothing can be said all four are None,
    and ``reason`` says why.
    """
    table = {name: _range_of_point(run, f"point_cycles/{name}") for name in run.names("point_cycles")}
    for name in run.names("probes"):
        if name not in table:
            table[name] = _range_of_particle(run, f"probes/{name}")
    return table


def _range_of_point(run: RunReader, group: str) -> dict[str, Any]:
    rows = {name: run.read(f"{group}/{name}") for name in run.names(group)}
    last = last_cycles(rows["time_s"], run.cycle_s if run.is_driven else None)
    count = rows["sync_points"][last]
    return {
        "half_range_m": (rows["most_m"][last].max(axis=0) - rows["least_m"][last].min(axis=0)) / 2,
        "mean_m": count @ rows["mean_m"][last] / count.sum(),
        "peak_m": rows["farthest_m"].max(),
        "peak_speed_m_per_s": rows["fastest_m_per_s"].max(),
        "reason": "",
    }


def last_cycles(end_s: Array, cycle_s: float | None) -> slice:
    """Return which of the rows of cycles that end at ``end_s`` are of the last whole ones; all where
    there are not so many, or no cycles (None)."""
    if cycle_s is None:
        return slice(None)
    number = cycle_numbers(end_s, cycle_s)
    is_whole = abs(end_s[-1] - (number[-1] + 1) * cycle_s) < 1e-6 * cycle_s
    whole = int(number[-1]) + is_whole
    if whole < RANGE_CYCLES:
        return slice(None)
    return slice(*np.searchsorted(number, [whole - RANGE_CYCLES, whole]).tolist())


def _range_of_particle(run: RunReader, group: str) -> dict[str, Any]:
    time_s, place_m = run.read(f"{group}/time_s"), run.read(f"{group}/position_m")
    there = np.isfinite(place_m).all(axis=1)
    if not there.any():
        return UNKNOWN | {"reason": "it never was there"}
    span = "a cycle" if run.is_driven else "a fiftieth of the run,"
    if why := rows_too_seldom(time_s, run.cycle_s, run.case.coupling.sync_interval_s, span, 0):
        return UNKNOWN | {"reason": why}
    moved_m, time_s = place_m[there] - place_m[there][0], time_s[there]
    lasting_s = RANGE_CYCLES * run.cycle_s if run.is_driven else np.inf
    last_m = moved_m[time_s >= time_s[-1] - lasting_s]
    return {
        "half_range_m": np.ptp(last_m, axis=0) / 2,
        "mean_m": last_m.mean(axis=0),
        "peak_m": np.linalg.norm(moved_m, axis=1).max(),
        "peak_speed_m_per_s": np.linalg.norm(run.read(f"{group}/velocity_m_per_s")[there], axis=1).max(),
        "reason": "",
    }
