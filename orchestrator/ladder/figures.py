"""What a rung's run is measured by, and how far it is from the reference.

All over the last whole cycles of the run (at most four, never the run-up's first half); panels'
figures are means over the panels.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from orchestrator.casefile.case import Case
from orchestrator.casefile.levels import load
from orchestrator.deck.panels import SinglePanel, single_panels
from orchestrator.ports import Array
from orchestrator.recording import RecordedGrid
from orchestrator.records.summary import cycle_s
from orchestrator.results.vibration import STANDARD_GRAVITY_M_S2, acceleration_m_s2

CYCLES = 4
QUANTITIES = {
    "deflection_m": "panel: amplitude of the middle / m",
    "shape": "panel: shape over the cycles",
    "clamp_peak_N": "clamp force: peak / N",
    "clamp_rms_N": "clamp force: rms / N",
    "peak_g": "panel's middle: peak acceleration / g",
    "rms_g": "panel's middle: rms acceleration / g",
    "frame_m": "frames: largest amplitude / m",
    "passing_kg_s": "passing: through the exits / (kg/s)",
}


@dataclass(frozen=True)
class Figures:
    """``values`` by QUANTITIES (without "shape" and what a case does not have), ``own`` the
    uncertainty of those that are statistics; ``shapes_m`` (rows, values) to be compared; the
    ``change`` is that of the shape from the cycle before."""

    values: dict[str, float]
    own: dict[str, float]
    shapes_m: Array
    change: float | None
    wall_s: float
    processor_s: float
    wall_by_part_s: dict[str, float]
    memory_MiB: float
    simulated_s: float


def figures(folder: Path) -> Figures:
    """Of a finished run with ``output.shapes_s``."""
    summary, case = json.loads((folder / "summary.json").read_text()), load(folder).case
    end_s, cycle = summary["simulated_s"], cycle_s(case)
    count = max(1, min(CYCLES, int(end_s / 2 / cycle + 1e-9)))
    start_s = max(0.0, end_s - count * cycle)
    with h5py.File(folder / "history.h5") as history:
        panels = [_panel(history, case, panel, start_s, cycle) for panel in single_panels(case)]
        values = {"frame_m": _frame(history, start_s)} if case.screen.frames else {}
        passing = _passing(history, case, start_s, end_s)
    shapes_m = np.hstack([panel.shape_m for panel in panels]) if panels else np.empty((0, 0))
    for name in panels[0].values if panels else ():
        values[name] = float(np.mean([panel.values[name] for panel in panels]))
    own = {}
    if passing is not None:
        values["passing_kg_s"], own["passing_kg_s"] = passing
    rows = round(cycle * (len(shapes_m) - 1) / (end_s - start_s)) if len(shapes_m) else 0
    change = relative(shapes_m[:-rows], shapes_m[rows:]) if 0 < rows < len(shapes_m) / 2 else None
    return Figures(
        values,
        own,
        shapes_m,
        change,
        summary["wall_s"],
        summary["processor_s"],
        summary["wall_by_part_s"],
        summary["peak_memory_MiB"],
        end_s,
    )


def errors(found: Figures, reference: Figures) -> dict[str, float]:
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


@dataclass(frozen=True)
class PanelFigures:
    values: dict[str, float]
    shape_m: Array


def _panel(
    history: Any, case: Case, panel: SinglePanel, start_s: float, cycle: float
) -> PanelFigures:
    shapes = history[f"shapes/{panel.name}"]
    time_s = shapes["time_s"][:]
    last = time_s >= start_s - 1e-9
    grid, at = RecordedGrid.of(panel.rectangle, case.panel.surface_cells), panel.rectangle
    turn = np.stack([at.along, at.across, at.normal], axis=1)
    place_m, velocity_m_s = shapes["position_m"][:], shapes["velocity_m_s"][:]
    carried = grid.carried(at)
    corners = [int(number) for number in carried.argmax(axis=0)]
    shape_m = (place_m - carried @ place_m[:, corners])[last] @ turn
    # the line along the middle, or beside it where no grid line runs there
    line = np.arange(len(grid.rows_m)) * len(grid.columns_m) + len(grid.columns_m) // 2
    middle = line[len(line) // 2]
    step_s = float(np.diff(time_s).mean())
    acceleration = acceleration_m_s2(velocity_m_s[:, middle], step_s)[last]
    size_g = np.linalg.norm(acceleration, axis=1) / STANDARD_GRAVITY_M_S2
    forces = history[f"forces/{panel.name}"]
    pull_N = np.linalg.norm(forces["first_clamp_N"][:], axis=1)[forces["time_s"][:] > start_s]
    values = {
        "deflection_m": _amplitude(shape_m[:, middle, 2], time_s[last], cycle),
        "clamp_peak_N": float(pull_N.max()),
        "clamp_rms_N": float(np.sqrt(np.mean(pull_N**2))),
        "peak_g": _mean_peak(size_g, time_s[last], cycle),
        "rms_g": float(np.sqrt(np.mean(size_g**2))),
    }
    return PanelFigures(values, shape_m[:, line][:, :, [0, 2]].reshape(len(shape_m), -1))


def _amplitude(place_m: Array, time_s: Array, cycle: float) -> float:
    """Mean over the cycles of half the range."""
    return float(np.mean([np.ptp(part) / 2 for part in _cycles(place_m, time_s, cycle)]))


def _mean_peak(size: Array, time_s: Array, cycle: float) -> float:
    return float(np.mean([part.max() for part in _cycles(size, time_s, cycle)]))


def _cycles(values: Array, time_s: Array, cycle: float) -> list[Array]:
    number = np.floor((time_s - time_s[0]) / cycle - 1e-6).astype(int).clip(0)
    return [values[number == one] for one in range(max(1, number.max()))]


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
    mass_kg = np.pi / 6 * gone["diameter_m"][:] ** 3 * gone["density_kg_m3"][:]
    span_s = end_s - start_s
    return float(mass_kg[late].sum() / span_s), float(np.sqrt(np.sum(mass_kg[late] ** 2)) / span_s)
