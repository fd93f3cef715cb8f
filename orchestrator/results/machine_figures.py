"""The machine's motion: frames' orbits, panels' accelerations, pull and stretch."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from typing import Any

import numpy as np

from orchestrator.deck.panels import SinglePanel, single_panels
from orchestrator.ports import Array, Indices
from orchestrator.results.estimate import Estimate, mean
from orchestrator.results.panel_load import line_length_m, stretch, tension_N
from orchestrator.results.run_data import RunData
from orchestrator.results.vibration import (
    STANDARD_GRAVITY_M_S2,
    Orbit,
    acceleration_m_s2,
    orbit,
    shaking,
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


def rows_in_cycle(data: RunData) -> float:
    """How many times of the series there are in a cycle; 0 where there is one time at most."""
    time = data.read(f"frames/{data.names('frames')[0]}/time_s")
    return float(data.cycle_s * (len(time) - 1) / np.ptp(time)) if len(time) > 1 else 0.0


def panel_points(data: RunData, start_s: float, end_s: float) -> dict[str, Any]:
    """Accelerations, in g, of the probes on panels."""
    normals = {panel.name: _normal(panel) for panel in single_panels(data.case)}
    found = {}
    for name, probe in data.case.probes.items():
        if probe.panel is None or name not in data.names("probes"):
            continue
        time = data.read(f"probes/{name}/time_s")
        step_s = float(time[1] - time[0])
        acceleration = acceleration_m_s2(data.read(f"probes/{name}/velocity_m_s"), step_s)
        window = (time >= start_s) & (time <= end_s)
        time, acceleration = time[window], acceleration[window]
        shaken = shaking(acceleration, normals[probe.panel])
        parts = _cycles(time, data.cycle_s)
        size = np.linalg.norm(acceleration, axis=1) / STANDARD_GRAVITY_M_S2
        square = mean(np.array([float(np.mean(size[part] ** 2)) for part in parts]))
        found[name] = {
            "panel": probe.panel,
            "at": list(probe.at or ()),
            "peak_g": shaken.peak,
            "rms_g": _root(square, shaken.rms),
            "peak_normal_g": shaken.peak_normal,
            "rms_normal_g": shaken.rms_normal,
            "cycle_peak_g": mean(np.array([float(size[part].max()) for part in parts])),
        }
    return found


def panel_loads(data: RunData, start_s: float, end_s: float) -> dict[str, Any]:
    """Pull on the clamps, and stretch along the centre line, of every panel."""
    found = {}
    for panel in single_panels(data.case):
        time = data.read(f"forces/{panel.name}/time_s")
        window = (time >= start_s) & (time <= end_s)
        first, second = (
            data.read(f"forces/{panel.name}/{end}_clamp_N")[window] for end in ("first", "second")
        )
        pull = tension_N(first, second, panel.rectangle.along)
        lines = data.read(f"panels/{panel.name}/centre_line_m")
        strain = stretch(lines, panel.rectangle.length_m, clamped_m(panel, lines[0]))
        shown = data.read(f"panels/{panel.name}/time_s")
        strain = strain[(shown >= start_s) & (shown <= end_s)]
        found[panel.name] = {
            "tension_mean_N": float(pull.mean()),
            "tension_largest_N": float(pull.max()),
            "tension_smallest_N": float(pull.min()),
            "largest_clamp_force_N": float(np.linalg.norm([first, second], axis=2).max()),
            "stretch_largest_percent": 100 * float(strain.max()),
            "stretch_smallest_percent": 100 * float(strain.min()),
            "load_N": _mean(data.read(f"forces/{panel.name}/load_N")[window] @ data.deck_axes),
        }
    return found


def _mean(vectors: Array) -> list[float]:
    return [float(value) for value in vectors.mean(axis=0)]


def clamped_m(panel: SinglePanel, line_m: Array) -> float:
    """How much of a centre line at t = 0 lies outside the free length, under the clamps."""
    at = panel.rectangle
    along = (line_m - at.corner_m) @ at.along
    inside = (along > -0.5 * at.clamp_m - 1e-9) & (along < at.span_m + 0.5 * at.clamp_m + 1e-9)
    whole, free = line_length_m(line_m[None]), line_length_m(line_m[inside][None])
    return float(whole[0] - free[0])


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
    """Rows of each whole cycle; the times span whole ones, up to a sync interval at the ends."""
    number = np.floor((time_s - time_s[0]) / cycle_s + 1e-6).astype(int)
    whole = round((time_s[-1] - time_s[0]) / cycle_s)
    return [np.flatnonzero(number == cycle) for cycle in range(whole)]


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
