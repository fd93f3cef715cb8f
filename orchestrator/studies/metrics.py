"""What a run is measured by when settings are compared, and how far it is from the reference.

All over the last whole cycles of the run (at most four, never the run-up's first half); metrics of
panels are means over the panels.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from orchestrator.case.deck.panels import SinglePanel, single_panels
from orchestrator.case.tables.case import Case
from orchestrator.coupling.ledger import share_created
from orchestrator.output.cycles import cycle_numbers, cycle_s
from orchestrator.output.results.machine import acceleration_m_per_s2
from orchestrator.output.results.run_reader import RunReader
from orchestrator.ports import Array
from orchestrator.ports.physics import STANDARD_GRAVITY_M_PER_S2, sphere_mass_kg
from orchestrator.ports.recording import RecordedGrid

CYCLES = 4
EXTENSIVE = {"clamp_peak_N", "clamp_rms_N", "passing_kg_per_s"}
QUANTITIES = {
    "deflection_m": "panel: half range of the middle in a cycle / m",
    "shape": "panel: shape over the cycles",
    "clamp_peak_N": "clamp force: peak / N",
    "clamp_rms_N": "clamp force: rms / N",
    "peak_g": "panel's middle: peak acceleration / g",
    "rms_g": "panel's middle: rms acceleration / g",
    "frame_m": "frames: largest half range / m",
    "passing_kg_per_s": "passing: through the exits / (kg/s)",
    "efficiency_percent": "screening efficiency / %",
    "velocity_m_per_s": "bed: mean velocity / (m/s)",
}
SHORT = {
    "deflection_m": "deflection",
    "shape": "shape",
    "clamp_peak_N": "clamp peak",
    "clamp_rms_N": "clamp rms",
    "peak_g": "acc. peak",
    "rms_g": "acc. rms",
    "frame_m": "frame",
    "passing_kg_per_s": "passing",
    "efficiency_percent": "efficiency",
    "velocity_m_per_s": "velocity",
}
DECISIVE = (
    "deflection_m",
    "clamp_rms_N",
    "rms_g",
    "frame_m",
    "passing_kg_per_s",
    "efficiency_percent",
    "velocity_m_per_s",
)
"""What repeats itself well enough to decide; single peaks and shapes of slack panels do not."""
RESOLVED = {
    "deflection_m": 1e-9,
    "frame_m": 1e-9,
    "clamp_peak_N": 1e-6,
    "clamp_rms_N": 1e-6,
    "peak_g": 1e-6,
    "rms_g": 1e-6,
    "velocity_m_per_s": 1e-6,
    "passing_kg_per_s": 0.0,
    "efficiency_percent": 0.0,
}
"""A quantity up to this is rounding or what a solver's tolerance leaves, and is not compared:
coordinates of a few metres are rounded at 1e-15 m, resting shapes are found to 1e-11 m, and a
nanometre at a machine's speed of 100 rad/s is 1e-6 g."""
MOVING = tuple(name for name in DECISIVE if name != "clamp_rms_N")
"""Clamps pull while nothing happens, too: what tells of them is whether their pull changes."""
STEADY = 1e-6
"""A pull whose peak is above its root mean square by no more than this share does not change."""
DEFECTS = {
    "energy_defect": "energy created by the coupling, of what was exchanged and lost",
    "momentum_defect": "momentum residual of the worst member",
}
"""What ought to be nothing."""


@dataclass(frozen=True)
class Metrics:
    """``values`` by QUANTITIES (without "shape" and what a case does not have; 0 for what is not
    above RESOLVED, with which nothing is compared), of the whole width where a slice was run;
    ``own`` the uncertainty of those that are statistics; ``defects`` by DEFECTS; ``shapes_m``
    (rows, values) to be compared; the ``change`` is that of the shape from the cycle before."""

    values: dict[str, float]
    own: dict[str, float]
    defects: dict[str, float]
    shapes_m: Array
    change: float | None
    wall_s: float
    processor_s: float
    wall_by_part_s: dict[str, float]
    memory_MiB: float
    simulated_s: float
    processor_before_s: float = 0.0


