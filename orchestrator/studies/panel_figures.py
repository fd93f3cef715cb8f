"""What the motion of one panel is measured by, over the last whole cycles of a run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from orchestrator.case.deck.panels import SinglePanel
from orchestrator.case.tables.case import Case
from orchestrator.output.cycles import cycle_numbers
from orchestrator.output.results.acceleration import acceleration_m_per_s2
from orchestrator.ports import Array
from orchestrator.ports.physics import STANDARD_GRAVITY_M_PER_S2
from orchestrator.ports.recording import RecordedGrid


@dataclass(frozen=True)
class PanelFigures:
    """``values`` by ``figures.QUANTITIES``; ``shape_m`` (rows, values) of the middle line."""

    values: dict[str, float]
    shape_m: Array


def panel_figures(history: Any, case: Case, panel: SinglePanel, start_s: float, cycle: float) -> PanelFigures:
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
    return PanelFigures(values, shape_m[:, line][:, :, [0, 2]].reshape(len(shape_m), -1))


def _half_range(place_m: Array, time_s: Array, cycle: float) -> float:
    """Mean over the cycles of half the range."""
    return float(np.mean([np.ptp(part) / 2 for part in _cycles(place_m, time_s, cycle)]))


def _mean_peak(size: Array, time_s: Array, cycle: float) -> float:
    return float(np.mean([part.max() for part in _cycles(size, time_s, cycle)]))


def _cycles(values: Array, time_s: Array, cycle: float) -> list[Array]:
    number = cycle_numbers(time_s, cycle, float(time_s[0]))
    return [values[number == one] for one in range(max(1, number.max()))]
