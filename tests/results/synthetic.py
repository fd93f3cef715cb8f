"""A run's folder made by hand: a screen of which every figure is known without any solver.

The machine turns at 78.5 rad/s for 60 cycles.  The driving frame moves by 2 mm along the deck
and 3.5 mm normal to it, the driven one by 8 and 5 mm, in phase; the panels' middles by 10 mm
along the normal.  The panels wear by ``WEAR_M_H``, one row of patches twice as fast.
In every cycle ten particles are fed and, from the tenth cycle on, ten leave:

            2 mm  2.8 mm  5 mm
one           4       1      0       cut size 3 mm
two           1       1      0
end           0       1      2
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import h5py
import numpy as np

from orchestrator.case.bed.saved_bed import shape_attributes
from orchestrator.case.deck.panels import axes, single_panels
from orchestrator.case.file.whole import write_json
from orchestrator.case.tables.case import Case
from orchestrator.figures.figure import to_json
from orchestrator.figures.results import Results, parse_results
from orchestrator.output.records.history import History
from orchestrator.output.records.snapshots import Series, particle_mesh, surface_mesh
from orchestrator.output.records.summary import write_summary
from orchestrator.output.records.wear_record import PATCHES
from orchestrator.output.results.compute import compute_results
from orchestrator.ports import Array, Motion, ParticleSnapshot
from orchestrator.preflight.judge import load_judged
from tests.cases import case_folder
from tests.grains import SHAPES, spheres

ROOT = Path(__file__).parents[2]
CYCLE_S = 2 * np.pi / 78.5
CYCLES, FILLED = 60, 10
STEP_S = CYCLE_S / 80
DENSITY = 1430.0
SIZES_M = np.array([0.002, 0.0028, 0.005])
LEAVES = np.array([[4, 1, 0], [1, 1, 0], [0, 1, 2]])  # particles a cycle, by exit and size
FRAMES_M = {"driving": (0.002, 0.0035), "driven": (0.008, 0.005)}
PANEL_M = 0.010
ROTATION = {"number": "rotation", "value": 0.0512, "threshold": "0.1", "matters": False}
TURNED_RAD = 0.001  # of both frames about the axis across
POWER_W, LOST_W = 2.0, 1.0  # of the exciter, of a loss
PULL_N = 50.0  # amplitude of the panels' pull, in phase with their stretch
OVERLAPS = {"between_per_diameter": 0.01, "surface_per_diameter": 0.02, "surface_m": 4e-5}
DEPTH_M, VELOCITY_M_S, BIN_KG = 0.05, 0.3, 0.2
WEAR_M_H, WORN_ROW = {"deck-1": 3e-6, "deck-2": 2e-6}, 5
MASS_KG = np.pi / 6 * SIZES_M**3 * DENSITY


def folder_of(place: Path, particles: bool = True, cycles: int = CYCLES) -> Path:
    """Writes the folder; without ``particles`` it is an empty machine's."""
    case = _case(particles, max(cycles, 2) * CYCLE_S)
    table = case.model_dump(mode="json", exclude_none=True)
    case_folder(place, table | {"default_level": ""})
    history = History(place / "history.h5")
    _machine(history, case, cycles)
    _cycles(history, case, cycles)
    if particles:
        _bed(history, case, cycles)
    history.close()
    if particles:
        _events(place / "history.h5", cycles)
    _snapshots(place, case, particles, cycles)
    write_summary(place, _summary(particles, cycles))
    started = {"started": "2024-01-02T03:04:05+00:00", "ranks": 1, "machine": "by hand"}
    write_json(place / "provenance.json", started | {"commit": None, "versions": {"flipflow": "0"}})
    (place / "run.log").write_text("2024-01-02 03:04:05,000 WARNING a warning of the log\n")
    return place