def measure(folder: Path) -> Metrics:
    """Of a finished run with ``output.shapes_s``."""
    with RunReader(folder) as run:
        return _measure(run)


def _measure(run: RunReader) -> Metrics:
    summary, case, history = run.summary, run.case, run.history
    end_s, cycle = summary["simulated_s"], cycle_s(case)
    count = max(1, min(CYCLES, int(end_s / 2 / cycle + 1e-9)))
    start_s = max(0.0, end_s - count * cycle)
    panels = [_panel_metrics(history, case, one, start_s, cycle) for one in single_panels(case)]
    values = {"frame_m": _frame(history, start_s)} if case.screen.frames else {}
    passing = _passing(history, case, start_s, end_s)
    shapes_m = np.hstack([panel.shape_m for panel in panels]) if panels else np.empty((0, 0))
    for name in panels[0].values if panels else ():
        values[name] = float(np.mean([panel.values[name] for panel in panels]))
    own = {}
    if passing is not None:
        values["passing_kg_per_s"], own["passing_kg_per_s"] = passing
    if case.screen.exits:  # else nothing flows, and a mean velocity is that of a swing
        values |= _of_the_bed(summary.get("results", {}), own)
    for name in EXTENSIVE & values.keys():
        values[name] /= summary["share_of_width"]
    values = {name: value if is_resolved(name, value) else 0.0 for name, value in values.items()}
    if not values.get("deflection_m"):  # a shape that is no more than rounding is not compared either
        shapes_m = shapes_m[:, :0]
    rows = round(cycle * (len(shapes_m) - 1) / (end_s - start_s)) if len(shapes_m) else 0
    change = relative(shapes_m[:-rows], shapes_m[rows:]) if 0 < rows < len(shapes_m) / 2 else None
    return Metrics(
        values,
        own,
        _defects(summary),
        shapes_m,
        change,
        summary["wall_s"],
        summary["processor_s"],
        summary["wall_by_part_s"],
        summary["peak_memory_MiB"],
        end_s,
        summary.get("processor_before_s", 0.0),  # runs of older versions do not tell
    )


def is_resolved(name: str, value: float) -> bool:
    """Whether the value of a quantity is more than rounding and the solvers' noise."""
    return abs(value) > RESOLVED[name]


def happens(values: Mapping[str, float | None]) -> bool:
    """Returns whether anything that can be resolved moves in a run with such ``values`` (by
    QUANTITIES), or changes the pull of a clamp, as a particle does on a rigid panel."""
    found = {name: value for name in MOVING if (value := values.get(name)) is not None}
    if any(is_resolved(name, value) for name, value in found.items()):
        return True
    peak_N, rms_N = values.get("clamp_peak_N"), values.get("clamp_rms_N")
    if peak_N is None or rms_N is None:
        return False
    return peak_N - rms_N > max(RESOLVED["clamp_peak_N"], STEADY * peak_N)


def errors(found: Metrics, reference: Metrics) -> dict[str, float]:
    """Relative to the reference, by quantity; shapes in the L2 norm, about their mean."""
    differences = {
        name: abs(value - reference.values[name]) / abs(reference.values[name])
        for name, value in found.values.items()
        if reference.values.get(name)
    }
    if found.shapes_m.size and found.shapes_m.shape == reference.shapes_m.shape:
        differences["shape"] = relative(found.shapes_m, reference.shapes_m)
    return {name: differences[name] for name in QUANTITIES if name in differences}


def relative(values: Array, reference: Array) -> float:
    """L2 norm of the difference over that of the reference about its mean over time."""
    size = float(np.linalg.norm(reference - reference.mean(axis=0)))
    return float(np.linalg.norm(values - reference)) / size if size else math.inf


def _of_the_bed(results: dict[str, Any], own: dict[str, float]) -> dict[str, float]:
    """What the run's own results say, as far as it is defined; half widths go into ``own``."""
    found = {}
    for name, part in (("efficiency_percent", "screening"), ("velocity_m_per_s", "bed")):
        estimate = results.get(part, {}).get(name, {})
        if estimate.get("value") is not None:
            found[name] = float(estimate["value"])
            if estimate["half_width"] is not None:
                own[name] = float(estimate["half_width"])
    return found


