"""What a run is measured by when settings are compared, and how far it is from the reference.

All over the last whole cycles of the run (at most four, never the run-up's first half); metrics of
panels are means over the panels.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
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


@dataclass(frozen=True)
class Quantity:
    """A number that runs are compared by.

    ``short`` heads columns.  A value up to ``resolved`` is rounding or what a solver's tolerance
    leaves, and is not compared: coordinates of a few metres are rounded at 1e-15 m, resting shapes
    are found to 1e-11 m, and a nanometre at a machine's speed of 100 rad/s is 1e-6 g.
    ``is_decisive``: it repeats itself well enough to decide, unlike single peaks and shapes of slack
    panels.  ``is_extensive``: a slice of the width has its share of it.
    """

    words: str
    short: str
    resolved: float
    is_decisive: bool = True
    is_extensive: bool = False


QUANTITIES = {
    "deflection_m": Quantity("panel: half range of the middle in a cycle / m", "deflection", 1e-9),
    "shape": Quantity("panel: shape over the cycles", "shape", 0.0, False),
    "clamp_peak_N": Quantity("clamp force: peak / N", "clamp peak", 1e-6, False, True),
    "clamp_rms_N": Quantity("clamp force: rms / N", "clamp rms", 1e-6, True, True),
    "peak_g": Quantity("panel's middle: peak acceleration / g", "acc. peak", 1e-6, False),
    "rms_g": Quantity("panel's middle: rms acceleration / g", "acc. rms", 1e-6),
    "frame_m": Quantity("frames: largest half range / m", "frame", 1e-9),
    "passing_kg_per_s": Quantity("passing: through the exits / (kg/s)", "passing", 0.0, True, True),
    "efficiency_percent": Quantity("screening efficiency / %", "efficiency", 0.0),
    "velocity_m_per_s": Quantity("bed: mean velocity / (m/s)", "velocity", 1e-6),
}
DECISIVE = tuple(name for name, quantity in QUANTITIES.items() if quantity.is_decisive)
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
    resolved, with which nothing is compared), of the whole width where a slice was run; ``defects``
    by DEFECTS; ``shapes_m`` (rows, values) to be compared; ``summary`` of the run."""

    values: dict[str, float]
    defects: dict[str, float]
    shapes_m: Array
    summary: Mapping[str, Any]


def measure(folder: Path) -> Metrics:
    """Returns the metrics of a finished run with ``output.shapes_s``."""
    with RunReader(folder) as run:
        return _measure(run)


def _measure(run: RunReader) -> Metrics:
    summary, case, history = run.summary, run.case, run.history
    end_s, cycle = summary["simulated_s"], cycle_s(case)
    count = max(1, min(CYCLES, int(end_s / 2 / cycle + 1e-9)))
    start_s = max(0.0, end_s - count * cycle)
    panels = [_panel_metrics(history, case, panel, start_s, cycle) for panel in single_panels(case)]
    values = {"frame_m": _frame_m(history, start_s)} if case.screen.frames else {}
    for name in panels[0][0] if panels else ():
        values[name] = float(np.mean([of_panel[name] for of_panel, _ in panels]))
    passing_kg_per_s = _passing_kg_per_s(history, case, start_s, end_s)
    if passing_kg_per_s is not None:
        values["passing_kg_per_s"] = passing_kg_per_s
    if case.screen.exits:  # else nothing flows, and a mean velocity is that of a swing
        values |= _bed_values(run.results)
    for name in values:
        if QUANTITIES[name].is_extensive:
            values[name] /= summary["share_of_width"]
    values = {name: value if is_resolved(name, value) else 0.0 for name, value in values.items()}
    shapes_m = np.hstack([shape_m for _, shape_m in panels]) if panels else np.empty((0, 0))
    if not values.get("deflection_m"):  # a shape that is no more than rounding is not compared either
        shapes_m = shapes_m[:, :0]
    defects = {
        "energy_defect": abs(share_created(summary)),
        "momentum_defect": summary["momentum_residual_relative"],
    }
    return Metrics(values, defects, shapes_m, summary)


def is_resolved(name: str, value: float) -> bool:
    """Whether the value of a quantity is more than rounding and the solvers' noise."""
    return abs(value) > QUANTITIES[name].resolved


def happens(values: Mapping[str, float | None]) -> bool:
    """Returns whether anything that can be resolved moves in a run with such ``values`` (by
    QUANTITIES), or changes the pull of a clamp, as a particle does on a rigid panel."""
    found = {name: value for name in MOVING if (value := values.get(name)) is not None}
    if any(is_resolved(name, value) for name, value in found.items()):
        return True
    peak_N, rms_N = values.get("clamp_peak_N"), values.get("clamp_rms_N")
    if peak_N is None or rms_N is None:
        return False
    return peak_N - rms_N > max(QUANTITIES["clamp_peak_N"].resolved, STEADY * peak_N)


def relative(values: Array, reference: Array) -> float:
    """L2 norm of the difference over that of the reference about its mean over time."""
    size = float(np.linalg.norm(reference - reference.mean(axis=0)))
    return float(np.linalg.norm(values - reference)) / size if size else math.inf


def _bed_values(results: dict[str, Any]) -> dict[str, float]:
    """Returns what the run's own results say, as far as it is defined."""
    parts = (("efficiency_percent", "screening"), ("velocity_m_per_s", "bed"))
    values = {name: results.get(part, {}).get(name, {}).get("value") for name, part in parts}
    return {name: float(value) for name, value in values.items() if value is not None}


def _frame_m(history: Any, start_s: float) -> float:
    """Returns half the range, as a vector's size, of the frame that moves most."""
    return max(
        float(np.linalg.norm(np.ptp(group["displacement_m"][:][group["time_s"][:] >= start_s], axis=0) / 2))
        for group in history["frames"].values()
    )


def _passing_kg_per_s(history: Any, case: Case, start_s: float, end_s: float) -> float | None:
    """Returns the mass that left through exits, over time; None where nothing can leave, or
    nothing did."""
    if not case.screen.exits or "removed" not in history or "time_s" not in history["removed"]:
        return None
    gone = history["removed"]
    late = (gone["time_s"][:] > start_s) & (gone["exit"][:] >= 0)
    mass_kg = sphere_mass_kg(gone["diameter_m"][:], gone["density_kg_per_m3"][:])
    return float(mass_kg[late].sum() / (end_s - start_s))


def _panel_metrics(
    history: Any, case: Case, panel: SinglePanel, start_s: float, cycle: float
) -> tuple[dict[str, float], Array]:
    """Returns values by ``QUANTITIES``, and the shape (rows, values) of the middle line, from
    ``start_s`` on, of a run with ``output.shapes_s``; ``cycle`` in s."""
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
        "deflection_m": _cycle_mean(np.ptp, shape_m[:, middle, 2], time_s[last], cycle) / 2,
        "clamp_peak_N": float(pull_N.max()),
        "clamp_rms_N": float(np.sqrt(np.mean(pull_N**2))),
        "peak_g": _cycle_mean(np.max, size_g, time_s[last], cycle),
        "rms_g": float(np.sqrt(np.mean(size_g**2))),
    }
    return values, shape_m[:, line][:, :, [0, 2]].reshape(len(shape_m), -1)


def _cycle_mean(figure: Callable[[Array], Any], values: Array, time_s: Array, cycle: float) -> float:
    """Returns the mean over the cycles of a figure of each."""
    number = cycle_numbers(time_s, cycle, float(time_s[0]))
    return float(np.mean([figure(values[number == each]) for each in range(max(1, number.max()))]))