def _case(particles: bool, duration_s: float) -> Case:
    name = "quickstart" if particles else "empty-machine"
    sets = [f"duration_s={duration_s}", "screen.surfaces={}", "coupling.sync_interval_s=1e-3"]
    # neither taut nor slack, so that a panel's stretch is that of its centre line
    flat = ["screen.panels.deck.length_m=0.3", "screen.panels.deck.tension_m=0.0"]
    sets += ["output.cut_size_m=0.003", *flat] if particles else []
    return load_judged(ROOT / "cases" / name, "draft", sets).case


def moved(case: Case, along_m: float, normal_m: float, time_s: float) -> Array:
    """Displacement (3,) in the world: cos along the deck, sin normal to it."""
    phase = 78.5 * time_s
    return axes(case) @ np.array([along_m * np.cos(phase), 0.0, normal_m * np.sin(phase)])


def _machine(history: History, case: Case, cycles: int) -> None:
    for i in range(80 * cycles + 1):
        time, quarter = i * STEP_S, np.pi / 2 / 78.5
        for name, size in FRAMES_M.items():
            here, then = (moved(case, *size, t) for t in (time, time + quarter))
            turned = TURNED_RAD * np.sin(78.5 * time) * axes(case)[:, 1]
            values = {"displacement_m": here, "velocity_m_per_s": 78.5 * then, "rotation_rad": turned}
            history.add(f"frames/{name}", time, values)
        for name, probe in case.probes.items():
            size = FRAMES_M[probe.frame] if probe.frame else (0.0, PANEL_M)
            here, then = (moved(case, *size, t) for t in (time, time + quarter))
            history.add(f"probes/{name}", time, {"position_m": here, "velocity_m_per_s": 78.5 * then})
        for panel in single_panels(case):
            stretched = np.cos(78.5 * time) * (1 if panel.frames[1] == "driven" else -1)
            pull = (150.0 + PULL_N * stretched) * panel.rectangle.along
            values = {"load_N": [0.0, 0.0, -3.0], "reaction_N": [0.0, 0.0, 0.0]}
            values |= {"first_clamp_N": pull, "second_clamp_N": -pull}
            history.add(f"forces/{panel.name}", time, values)
        if i % 8 == 0:
            terms = {"supplied.frames.exciter_J": POWER_W * time, "lost.a.b_J": LOST_W * time}
            history.add("energy", time, terms)
            for panel in single_panels(case):
                line = panel_line(case, panel.name, time)
                history.add(f"panels/{panel.name}", time, {"centre_line_m": line})


def _cycles(history: History, case: Case, cycles: int) -> None:
    """Write what every sync point of each cycle shows together: all cycles are alike."""
    for number in range(cycles + 1):
        time_s = number * CYCLE_S
        terms = {"supplied.frames.exciter_J": POWER_W * time_s, "lost.a.b_J": LOST_W * time_s}
        history.add("energy_cycles", time_s, terms | {"stored.a.b_J": 3.0})
    for number in range(cycles):
        end_s = (number + 1) * CYCLE_S
        for name, size in FRAMES_M.items():
            along_m, normal_m = size
            half_m = np.abs(axes(case)) @ np.array([along_m, 0.0, normal_m])
            values = {"sync_points": 80.0, "least_m": -half_m, "mean_m": 0 * half_m}
            values |= {"most_m": half_m, "farthest_m": max(size), "fastest_m_per_s": 78.5 * max(size)}
            history.add(f"point_cycles/{name}", end_s, values)
        for panel in single_panels(case):
            least_m = panel.rectangle.span_m / panel.rectangle.length_m - 1.0
            values = {
                "sync_points": 80.0,
                "pull_least_N": 150.0 - PULL_N,
                "pull_mean_N": 150.0,
                "pull_most_N": 150.0 + PULL_N,
                "clamp_most_N": 150.0 + PULL_N,
                "load_mean_N": np.array([0.0, 0.0, -3.0]),
                "stretch_least": least_m,
                "stretch_most": 1.02 * (1.0 + least_m) - 1.0,
                "sag_most_m": 0.0,
                "middle_least_m": 0.0,
                "middle_most_m": 0.0,
            }
            history.add(f"panel_cycles/{panel.name}", end_s, values)