def _defects(summary: dict[str, Any]) -> dict[str, float]:
    return {
        "energy_defect": abs(share_created(summary)),
        "momentum_defect": summary["momentum_residual_relative"],
    }


def _frame(history: Any, start_s: float) -> float:
    """Half the range, as a vector's size, of the frame that moves most."""
    found = []
    for group in history["frames"].values():
        moved = group["displacement_m"][:][group["time_s"][:] >= start_s]
        found.append(float(np.linalg.norm(np.ptp(moved, axis=0) / 2)))
    return max(found)


def _passing(history: Any, case: Case, start_s: float, end_s: float) -> tuple[float, float] | None:
    """Mass that left through exits, over time, and its standard error as of independent events:
    the least that it can be.  None where nothing can leave, or nothing did."""
    if not case.screen.exits or "removed" not in history or "time_s" not in history["removed"]:
        return None
    gone = history["removed"]
    late = (gone["time_s"][:] > start_s) & (gone["exit"][:] >= 0)
    mass_kg = sphere_mass_kg(gone["diameter_m"][:], gone["density_kg_per_m3"][:])
    span_s = end_s - start_s
    return float(mass_kg[late].sum() / span_s), float(np.sqrt(np.sum(mass_kg[late] ** 2)) / span_s)


@dataclass(frozen=True)
class PanelMetrics:
    """``values`` by ``QUANTITIES``; ``shape_m`` (rows, values) of the middle line."""

    values: dict[str, float]
    shape_m: Array


def _panel_metrics(
    history: Any, case: Case, panel: SinglePanel, start_s: float, cycle: float
) -> PanelMetrics:
    """From ``start_s`` on, of a run with ``output.shapes_s``; ``cycle`` in s."""
    shapes = history[f"shapes/{panel.name}"]
    time_s = shapes["time_s"][:]
    last = time_s >= start_s - 1e-9
    grid, at = RecordedGrid.of(panel.rectangle, case.panel.surface_cells), panel.rectangle
    turn = np.stack([at.along, at.across, at.normal], axis=1)
    place_m, velocity_m_per_s = shapes["position_m"][:], shapes["velocity_m_per_s"][:]
    carried = grid.carried(at)
    corners = [int(number) for number in carried.argmax(axis=0)]
    shape_m = (place_m - carried @ place_m[:, corners])[last] @ turn
    # the line along the middle, or beside it where no grid line runs there
    line = np.arange(len(grid.rows_m)) * len(grid.columns_m) + len(grid.columns_m) // 2
    middle = line[len(line) // 2]
    step_s = float(np.diff(time_s).mean())
    acceleration = acceleration_m_per_s2(velocity_m_per_s[:, middle], step_s)[last]
    size_g = np.linalg.norm(acceleration, axis=1) / STANDARD_GRAVITY_M_PER_S2
    forces = history[f"forces/{panel.name}"]
    pull_N = np.linalg.norm(forces["first_clamp_N"][:], axis=1)[forces["time_s"][:] > start_s]
    values = {
        "deflection_m": _half_range(shape_m[:, middle, 2], time_s[last], cycle),
        "clamp_peak_N": float(pull_N.max()),
        "clamp_rms_N": float(np.sqrt(np.mean(pull_N**2))),
        "peak_g": _mean_peak(size_g, time_s[last], cycle),
        "rms_g": float(np.sqrt(np.mean(size_g**2))),
    }
    return PanelMetrics(values, shape_m[:, line][:, :, [0, 2]].reshape(len(shape_m), -1))


def _half_range(place_m: Array, time_s: Array, cycle: float) -> float:
    """Mean over the cycles of half the range."""
    return float(np.mean([np.ptp(part) / 2 for part in _cycles(place_m, time_s, cycle)]))


def _mean_peak(size: Array, time_s: Array, cycle: float) -> float:
    return float(np.mean([part.max() for part in _cycles(size, time_s, cycle)]))


def _cycles(values: Array, time_s: Array, cycle: float) -> list[Array]:
    number = cycle_numbers(time_s, cycle, float(time_s[0]))
    return [values[number == one] for one in range(max(1, number.max()))]
