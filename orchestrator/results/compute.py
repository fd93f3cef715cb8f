"""All results of a run, from its folder: the table ``results`` of ``summary.json``."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from orchestrator.casefile.contents import has_particles
from orchestrator.casefile.slice import share
from orchestrator.deck.line import DeckLine, deck_line
from orchestrator.deck.opening_places import openings_m
from orchestrator.results import machine_figures as machine
from orchestrator.results.deck_figures import bed_figures, held_figures
from orchestrator.results.estimate import Estimate
from orchestrator.results.events import read
from orchestrator.results.run_data import RunData, cut_size_m, run_data
from orchestrator.results.screening_figures import screening
from orchestrator.results.steady_events import Events, balanced
from orchestrator.results.transport_figures import transport
from orchestrator.results.wear_figures import wear_figures

NO_EXITS = "no exits: undersize and oversize are not told apart"
FEWEST_ROWS = 4  # in a cycle: an amplitude, a phase and a mean have three unknowns
NO_CUT = "no openings and no output.cut_size_m: fine and coarse are not told apart"


def results(folder: Path) -> dict[str, Any]:
    """Plain numbers, lists and None, documented in docs/run-folder.md; ``missing`` says what could
    not be computed and why.  Raises OSError or CaseError if the folder holds no run."""
    with h5py.File(folder / "history.h5") as history:
        found: dict[str, Any] = plain(_gathered(run_data(folder, history)))
        return found


def _gathered(data: RunData) -> dict[str, Any]:
    found: dict[str, Any] = {"missing": {}, "share_of_width": share(data.case.whole)}
    if len(data.edges_s) < 2:
        found["missing"]["everything"] = "the run did not last for one cycle of the machine"
        return found
    events = _events(data, found)
    if has_particles(data.case):
        _add_bed(data, events, found)
    else:
        found["missing"]["screening"] = "the case has no particles"
    _add_machine(data, events, found)
    if "wear" in data.history and "motion" in found:
        _add_wear(data, found)
    return found


def _events(data: RunData, found: dict[str, Any]) -> Events | None:
    tables = read(data.history)
    if tables is None:
        return None
    events = balanced(*tables, data.edges_s)
    state = events.steady
    found["steady"] = {
        "is_steady": not state.reason,
        "reason": state.reason,
        "start_s": float(data.edges_s[state.first]),
        "end_s": float(data.edges_s[state.last]),
        "cycles": state.last - state.first,
        "imbalance_percent": None if state.imbalance is None else 100 * state.imbalance,
        "drift_percent": None if state.drift is None else 100 * state.drift,
    }
    return events


def _add_bed(data: RunData, events: Events | None, found: dict[str, Any]) -> None:
    if events is not None and events.exits.names:
        cut_m = cut_size_m(data.case)
        found["screening"] = screening(events, cut_m)
        found["transport"] = transport(events, _deck(data))
        if cut_m is None:
            found["missing"]["efficiency"] = NO_CUT
    else:
        found["missing"]["screening"] = NO_EXITS
    if "profile" not in data.history:
        found["missing"]["bed"] = "the panels form no deck in which one follows the other"
        return
    steady = found.get("steady", {"start_s": 0.0, "end_s": data.end_s, "is_steady": False})
    times = (steady["start_s"], steady["end_s"], steady["is_steady"])
    found["bed"] = bed_figures(data, *times)
    found["held"] = {"openings": len(openings_m(data.case)), **held_figures(data, *times)}


def _add_machine(data: RunData, events: Events | None, found: dict[str, Any]) -> None:
    rows = machine.rows_in_cycle(data)
    if rows < FEWEST_ROWS:
        found["missing"]["motion"] = (
            f"the series have {rows:.2g} rows in a cycle of {data.cycle_s:.3g} s; "
            f"{FEWEST_ROWS} are needed (output.series_s)"
        )
        return
    start_s, end_s = motion_window(data, events)
    found["motion"] = {
        "start_s": start_s,
        "end_s": end_s,
        "frames": machine.frame_points(data, start_s, end_s),
        "relative": machine.relative_motion(data, start_s, end_s),
        "panel_points": machine.panel_points(data, start_s, end_s),
        "panels": machine.panel_loads(data, start_s, end_s),
    }
    if not found["motion"]["panel_points"]:
        found["missing"]["panel acceleration"] = "no probe is on a panel"


def _add_wear(data: RunData, found: dict[str, Any]) -> None:
    start_s, end_s = found["motion"]["start_s"], found["motion"]["end_s"]
    is_steady = found.get("steady", {}).get("is_steady", False)
    figures = wear_figures(data, start_s, end_s, is_steady, _deck(data))
    if figures is None:
        found["missing"]["wear"] = "fewer than two output times in the part that is averaged over"
    else:
        found["wear"] = figures


def motion_window(data: RunData, events: Events | None) -> tuple[float, float]:
    """The steady state of the bed, or else the last half of the whole cycles."""
    edges = data.edges_s
    if events is not None and not events.steady.reason:
        return float(edges[events.steady.first]), float(edges[events.steady.last])
    return float(edges[(len(edges) - 1) // 2]), float(edges[-1])


def _deck(data: RunData) -> DeckLine | None:
    names = data.names("panels")
    return deck_line([data.history[f"panels/{name}/centre_line_m"][0] for name in names])


def plain(value: Any) -> Any:
    """As JSON has it: estimates as tables, arrays as lists, None for what is not a number."""
    if isinstance(value, Estimate):
        return plain(asdict(value))
    if isinstance(value, dict):
        return {key: plain(inner) for key, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(inner) for inner in value]
    if isinstance(value, np.ndarray):
        return [plain(inner) for inner in value.tolist()]
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value