def panel_line(case: Case, name: str, time_s: float) -> Array:
    """(21, 3): straight, in the plane of the deck, stretched by up to 2 % at its end."""
    at = next(panel.rectangle for panel in single_panels(case) if panel.name == name)
    stretched = 1.0 + 0.02 * np.sin(78.5 * time_s / 2) ** 2
    s = np.linspace(0.0, at.span_m, 21) * stretched
    return at.corner_m + np.outer(s, at.along) + 0.5 * at.width_m * at.across


def _bed(history: History, case: Case, cycles: int) -> None:
    bins = 8
    along = (np.arange(bins) + 0.5) * 0.638 / bins
    for i in range(10 * cycles + 1):
        mass = np.full(bins, BIN_KG)
        values = {"along_m": along, "mass_kg": mass, "velocity_m_per_s": np.full(bins, VELOCITY_M_S)}
        depth = np.full(bins, DEPTH_M) - 0.005 * np.arange(bins)
        history.add("profile", i * CYCLE_S / 10, values | {"depth_m": depth})
        values = {"mass_kg": bins * BIN_KG, "particles": 100.0}
        history.add("bed", i * CYCLE_S / 10, values)
        history.add("overlaps", i * CYCLE_S / 10, OVERLAPS)
        for panel, rate in WEAR_M_H.items():
            history.add(f"wear/{panel}", i * CYCLE_S / 10, _worn(rate, i * CYCLE_S / 10))
        history.add(
            "held",
            i * CYCLE_S / 10,
            {"stickers": 7.0, "mass_kg": 0.001, "pegged_kg": 0.0005, "openings": 3.0},
        )


def _worn(rate_m_per_h: float, time_s: float) -> dict[str, Array | float]:
    """All wear is done in the second half of each cycle."""
    cycle, phase = divmod(time_s / CYCLE_S + 1e-9, 1.0)
    worn_s = (cycle + max(2.0 * phase - 1.0, 0.0)) * CYCLE_S
    depth_m = np.full(PATCHES, rate_m_per_h * worn_s / 3600.0)
    depth_m[WORN_ROW] *= 2.0
    mean_m = float(depth_m.mean())
    return {"worn_m3": 0.06 * mean_m, "mean_m": mean_m, "depth_m": depth_m}


def _events(path: Path, cycles: int) -> None:
    """Write the events: what leaves in cycle c was fed ten cycles before, at the same part of the cycle."""
    size_of = np.repeat(np.tile([0, 1, 2], 3), LEAVES.ravel())
    exit_of = np.repeat(np.repeat([0, 1, 2], 3), LEAVES.ravel())
    each = len(size_of)
    cycle = np.repeat(np.arange(cycles), each)
    fed_s = (cycle + (np.tile(np.arange(each), cycles) + 0.5) / each) * CYCLE_S
    size, out = np.tile(size_of, cycles), np.tile(exit_of, cycles)
    ids = np.arange(1, len(size) + 1)
    left = cycle < cycles - FILLED
    station = np.array([0.1, 0.4, 0.7])[out]
    case = load_judged(ROOT / "cases/quickstart", "draft").case
    position = np.column_stack([station, 0 * station + 0.1, 0 * station]) @ axes(case).T
    tables = {
        "fed": {"id": ids, "time_s": fed_s, "sieve_size_m": SIZES_M[size]},
        "removed": {
            "id": ids[left],
            "time_s": (fed_s + FILLED * CYCLE_S)[left],
            "position_m": position[left],
            "velocity_m_per_s": 0 * position[left],
            "sieve_size_m": SIZES_M[size][left],
            "exit": out[left],
            **_contacts(out[left]),
        },
    }
    with h5py.File(path, "a") as history:
        for name, table in tables.items():
            table["density_kg_per_m3"] = np.full(len(table["id"]), DENSITY)
            table["material"] = table["shape"] = 0 * table["id"]
            for key, values in table.items():
                history[f"{name}/{key}"] = values
        for name in tables:
            history[name].attrs.update(shape_attributes(SHAPES))
        history["removed"].attrs["names"] = ["one", "two", "end"]
        history["removed"].attrs["products"] = ["undersize", "undersize", "oversize"]
        history["removed"].attrs["panels"] = ["deck-1", "deck-2"]


def _contacts(out: Array) -> dict[str, Array]:
    """Everyone touches the first panel once and spends half a second over it, a tenth of that within reach;
    who does not pass there goes on to the second one, with two contacts."""
    on = out > 0
    over_s = np.column_stack([np.full(len(out), 0.5), np.where(on, 0.25, 0.0)])
    return {
        "contacts": np.column_stack([np.ones_like(out), np.where(on, 2, 0)]),
        "over_s": over_s,
        "within_reach_s": 0.1 * over_s,
        "last_panel": np.where(on, 1, 0),
    }


def _snapshots(place: Path, case: Case, particles: bool, cycles: int) -> None:
    surface = Series(place, "surface")
    cloud = Series(place, "particles") if particles else None
    rng = np.random.default_rng(1)
    for i in range(6):
        time = cycles * CYCLE_S - (5 - i) * CYCLE_S / 6
        points, triangles, panel = [], [], []
        for number, single in enumerate(single_panels(case)):
            line = panel_line(case, single.name, time) + moved(case, 0, PANEL_M, time)
            half = 0.5 * single.rectangle.width_m * single.rectangle.across
            first = len(points) * 42
            points.append(np.vstack([line - half, line + half]))
            a = first + np.arange(20)
            triangles += [np.column_stack([a, a + 1, a + 22]), np.column_stack([a, a + 22, a + 21])]
            panel.append(np.full(40, number))
        position = np.vstack(points)
        motion = Motion(position, np.zeros_like(position))
        surface.add(time, surface_mesh(motion, np.vstack(triangles), np.concatenate(panel), {}, {}))
        if cloud is not None:
            n = 60
            place_m = np.column_stack(
                [rng.uniform(0, 0.6, n), rng.uniform(0, 0.2, n), 0.02 + 0 * rng.uniform(size=n)]
            )
            world = place_m @ axes(case).T
            still = np.zeros((n, 3))
            cloud.add(
                time,
                particle_mesh(
                    ParticleSnapshot(
                        np.arange(n),
                        world,
                        np.tile([0.3, 0.0, 0.0], (n, 1)),
                        still,
                        spheres(np.full(n, 0.01), DENSITY),
                    )
                ),
            )


def _summary(particles: bool, cycles: int) -> dict[str, object]:
    parts = {"particles": 6.0, "panel": 3.0, "frames": 0.5, "mapping": 0.3, "output": 0.1, "rest": 0.1}
    return {
        "status": "done",
        "doubts": [],
        "stability": {"scheme": "particles-first"},
        "reason": "",
        "case": "by-hand",
        "level": "draft",
        "left_out": {"frame-rotation": "frames.solver two-mass: frames translate only"},
        "effects": {"frame-rotation": {"before": ROTATION, "after": None}},
        "cycle_s": CYCLE_S,
        "wall_s": 10.0,
        "wall_by_part_s": parts,
        "particle_steps_per_s": 1e6 if particles else 0.0,
        "sync_intervals": 80 * cycles,
        "simulated_s": cycles * CYCLE_S,
        "particles": 100 if particles else 0,
        "momentum_residual_relative": 1e-13,
        "energy_ledger_J": {"supplied.frames.exciter": 9.0, "created.panel-frames": 1e-6},
        "energy_exchanged_J": {"panel-frames": 4.0},
    }


def results_table(folder: Path) -> dict[str, Any]:
    """Return the results of a run as ``summary.json`` has them."""
    table: dict[str, Any] = to_json(compute_results(folder))
    return table


def parsed(table: dict[str, Any]) -> Results:
    """Return results from a table as ``summary.json`` has it."""
    return parse_results({"results": table})
